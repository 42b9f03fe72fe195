"""Figures of tuning curves: one a family, each model in its colour."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.projections.polar import PolarAxes
from matplotlib.ticker import FuncFormatter, NullLocator

from experiments.bench.figures.palette import colours, marks
from experiments.bench.figures.plotting import (
    STYLE,
    WIDTH,
    columns_of_key,
    extra_widths,
    headline,
    key_below,
    plain,
    wrapped,
)
from experiments.bench.store.parameters import in_title
from experiments.bench.tuning import approach_figure
from experiments.bench.tuning.curves import (
    NOTHING,
    TuningPoint,
    best_rows,
    curve,
    directional,
    grid,
    lobes,
    selectivity,
)
from experiments.bench.tuning.defined import LEAST_POINTS, undefined_peak
from experiments.bench.tuning.preferences import direction_undefined
from experiments.bench.tuning.probes import Family

Answers = Sequence[TuningPoint]
Channels = Mapping[str, Sequence[str]]
ACROSS, MANY_ACROSS = 3, 5
"""Most panels side by side: of up to `MANY` models, and of more."""
MANY = 12
SHADES = "RdBu_r"
MORE = {
    "map": "; ○: a column's peak, where it is neither at an end nor flat",
    "approach": "; l/v: half the object's size over its speed",
    "polar": "; DSI: direction selectivity index",
}
"""What the title of a kind of figure explains."""
CURVE_INCHES, KEY_INCHES = 2.9, 0.18
"""Heights of panels of curves with what is around them, and of a line of the key, inches."""
LEAST_RATIO = 4.0
"""From the first to the last place on a logarithmic axis; those nearer, and those from 0, stand on a linear one."""


def draw(family: Family, given: Answers, channels: Channels, changed: Mapping[str, Any]) -> Figure:
    """Draw the figure of one family.

    Parameters
    ----------
    family
        What was shown.
    given
        The models' responses to it.
    channels
        By what each model answers.
    changed
        Parameters that are not at their defaults, by key and model; the title names them.

    Returns
    -------
    matplotlib.figure.Figure
        In the form that the family's ``kind`` names.
    """
    with mpl.rc_context(STYLE):
        drawings = {"curve": _curves, "map": _maps, "polar": _polars, "approach": approach_figure.draw}
        drawn = drawings[family.kind](family, given, channels)
        more = MORE.get(family.kind, "")
        if family.kind in ("curve", "map") and any(_scatters(given, model, family) for model in channels):
            more += "; no peak: responses scatter"
        headline(drawn, f"{family.name}: {family.summary}{more}{in_title(changed)}")
    return drawn


def _largest(given: Answers, model: str, family: Family) -> float:
    return max((abs(a.response) for a in given if (a.model, a.curve) == (model, family.name)), default=0.0)


def _curves(family: Family, given: Answers, channels: Channels) -> Figure:
    """Return a panel for each line: every model's response as a share of its largest in the family."""
    lines, tints = family.lines, marks(channels)
    labels = {model: plain(f"{model} ({_largest_words(given, model, family)})") for model in channels}
    across = min(columns_of_key(list(labels.values()), WIDTH, 8), 3)
    drawn = Figure(figsize=(WIDTH, CURVE_INCHES + KEY_INCHES * -(-len(labels) // across)), layout="constrained")
    panels = drawn.subplots(1, len(lines), sharey=True, squeeze=False)[0]
    for axes, line in zip(panels, lines, strict=True):
        shares = {}
        for model in channels:
            x, response = curve(given, model, family.name, line)
            shares[model] = x, [r / (_largest(given, model, family) or 1.0) for r in response]
        extra = extra_widths([heights for _, heights in shares.values()], 0.01)
        for (model, (x, heights)), more in zip(shares.items(), extra, strict=True):
            mark = tints[model]
            axes.plot(x, heights, marker=mark.marker, ms=3.5 + more, lw=1.2 + more, color=mark.colour)
        places = sorted({probe.x for probe in family.probes if probe.line == line})
        if places[0] > 0 and places[-1] / places[0] >= LEAST_RATIO:
            _log(axes, places)
        axes.axhline(0.0, color="black", lw=0.5)
        axes.set_xlabel(family.x.label)
        axes.set_title(line, fontsize=8)
    panels[0].set_ylabel("response (share of the largest)")
    keys = [
        Line2D([], [], color=tints[model].colour, marker=tints[model].marker, ms=3.5, lw=1.2,
               label=label)
        for model, label in labels.items()
    ]  # fmt: skip
    key_below(drawn, keys, across)
    return drawn


def _largest_words(given: Answers, model: str, family: Family) -> str:
    """Return the largest response in words, and whether there is no peak."""
    largest = _largest(given, model, family)
    if largest <= NOTHING:
        return "no answer"
    return f"largest {largest:.2g}{'; no peak' if _scatters(given, model, family) else ''}"


def _scatters(given: Answers, model: str, family: Family) -> bool:
    """Tell whether the points of a map, or of every curve of a family, are in no order, so that there is no peak."""
    if _largest(given, model, family) <= NOTHING:
        return False
    if family.kind == "map":
        return bool(undefined_peak(grid(given, model, family.name)[2]))
    lines = [curve(given, model, family.name, line)[1] for line in family.lines]
    return all(len(line) >= LEAST_POINTS and undefined_peak(line) for line in lines)


def _log(axes: Axes, ticks: Sequence[float]) -> None:
    """Make an axis logarithmic, labelled at every second of the points shown."""
    axes.set_xscale("log")
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xticks(ticks[::2] if len(ticks) > 6 else ticks)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.tick_params(axis="x", labelsize=8)


def _maps(family: Family, given: Answers, channels: Channels) -> Figure:
    """Return a heat map for each model: both axes in octaves, the best of each column marked, a scale of its own."""
    drawn, panels = _panels(len(channels), 2.0 if len(channels) > 1 else 2.8)
    tints = colours(channels)
    for axes, model in zip(panels, channels, strict=False):
        x, y, response = grid(given, model, family.name)
        axes.set_title(
            plain(
                wrapped(
                    f"{model} ({_largest_words(given, model, family)})",
                    min(1.7, WIDTH / _across(len(channels)) - 0.3),
                    8,
                )
            ),
            fontsize=8,
            color=tints[model],
        )
        if not x:
            continue
        shares = response / (_largest(given, model, family) or 1.0)
        axes.pcolormesh(_edges(x), _edges(y), shares, cmap=SHADES, vmin=-1, vmax=1, rasterized=True)
        if not _scatters(given, model, family):
            axes.plot(x, best_rows(y, response), "o", ms=3.5, mfc="white", mec="black", mew=0.8)
        axes.set(xscale="log", yscale="log")
        step = 2 if len(channels) <= MANY else 4
        for axis, ticks in ((axes.xaxis, x[::step]), (axes.yaxis, y[::2])):
            axis.set_minor_locator(NullLocator())
            axis.set_ticks(ticks)
        axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"1/{1 / value:.0f}"))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.tick_params(labelsize=8)
    drawn.supxlabel(family.x.label, fontsize=8)
    drawn.supylabel(family.y.label if family.y else "", fontsize=8)
    scale = mpl.cm.ScalarMappable(mpl.colors.Normalize(-1, 1), SHADES)
    drawn.colorbar(scale, ax=panels, shrink=0.6 if len(channels) > ACROSS else 1.0, aspect=30).set_label(
        "response (share of the largest)"
    )
    return drawn


def _edges(centres: Sequence[float]) -> list[float]:
    """Cells' edges halfway between their centres on a logarithmic axis."""
    logs = np.log(centres)
    if len(logs) == 1:
        return [centres[0] / 1.2, centres[0] * 1.2]
    inner = (logs[1:] + logs[:-1]) / 2
    return list(map(float, np.exp([2 * logs[0] - inner[0], *inner, 2 * logs[-1] - inner[-1]])))


def _polars(family: Family, given: Answers, channels: Channels) -> Figure:
    """Return a polar plot for each model: its projected response filled, each system's rectified lobe beside it."""
    drawn, panels = _panels(len(channels), 2.4 if len(channels) > 1 else 3.6, projection="polar")
    # The layout reckons the headings of polar panels a little too low: hence more room around them.
    drawn.set_layout_engine("constrained", h_pad=0.12)
    gratings, objects = family.lines
    tints = colours(channels)
    for axes, model in zip(panels, channels, strict=False):
        assert isinstance(axes, PolarAxes)
        tells = directional(channels[model])
        turns, response = curve(given, model, family.name, gratings)
        responses = lobes(given, model, gratings)
        systems = ("hs", "vs") if tells else ()
        _lobes(axes, turns, response, {system: responses[system][1] for system in systems}, tints[model])
        spots, heights = curve(given, model, family.name, objects)
        if spots:  # a line without points that is not clipped has no size, and the layout needs one
            axes.plot(np.radians(spots), _share(heights), "s", ms=5, mfc="white", mec=tints[model], mew=1.4, zorder=5,
                      clip_on=False)  # fmt: skip
        index = selectivity(*responses["hs" if tells else "looming"])
        caption = "no answer" if index is None else f"DSI{' of HS' if tells else ''} {index.dsi:.2f}"
        if direction_undefined(given, model, channels[model]):
            caption = "preference not defined"
        heading = wrapped(f"{model}\n{caption}", WIDTH / _across(len(channels)) - 0.1, 8)
        named = len(channels) <= MANY or axes is panels[0]
        above = 25.0 if named else 6.0  # above "up"
        axes.set_title(plain(heading), fontsize=8, color=tints[model], y=1.0, pad=above)
        _compass(axes, named=named)
    keys = [
        Line2D([], [], color="#555555", lw=1.6, label="response (gratings)"),
        Line2D([], [], color="#555555", marker="s", ls="", mfc="white", label="response (dark object)"),
        Line2D([], [], color="black", lw=0.9, label="HS (gratings)"),
        Line2D([], [], color="black", lw=0.9, ls=":", label="VS (gratings)"),
    ]
    words = ("response: HS and VS along the motion, or looming; radius: share of the largest to that stimulus, 0 where"
             " negative; rings: ½ and 1")  # fmt: skip
    title = wrapped(words, float(drawn.get_size_inches()[0]), 8)
    across = 4 if len(channels) > 1 else 2
    drawn.legend(handles=keys, loc="outside lower center", ncols=across, frameon=False, fontsize=8, title=title,
                 title_fontsize=8)  # fmt: skip
    return drawn


def _lobes(
    axes: PolarAxes,
    turns: Sequence[float],
    response: Sequence[float],
    systems: Mapping[str, Sequence[float]],
    tint: str,
) -> None:
    """Closed lines of a response, filled, and of the systems it is made of, on one scale."""
    scale = _scale([*response, *(value for values in systems.values() for value in values)])
    round_about = np.radians([*turns, *turns[:1]])
    filled = _share([*response, *response[:1]], scale)
    clip = not filled  # a line without points that is not clipped has no size, and the layout needs one
    axes.plot(round_about, filled, color=tint, lw=1.6, clip_on=clip)
    axes.fill(round_about, filled, color=tint, alpha=0.18, lw=0)
    for values, style in zip(systems.values(), ("-", ":"), strict=False):
        axes.plot(round_about, _share([*values, *values[:1]], scale), color="black", lw=0.9, ls=style, clip_on=clip)


def _scale(values: Sequence[float]) -> float:
    largest = max(values, default=0.0)
    return largest if largest > NOTHING else 1.0


def _share(values: Sequence[float], scale: float | None = None) -> Sequence[float]:
    """Shares of ``scale``, or of the largest; none below 0, the centre."""
    whole = scale or _scale(values)
    return [max(value, 0.0) / whole for value in values]


def _compass(axes: PolarAxes, *, named: bool) -> None:
    """Directions as in the image, in words where ``named``: rightward to the right, downward down."""
    axes.set_theta_direction(-1)
    axes.set_xticks(
        [math.pi / 2 * i for i in range(4)], ["right", "down", "left", "up"] if named else [""] * 4, fontsize=8
    )
    axes.set_ylim(0.0, 1.0)
    axes.set_yticks([0.5], [""])
    axes.grid(lw=0.4)


def _across(count: int) -> int:
    """Return how many of so many models' panels stand side by side."""
    return min(ACROSS if count <= MANY else MANY_ACROSS, count)


def _panels(count: int, side: float, **options: str) -> tuple[Figure, list[Axes]]:
    """Return a figure with a square panel for each model, `_across` a row; the rest of the last row is empty."""
    across = _across(count)
    down = -(-count // across)
    side *= 1.0 if across <= ACROSS else 1.3 * ACROSS / across
    drawn = Figure(figsize=(WIDTH if across > 1 else 5.6, side * down + 0.9), layout="constrained")
    panels = list(drawn.subplots(down, across, squeeze=False, subplot_kw=options).flat)
    for axes in panels[count:]:
        axes.set_visible(False)
    return drawn, panels
