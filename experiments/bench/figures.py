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

from experiments.bench.results import group
from experiments.bench.statistics import summarise

Rows = Sequence[Mapping[str, Any]]

AXIS_LABELS = {
    "speed_cm_s": "speed of the stimulus (cm/s)",
    "distance_cm": "distance camera to path (cm)",
    "angle_deg": "angle to the optical axis (degrees)",
}
UNITS = {"speed_cm_s": "cm/s", "distance_cm": "cm", "angle_deg": "°"}
COLOURS = ("#3b6fb6", "#2a9d8f", "#d98324", "#b5485d", "#6c5b9e", "#7a7a7a")
STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.hashsalt": "colias-sim",  # equal runs, equal bytes
    "svg.fonttype": "none",
}


def draw(rows: Rows, frames: pa.Table, varies: str, title: str, threshold: float) -> Figure:
    """Left: spikes of every trial, with means and 95 % intervals. Right: HS against the stimulus's bearing."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.4, 3.6), layout="constrained")
        counts, traces = figure.subplots(1, 2, width_ratios=[1, 1.25])
        directions = list(group(rows, "direction"))
        levels = sorted({row[varies] for row in rows})
        colours = {level: COLOURS[i % len(COLOURS)] for i, level in enumerate(levels)}
        for shift, (direction,) in zip(_spread(len(directions)), directions, strict=True):
            chosen = [row for row in rows if row["direction"] == direction]
            _counts(counts, chosen, varies, levels, colours, shift, direction if len(directions) > 1 else None)
        counts.set_xticks(range(len(levels)), [f"{level:g}" for level in levels])
        counts.set(xlabel=AXIS_LABELS[varies], ylabel="HS spikes per trial", ylim=(-2, None))
        _traces(traces, rows, frames, varies, colours, threshold)
        figure.suptitle(title, fontsize=10, x=0.01, ha="left")
    return figure


def save(figure: Figure, folder: Path) -> Path:
    """Write ``figure.svg`` and ``figure.png`` atomically; return the path of the latter."""
    with mpl.rc_context(STYLE):
        for kind in ("svg", "png"):
            partial = folder / f"figure.{kind}.part"
            figure.savefig(partial, format=kind, dpi=160, metadata={"Date": None} if kind == "svg" else None)
            partial.replace(folder / f"figure.{kind}")
    return folder / "figure.png"


def _spread(count: int) -> list[float]:
    """Offsets of ``count`` series side by side at one tick."""
    return [0.0] if count == 1 else list(np.linspace(-0.15, 0.15, count))


def _counts(
    axes: Axes,
    rows: Rows,
    varies: str,
    levels: Sequence[float],
    colours: Mapping[float, str],
    shift: float,
    label: str | None,
) -> None:
    means, ticks = [], []
    for tick, level in enumerate(levels):
        spikes = [row["spikes"] for row in rows if row[varies] == level]
        if not spikes:
            continue
        place = tick + shift
        wobble = np.linspace(-0.06, 0.06, len(spikes)) if len(spikes) > 1 else np.zeros(1)
        axes.scatter(place + wobble, spikes, s=11, color=colours[level], alpha=0.65, linewidths=0, zorder=3)
        summary = summarise(spikes)
        error = [[summary.mean - summary.ci_low], [summary.ci_high - summary.mean]]
        axes.errorbar(place + 0.12, summary.mean, yerr=error, fmt="_", color="black", capsize=3, lw=1.2, zorder=4)
        means.append(summary.mean)
        ticks.append(place + 0.12)
    axes.plot(ticks, means, color="black", lw=0.9, ls=":" if label == "leftward" else "-", label=label, zorder=2)
    if label:
        axes.legend(frameon=False, loc="upper left")


def _traces(
    axes: Axes, rows: Rows, frames: pa.Table, varies: str, colours: Mapping[float, str], threshold: float
) -> None:
    columns = {name: frames[name].to_numpy() for name in ("trial", "hs", "stimulus_bearing_deg")}
    level_of = {row["trial"]: row[varies] for row in rows}
    seen: set[float] = set()
    for trial, level in level_of.items():
        chosen = columns["trial"] == trial
        # Bearing is left positive; drawn as in the image, rightward to the right.
        name = f"{level:g} {UNITS[varies]}" if level not in seen else None
        axes.plot(-columns["stimulus_bearing_deg"][chosen], columns["hs"][chosen], color=colours[level], lw=0.6,
                  alpha=0.6, label=name)  # fmt: skip
        seen.add(level)
    for sign in (1, -1):
        axes.axhline(sign * threshold, color="black", ls="--", lw=0.8)
    axes.annotate(f"±T = {threshold:g}", (0.01, threshold), xycoords=("axes fraction", "data"), va="bottom")
    axes.set(xlabel="bearing of the stimulus (degrees, right positive)", ylabel="HS membrane potential", ylim=(-1, 1))
    legend = axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 0.99), ncols=6, columnspacing=1.2)
    for line in legend.get_lines():
        line.set_linewidth(2)
