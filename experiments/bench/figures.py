"""The figure of a run, in the manner of the paper's Figure 13: spikes per condition, every repeat visible."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pyarrow as pa
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from experiments.bench.declaration import CONDITION_COLUMNS
from experiments.bench.results import group
from experiments.bench.statistics import summarise

Rows = Sequence[Mapping[str, Any]]

AXIS_LABELS = {
    "speed_cm_s": "speed of the stimulus (cm/s)",
    "distance_cm": "distance camera to path (cm)",
    "angle_deg": "angle to the optical axis (degrees)",
}
UNITS = {"speed_cm_s": "cm/s", "distance_cm": "cm", "angle_deg": "°"}
LINES = ("-", ":", "--", "-.", (0, (3, 1, 1, 1, 1, 1)))
COLOURS = ("#3b6fb6", "#2a9d8f", "#d98324", "#b5485d", "#6c5b9e", "#7a7a7a")
LEGEND: dict[str, Any] = {"frameon": False, "loc": "lower center", "bbox_to_anchor": (0.5, 0.99)}
STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.hashsalt": "colias-sim",  # equal runs, equal bytes
    "svg.fonttype": "none",
}


def draw(rows: Rows, frames: pa.Table, varies: str, title: str, threshold: float) -> Figure:
    """Left: spikes of every trial, with means and 95 % intervals. Right: HS against the stimulus's bearing.

    One colour per level of ``varies``; one line style for each combination of the conditions that differ beside it.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.4, 3.6), layout="constrained")
        counts, traces = figure.subplots(1, 2, width_ratios=[1, 1.25])
        levels = sorted({row[varies] for row in rows})
        colours = _colours(levels)
        series = _series(rows, varies)
        for place, (label, chosen) in enumerate(series.items()):
            style = LINES[place % len(LINES)]
            _counts(counts, chosen, varies, colours, _place(place, len(series)), style, label)
            _traces(traces, chosen, frames, varies, colours, style)
        if len(series) > 1:
            counts.legend(fontsize=7, handlelength=3, **LEGEND, ncols=2)
        counts.set_xticks(range(len(levels)), [f"{level:g}" for level in levels])
        counts.set(xlabel=AXIS_LABELS[varies], ylabel="HS spikes per trial", ylim=(-2, None))
        _frame(traces, colours, UNITS[varies], threshold)
        figure.suptitle(title, fontsize=10, x=0.01, ha="left")
    return figure


def _colours(levels: Sequence[float]) -> dict[float, Any]:
    """A colour for each level, none twice."""
    if len(levels) <= len(COLOURS):
        return dict(zip(levels, COLOURS, strict=False))
    return dict(zip(levels, mpl.colormaps["viridis"](np.linspace(0, 0.92, len(levels))), strict=True))


def _series(rows: Rows, varies: str) -> dict[str, Rows]:
    """Label -> its rows, for every combination of the other conditions that differ between trials."""
    others = [c for c in CONDITION_COLUMNS if c != varies and len({row[c] for row in rows}) > 1]
    return {
        ", ".join(f"{v:g} {UNITS[c]}" if c in UNITS else str(v) for c, v in zip(others, values, strict=True)): chosen
        for values, chosen in group(rows, *others).items()
    }


def _place(index: int, count: int) -> float:
    """Offset of the dots of series ``index`` of ``count`` from their tick."""
    return 0.0 if count == 1 else min(0.6, 0.3 * (count - 1)) * (index / (count - 1) - 0.5)


def save(figure: Figure, folder: Path) -> Path:
    """Write ``figure.svg`` and ``figure.png`` atomically; return the path of the latter."""
    with mpl.rc_context(STYLE):
        for kind in ("svg", "png"):
            partial = folder / f"figure.{kind}.part"
            figure.savefig(partial, format=kind, dpi=160, metadata={"Date": None} if kind == "svg" else None)
            partial.replace(folder / f"figure.{kind}")
    return folder / "figure.png"


def _counts(
    axes: Axes, rows: Rows, varies: str, colours: Mapping[float, Any], shift: float, style: Any, label: str
) -> None:
    means: dict[float, float] = {}
    for tick, (level, colour) in enumerate(colours.items()):
        spikes = [row["spikes"] for row in rows if row[varies] == level]
        if not spikes:
            continue
        place = tick + shift
        wobble = np.linspace(-0.06, 0.06, len(spikes)) if len(spikes) > 1 else np.zeros(1)
        axes.scatter(place + wobble, spikes, s=11, color=colour, alpha=0.65, linewidths=0, zorder=3)
        summary = summarise(spikes)
        means[place + 0.12] = summary.mean
        if summary.n > 1:
            error = [[summary.mean - summary.ci_low], [summary.ci_high - summary.mean]]
            axes.errorbar(place + 0.12, summary.mean, yerr=error, fmt="_", color="black", capsize=3, lw=1.2, zorder=4)
    axes.plot(list(means), list(means.values()), color="black", lw=0.9, ls=style, label=label, zorder=2)


def _traces(axes: Axes, rows: Rows, frames: pa.Table, varies: str, colours: Mapping[float, Any], style: Any) -> None:
    columns = {name: frames[name].to_numpy() for name in ("trial", "hs", "stimulus_bearing_deg")}
    for row in rows:
        chosen = columns["trial"] == row["trial"]
        # Bearing is left positive; drawn as in the image, rightward to the right.
        bearing, hs = -columns["stimulus_bearing_deg"][chosen], columns["hs"][chosen]
        axes.plot(bearing, hs, color=colours[row[varies]], ls=style, lw=0.6, alpha=0.6)


def _frame(axes: Axes, colours: Mapping[float, Any], unit: str, threshold: float) -> None:
    """Thresholds, labels and the colours' legend about the traces."""
    for sign in (1, -1):
        axes.axhline(sign * threshold, color="black", ls="--", lw=0.8)
    axes.annotate(f"±T = {threshold:g}", (0.01, -threshold - 0.02), xycoords=("axes fraction", "data"), va="top")
    axes.set(xlabel="bearing of the stimulus (degrees, right positive)", ylabel="HS membrane potential", ylim=(-1, 1))
    keys = [Line2D([], [], color=colour, lw=2, label=f"{level:g} {unit}") for level, colour in colours.items()]
    axes.legend(handles=keys, columnspacing=1.2, **LEGEND, ncols=6 if len(keys) <= 6 else 4)
