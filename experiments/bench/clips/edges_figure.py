"""The figure of single edges: what the stimulus is, HS with either pathway blocked, and what is left of HS."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import MaxNLocator

from experiments.bench.clips import thresholds as threshold_lines
from experiments.bench.clips.judging import DSNN, LEAST_OF_OTHER, MOST_OF_DRIVEN, strongest
from experiments.bench.figures.palette import Mark, marks
from experiments.bench.figures.plotting import (
    LETTER_INCHES,
    STYLE,
    TYPE,
    WIDTH,
    columns_of_key,
    extra_widths,
    plain,
    wrapped,
)

Rows = Sequence[Mapping[str, Any]]

CASES = {
    "off": ("OFF edge: it darkens", ("dark object, leading edge", "light object, trailing edge")),
    "on": ("ON edge: it brightens", ("dark object, trailing edge", "light object, leading edge")),
}
"""Polarity -> its name, and which edges of objects it is."""
DARK, LIGHT, MARK, INK = "#4a4a4a", "#f4f4f4", "#c21f3a", "#222222"
SKY = "#b9b9b9"
"""The ground in the icons, between the greys of the two objects."""
NAMES = {DSNN: "intact", "dsnn-on-blocked": "ON blocked", "dsnn-off-blocked": "OFF blocked"}
WIDTHS = (1.15, 1.0, 1.3)
"""Widths of the stimulus's icons, of a panel of traces, and of the bars: relative to each other."""
SAME = 0.004
"""Potentials that differ by less look like one curve."""
BAR_INCHES = 0.22
"""Least room of a bar whose words stand upright, inches. Where bars have less, they are in rows of their own."""
BOUND_INCHES = 0.5
"""Room of the numbers at the bounds, right of the bars, inches."""
HIGH, LOWER, BARS_HIGH, KEY_HIGH = 2.55, 2.0, 1.2, 0.17
"""Heights of a row of panels with bars beside them, and with bars below, of a row of bars without their words, and of
a line of the key, inches."""


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
    with mpl.rc_context(STYLE):
        others = [_said(model) for model in models if model != DSNN]
        ratios: tuple[float, ...] = (WIDTHS[0], *[WIDTHS[1]] * len(motions), WIDTHS[2])
        beside = WIDTH * WIDTHS[2] / sum(ratios) - 0.45
        below = BAR_INCHES * len(others) > beside - BOUND_INCHES
        bar_inches = (WIDTH - 0.6, BARS_HIGH - 0.3) if below else (beside, HIGH - 1.2)
        heights, words = [HIGH] * len(polarities), 0.0
        if not others:
            ratios = ratios[:-1]
        elif below:  # the bars of all polarities on each other, with the models' names below the last
            words = max(map(len, others), default=0) * LETTER_INCHES if _upright(others, bar_inches[0]) else 0.3
            ratios, heights = ratios[:-1], [*[LOWER] * len(polarities), *[BARS_HIGH] * len(polarities)]
        keys = [Line2D([], [], label=_named(model), **_look(model, mark, 1)) for model, mark in looks.items()]
        keys += threshold_lines.keys(thresholds, models)
        across = columns_of_key([line for key in keys for line in str(key.get_label()).split("\n")], WIDTH, 8)
        size = (WIDTH, sum(heights) + words + KEY_HIGH * -(-len(keys) // across) + 0.8)
        drawn = Figure(figsize=size, layout="constrained")
        grid = drawn.add_gridspec(len(heights), len(ratios), width_ratios=ratios, height_ratios=heights)
        highest = max([strongest(row, "hs") for row in rows] + [t for t in thresholds.values() if t is not None])
        for down, polarity in enumerate(polarities):
            icons, *places = (drawn.add_subplot(grid[down, place]) for place in range(len(ratios)))
            traces = places[: len(motions)]
            edge_rows = [row for row in rows if row["polarity"] == polarity]
            _icons(icons, polarity)
            for axes, (motion, speed) in zip(traces, motions, strict=True):
                here = [row for row in edge_rows if (row["motion"], row["speed"]) == (motion, speed)]
                _traces(axes, here, frames, looks)
                axes.set_ylim(-1.12 * highest, 1.12 * highest)
                threshold_lines.draw(axes, thresholds, models)
                axes.tick_params(labelsize=8, labelleft=axes is traces[0])
                axes.set_title(f"{motion},\n{speed:g} px/s", fontsize=8)
                axes.set_xlabel("time (s)", fontsize=8)
            traces[0].set_ylabel("HS, right positive", fontsize=8)
            if not others:
                continue
            bars = drawn.add_subplot(grid[len(polarities) + down, :]) if below else places[-1]
            _bars(bars, edge_rows, left, looks, bar_inches)
            if below:
                bars.tick_params(axis="x", labelbottom=polarity == polarities[-1])
                bars.set_title(f"{CASES[polarity][0].partition(':')[0]}: {bars.get_title()}", fontsize=8)
        drawn.legend(handles=keys, loc="outside lower center", ncols=across, frameon=False, fontsize=8)
    return drawn


def _said(model: str) -> str:
    return NAMES.get(model) or plain(model)


def _named(model: str) -> str:
    return f"{model} ({NAMES[model]})" if model in NAMES else plain(model)


def _icons(axes: Axes, polarity: str) -> None:
    """Draw both objects that have such an edge, the edge marked; and luminance over time where the edge passes."""
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
        words = axes.text(0.2, bottom - 0.15, caption.replace(", ", ",\n"), fontsize=8, va="top", color=INK)
        words.set_in_layout(False)  # they fit; the layout would narrow all panels by what stands out of a narrow one
    high, low = (2.2, 0.9) if polarity == "off" else (0.9, 2.2)
    axes.plot([0.2, 4.9, 4.9, 9.6], [high, high, low, low], color=INK, lw=1.5)
    axes.plot([4.9, 4.9], [0.9, 2.2], color=MARK, lw=2.2)
    axes.text(0.2, 0.55, "luminance\nwhere it passes", fontsize=8, va="top", color=INK).set_in_layout(False)


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


def _upright(names: Sequence[str], inches: float) -> bool:
    """Tell whether bars that are so many ``inches`` wide together have no room for words and numbers side by side."""
    longest = max((len(word) for name in names for word in ("100 to", *name.split(" "))), default=0)
    return (longest + 1) * LETTER_INCHES * len(names) > inches - BOUND_INCHES


def _bars(
    axes: Axes, rows: Rows, left: Mapping[tuple[str, str], float], looks: Mapping[str, Mark],
    inches: tuple[float, float],
) -> None:  # fmt: skip
    """Draw for each model a bar at the mean of its shares over the clips, and a dot for each clip.

    The panel is of about so many ``inches``.
    """
    clips = list(dict.fromkeys(row["clip"] for row in rows))
    others = [model for model in looks if model != DSNN and any((clip, model) in left for clip in clips)]
    shares = {model: [100.0 * left[clip, model] for clip in clips if (clip, model) in left] for model in others}
    upright = _upright([_said(model) for model in others], inches[0])
    texts = {model: _range_text(values, "\u2013" if upright else " to\n") for model, values in shares.items()}
    highest = {model: max(values) for model, values in shares.items()}
    above = {model: len(text) * LETTER_INCHES if upright else 2.5 * TYPE / 72.0 for model, text in texts.items()}
    top = max([110.0, *(highest[model] / (0.92 - above[model] / inches[1]) for model in others)])
    for place, model in enumerate(others):
        axes.bar(place, float(np.mean(shares[model])), width=0.62, color=looks[model].colour, alpha=0.75)
        beside = place + np.linspace(-0.2, 0.2, len(shares[model]))
        axes.plot(beside, shares[model], "o", ms=3, color=INK, zorder=3)
        # Over the line at 5 %, and clear of the highest dot.
        axes.text(place, max(highest[model], 100.0 * MOST_OF_DRIVEN) + 0.04 * top, texts[model], fontsize=8,
                  ha="center", va="bottom", rotation=90 if upright else 0, linespacing=0.95,
                  bbox={"fc": "white", "lw": 0, "pad": 0.4}, zorder=4)  # fmt: skip
    bounds = {100.0 * bound: f"{100 * bound:g} %" for bound in (MOST_OF_DRIVEN, LEAST_OF_OTHER)}
    for bound in bounds:
        axes.axhline(bound, color=MARK, ls="--", lw=0.9)
    if (max(bounds) - min(bounds)) / top * inches[1] < 1.3 * TYPE / 72.0:  # their numbers would lie on each other
        bounds = {max(bounds): f"{min(bounds):g}, {max(bounds):g} %"}
    for bound, words in bounds.items():
        axes.annotate(words, (1.0, bound), xycoords=("axes fraction", "data"), fontsize=8, color=MARK, ha="right",
                      va="bottom")  # fmt: skip
    names = [_said(model) if upright else _said(model).replace(" ", "\n") for model in others]
    axes.set_xticks(range(len(others)), names, fontsize=8, rotation=90 if upright else 0)
    room = len(others) * BOUND_INCHES / (inches[0] - BOUND_INCHES)
    axes.set(ylim=(0.0, top), xlim=(-0.5, len(others) - 0.5 + room))
    if top <= 200.0:
        axes.set_yticks([0, 25, 50, 75, 100])
    else:
        axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.tick_params(axis="y", labelsize=8)
    axes.set_title(wrapped("largest |HS|, % of intact", inches[0] + 0.4, 8), fontsize=8)


def _range_text(shares: Sequence[float], between: str) -> str:
    """Return the least and the greatest of some shares, or the one number that they all are."""
    least, most = (f"{end:.0f}" if end >= 10.0 else f"{end:.2g}" for end in (min(shares), max(shares)))
    return f"{least} %" if least == most else f"{least}{between}{most} %"
