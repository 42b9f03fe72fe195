"""The figure of single edges: what the stimulus is, HS with either pathway blocked, and what is left of HS."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from experiments.bench.clips import thresholds as threshold_lines
from experiments.bench.clips.judging import DSNN, LEAST_OF_OTHER, MOST_OF_DRIVEN, strongest
from experiments.bench.figures.palette import Mark, marks
from experiments.bench.figures.plotting import (
    LETTER_INCHES,
    PAGE,
    STYLE,
    WIDTH,
    columns_of_key,
    extra_widths,
    plain,
    rows_inches,
    wrapped,
)

Rows = Sequence[Mapping[str, Any]]

CASES = {
    "off": ("OFF edge: luminance falls", ("dark object, leading edge", "light object, trailing edge")),
    "on": ("ON edge: luminance rises", ("dark object, trailing edge", "light object, leading edge")),
}
"""Polarity -> its name, and which edges of objects it is."""
DARK, LIGHT, MARK, INK = "#4a4a4a", "#f4f4f4", "#c21f3a", "#222222"
SKY = "#b9b9b9"
"""The ground in the icons, between the greys of the two objects."""
NAMES = {DSNN: "intact", "dsnn-on-blocked": "ON blocked", "dsnn-off-blocked": "OFF blocked"}
CLEAR = 7.0
"""Distance of a bar's numbers above its highest dot, per cent: over the line at 5 %."""
WIDTHS = (1.15, 1.0, 0.95)
"""Widths of the stimulus's icons, of a panel of traces, and of the bars: relative to each other."""
SAME = 0.004
"""Potentials that differ by less look like one curve."""
MOST_BARS = 2.6
"""Width of the bars of a polarity, inches: wider ones lie below the traces, with their names beside them."""
LEAST_BAR, BARS_AROUND = 0.47, 0.4
"""Least width of a bar with its words, and of what is beside the bars, inches."""
HIGH, LOW, AXIS_HIGH, KEY_HIGH = 2.55, 2.25, 0.75, 0.17
"""Heights of a row of panels, and with many models; of what is above and below bars that lie; of a line of the key."""
TITLE_HIGH = 0.8
"""Height of the title and of what is around the key, inches."""
BOUNDS = (100.0 * MOST_OF_DRIVEN, 100.0 * LEAST_OF_OTHER)
"""Bounds of C22, per cent."""
ROOM_OF_NUMBERS, ROOM_ABOVE = 0.45, 0.4
"""Room for the numbers right of the longest bar that lies, and above the highest, as shares of it."""
USUAL = 118.0
"""Least height of the axis of bars, per cent."""
MOST_QUARTERS, MOST_APART = 150.0, 700.0
"""Largest share, per cent, up to which the axis has quarters, and height of the axis up to which the numbers at the
bounds keep clear of each other."""
MARK_POINTS = 6.0
"""Distance of a model's marker from its bar that lies, points."""


def shares(rows: Rows) -> dict[tuple[str, str], float]:
    """The largest |HS| of each model relative to that of the network as it is.

    Parameters
    ----------
    rows
        Of ``trials.parquet``, of one seed.

    Returns
    -------
    dict
        (clip, model) -> its share; NaN where the network as it is does not answer. Clips that it was not shown are
        left out.
    """
    intact = {row["clip"]: strongest(row, "hs") for row in rows if row["model"] == DSNN}
    return {
        (row["clip"], row["model"]): strongest(row, "hs") / intact[row["clip"]] if intact[row["clip"]] else float("nan")
        for row in rows
        if row["model"] != DSNN and row["clip"] in intact
    }


def draw(rows: Rows, frames: pa.Table, thresholds: Mapping[str, float | None]) -> Figure:
    """Draw a row of panels for each polarity of the edge.

    Parameters
    ----------
    rows
        Of ``trials.parquet``, of one seed: clips of a single edge.
    frames
        Of ``frames.parquet``.
    thresholds
        Of the models' potentials.

    Returns
    -------
    matplotlib.figure.Figure
        Of each polarity: which edges of objects it is, HS of every model for each direction and speed, and bars of
        the largest |HS| relative to that of the network as it is, with the bounds of C22.
    """
    models = list(dict.fromkeys(row["model"] for row in rows))
    polarities = [polarity for polarity in CASES if any(row["polarity"] == polarity for row in rows)]
    motions = sorted({(row["motion"], row["speed"]) for row in rows}, key=lambda pair: (pair[0] != "rightward", *pair))
    looks, left = marks(models), shares(rows)
    others = [model for model in models if any((row["clip"], model) in left for row in rows)]
    of_bars = _bars_inches(others)
    below = of_bars > MOST_BARS
    with mpl.rc_context(STYLE):
        ratios = [WIDTHS[0], *[WIDTHS[1]] * len(motions)]
        ratios += [] if below or not others else [max(WIDTHS[2], sum(ratios) * of_bars / (WIDTH - of_bars))]
        keys = [Line2D([], [], label=_named(model), **_look(model, mark, 1)) for model, mark in looks.items()
                if not (below and model in others)]  # fmt: skip
        keys += [*threshold_lines.keys(thresholds, models, sign="±"), *(_keys_of_bars() if others else [])]
        across = columns_of_key([line for key in keys for line in str(key.get_label()).split("\n")], WIDTH, 8)
        upper, words = len(polarities) * (LOW if below else HIGH), TITLE_HIGH + KEY_HIGH * -(-len(keys) // across)
        lower = rows_inches(len(others), PAGE - upper - words - AXIS_HIGH) + AXIS_HIGH if below else 0.0
        drawn = Figure(figsize=(WIDTH, upper + lower + words), layout="constrained")
        split: Any = drawn.subfigures(2, 1, height_ratios=[upper, lower]) if below else [drawn]
        parts = list(split)
        grid = parts[0].add_gridspec(len(polarities), len(ratios), width_ratios=ratios)
        lying = parts[1].subplots(1, len(polarities), sharey=True, squeeze=False)[0] if below else []
        highest = max([strongest(row, "hs") for row in rows] + [t for t in thresholds.values() if t is not None])
        for down, polarity in enumerate(polarities):
            icons, *places = (parts[0].add_subplot(grid[down, place]) for place in range(len(ratios)))
            traces = places[: len(motions)]
            edge_rows = [row for row in rows if row["polarity"] == polarity]
            _icons(icons, polarity, 2.0 if below else 1.0)
            for axes, (motion, speed) in zip(traces, motions, strict=True):
                here = [row for row in edge_rows if (row["motion"], row["speed"]) == (motion, speed)]
                _traces(axes, here, frames, looks)
                axes.set_ylim(-1.12 * highest, 1.12 * highest)
                threshold_lines.draw(axes, thresholds, models, signed=True)
                axes.tick_params(labelsize=8, labelleft=axes is traces[0])
                axes.set_title(f"{motion},\n{speed:g} px/s", fontsize=8)
                axes.set_xlabel("time (s)", fontsize=8)
            traces[0].set_ylabel("HS potential\n(right positive)", fontsize=8)
            if below:
                _lying_bars(lying[down], CASES[polarity][0], _by_clip(edge_rows, left, others), looks)
            elif others:
                _bars(places[-1], _by_clip(edge_rows, left, others), looks)
        drawn.legend(handles=keys, loc="outside lower center", ncols=across, frameon=False, fontsize=8)
    return drawn


def _bars_inches(models: Sequence[str]) -> float:
    """Return the width of upright bars with the names of ``models`` below them."""
    words = [word for model in models for word in _said(model).split()]
    return (len(models) + 0.5) * max(LEAST_BAR, *(LETTER_INCHES * (len(word) + 1) for word in words), 0.0) + BARS_AROUND


def _said(model: str) -> str:
    return NAMES.get(model) or plain(model)


def _named(model: str) -> str:
    return f"{model} ({NAMES[model]})" if model in NAMES else plain(model)


def _icons(axes: Axes, polarity: str, inches: float) -> None:
    """Draw both objects that have such an edge, the edge marked; and luminance over time where the edge passes.

    Captions are ``inches`` wide.
    """
    name, cases = CASES[polarity]
    axes.set(xlim=(0, 10), ylim=(0, 12.4))
    axes.set_axis_off()
    axes.set_title(name.replace(": ", ":\n"), fontsize=8, loc="left", color=INK, fontweight="bold")
    for bottom, caption in zip((9.9, 5.4), cases, strict=True):
        dark, leading = caption.startswith("dark"), caption.endswith("leading edge")
        axes.add_patch(Rectangle((0.2, bottom), 9.4, 1.6, fc=SKY, ec="none"))
        axes.add_patch(Rectangle((3.2, bottom), 3.0, 1.6, fc=DARK if dark else LIGHT, ec="none"))
        edge = 6.2 if leading else 3.2
        axes.plot([edge, edge], [bottom, bottom + 1.6], color=MARK, lw=2.6, solid_capstyle="butt")
        axes.annotate("", (9.2, bottom + 0.8), (6.8, bottom + 0.8), arrowprops={"arrowstyle": "->", "color": INK})
        axes.text(0.2, bottom - 0.15, wrapped(caption, inches, 8), fontsize=8, va="top", color=INK)
    high, low = (2.2, 0.9) if polarity == "off" else (0.9, 2.2)
    axes.plot([0.2, 4.9, 4.9, 9.6], [high, high, low, low], color=INK, lw=1.5)
    axes.plot([4.9, 4.9], [0.9, 2.2], color=MARK, lw=2.2)
    axes.text(0.2, 0.55, "luminance\nwhere it passes", fontsize=8, va="top", color=INK)


def _traces(axes: Axes, rows: Rows, frames: pa.Table, looks: Mapping[str, Mark]) -> None:
    """HS of every model over one clip."""
    trial, name, hs = (frames[column].to_numpy(zero_copy_only=False) for column in ("trial", "model", "hs"))
    axes.axhline(0.0, color="black", lw=0.4)
    curves = [hs[(trial == row["trial"]) & (name == row["model"])] for row in rows]
    for row, curve, extra in zip(rows, curves, extra_widths(curves, SAME), strict=True):
        look = _look(row["model"], looks[row["model"]], len(curve), extra)
        axes.plot(np.arange(len(curve)) / row["fps"], curve, label=row["model"], **look)


def _look(model: str, mark: Mark, count: int, extra: float = 0.0) -> dict[str, Any]:
    """Return how a line of ``count`` points is drawn: wide and pale for the network as it is, which others lie on."""
    if model == DSNN:
        return {"color": mark.colour, "lw": 4.0 + extra, "alpha": 0.45}
    dots = {"marker": mark.marker, "ms": 3.0 + extra, "markevery": max(count // 6, 1)}
    return {"color": mark.colour, "lw": 1.2 + extra, **dots}


def _by_clip(rows: Rows, left: Mapping[tuple[str, str], float], models: Sequence[str]) -> dict[str, list[float]]:
    """Return the shares of each model over the clips, per cent; none of a model that was not shown them."""
    clips = list(dict.fromkeys(row["clip"] for row in rows))
    return {model: [100.0 * left[clip, model] for clip in clips if (clip, model) in left] for model in models}


def _reach(shares: Sequence[float], gap: str) -> str:
    """Return the smallest and largest share in words, with ``gap`` between them."""
    if max(shares) - min(shares) < 0.05:
        return f"{min(shares):.3g} %"
    return f"{min(shares):.0f} to{gap}{max(shares):.0f} %"


def _bars(axes: Axes, left: Mapping[str, Sequence[float]], looks: Mapping[str, Mark]) -> None:
    """Draw for each model a bar at the mean of its shares over the clips, and a dot for each clip."""
    others = [model for model, shares in left.items() if shares]
    highest = max((share for shares in left.values() for share in shares), default=0.0)
    top = max(USUAL, (1.0 + ROOM_ABOVE) * highest if highest > 101.0 else 0.0)
    for place, model in enumerate(others):
        shares = left[model]
        axes.bar(place, float(np.mean(shares)), width=0.62, color=looks[model].colour, alpha=0.75)
        axes.plot(place + np.linspace(-0.2, 0.2, len(shares)), shares, "o", ms=3, color=INK, zorder=3)
        axes.text(place, max(shares) + CLEAR * top / USUAL, _reach(shares, "\n"), fontsize=8, ha="center", va="bottom",
                  bbox={"fc": "white", "lw": 0, "pad": 0.4}, zorder=4)  # fmt: skip
    for bound in BOUNDS:
        axes.axhline(bound, color=MARK, ls="--", lw=0.9)
    words = {bound: f"{bound:g} %" for bound in BOUNDS}
    if top > MOST_APART:
        words = {max(BOUNDS): ", ".join(f"{bound:g}" for bound in sorted(BOUNDS)) + " %"}
    for bound, text in words.items():
        axes.annotate(text, (1.0, bound), xycoords=("axes fraction", "data"), fontsize=8, color=MARK, ha="right",
                      va="bottom")  # fmt: skip
    axes.set_xticks(range(len(others)), [_said(model).replace(" ", "\n") for model in others], fontsize=8)
    axes.set(ylim=(0.0, top), xlim=(-0.5, len(others) + (0.5 if len(words) == 1 else 0.0)))
    _per_cent(axes.yaxis, highest)
    axes.tick_params(axis="y", labelsize=8)
    axes.set_title("largest |HS|\n(% of dsnn's)", fontsize=8)


def _lying_bars(axes: Axes, title: str, left: Mapping[str, Sequence[float]], looks: Mapping[str, Mark]) -> None:
    """Draw the bars of `_bars` below each other, each beside its model's name and marker."""
    whole = axes.get_figure(root=True)
    assert whole is not None
    aside = ScaledTranslation(-MARK_POINTS / 72, 0.0, whole.dpi_scale_trans)
    longest = max([100.0, *(share for shares in left.values() for share in shares)])
    for place, (model, shares) in enumerate(left.items()):
        tint, marker = looks[model].colour, looks[model].marker
        axes.plot(0.0, place, marker, ms=4, color=tint, transform=axes.transData + aside, clip_on=False)
        if shares:
            axes.barh(place, float(np.mean(shares)), height=0.7, color=tint, alpha=0.75)
            axes.plot(shares, place + np.linspace(-0.2, 0.2, len(shares)), "o", ms=2, color=INK, zorder=3)
            beside = max(shares) + CLEAR / 2 * longest / 100.0
            axes.text(beside, place, _reach(shares, " "), fontsize=8, va="center", zorder=4,
                      bbox={"fc": "white", "lw": 0, "pad": 0.4})  # fmt: skip
    for bound in BOUNDS:
        axes.axvline(bound, color=MARK, ls="--", lw=0.9)
    axes.set_yticks(range(len(left)), [_named(model) for model in left], fontsize=8)
    axes.tick_params(axis="y", length=0, pad=2 * MARK_POINTS)
    _per_cent(axes.xaxis, longest)
    axes.set(ylim=(len(left) - 0.5, -0.5), xlim=(0.0, (1.0 + ROOM_OF_NUMBERS) * longest))
    axes.set_xlabel("largest |HS| (% of that of dsnn)", fontsize=8)
    axes.set_title(title, fontsize=8, loc="left")


def _per_cent(axis: Axis, highest: float) -> None:
    """Put quarters on an axis, or round numbers where a model answers much more than the network as it is."""
    if highest <= MOST_QUARTERS:
        axis.set_ticks([0, 25, 50, 75, 100])
    else:
        axis.set_major_locator(MaxNLocator(4))


def _keys_of_bars() -> list[Line2D]:
    """Return what stands at the bars, whose height is a mean."""
    low, high = (f"{bound:g}" for bound in BOUNDS)
    return [
        Line2D([], [], color=INK, ls="", marker="o", ms=3, label="a clip; bar: mean of clips"),
        Line2D([], [], color=MARK, ls="--", lw=0.9, label=f"C22, blocked pathway: {low} and {high} %"),
    ]
