"""Behaviours as a picture: each measure with its interval and every episode, and where they drove."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pyarrow.compute as pc
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import NullFormatter

from experiments.bench import figures
from experiments.bench.behave import Played, Standing
from scenes import ARENA_RADIUS_CM

COLUMNS = {
    "time on target": "in_view", "off axis (deg)": "off_axis_deg", "optomotor gain": "optomotor_gain",
    "gap error (cm)": "gap_error_cm", "return": "reward",
}  # fmt: skip
"""Measures that are means over episodes -> the column that has each one's."""
FILLED, FAINT, MARK = "#1f4e79", "#9ab3cc", "#b5485d"
INCHES_A_ROW, TRACK_INCHES = 0.36, 2.3


def write(played: Played) -> Path | None:
    """Draw into the run's folder; ``None`` where no episode was finished."""
    return figures.save(draw(played), played.folder) if played.standings else None


def draw(played: Played) -> Figure:
    """A row for each behaviour above, the one asked for on top; below, where each of them drove."""
    standings = played.standings
    names = list(standings[0].scores)
    tracks = standings[0].env.partition("/")[2].startswith(("Avoidance", "Pursuit"))
    upper = 0.9 + INCHES_A_ROW * len(standings)
    with mpl.rc_context(figures.STYLE):
        drawn = Figure(figsize=(9.6, upper + (TRACK_INCHES + 0.4 if tracks else 0.0)), layout="constrained")
        parts: list[Any] = [drawn]
        if tracks:
            split: Any = drawn.subfigures(2, 1, height_ratios=[upper, TRACK_INCHES + 0.4])
            parts = list(split)
        axes = np.atleast_1d(parts[0].subplots(1, len(names), sharey=True))
        for place, name in zip(axes, names, strict=True):
            _measure(place, name, standings)
        axes[0].set_yticks(range(len(standings)), [standing.behaviour for standing in standings])
        axes[0].set_ylim(len(standings) - 0.5, -0.5)
        short, count = standings[0].env.partition("/")[2], len(standings[0].rows)
        parts[0].suptitle(f"{short}, {count} episodes each; 95 % intervals", fontsize=9, x=0.01, ha="left")
        if tracks:
            for place, standing in zip(np.atleast_1d(parts[1].subplots(1, len(standings))), standings, strict=True):
                _tracks(place, standing, played)
    return drawn


def _measure(axes: Axes, name: str, standings: Sequence[Standing]) -> None:
    for row, standing in enumerate(standings):
        score = standing.scores.get(name)
        if score is None or not np.isfinite(score.value):
            axes.text(0.5, row, "none" if score else "-", transform=axes.get_yaxis_transform(), va="center", fontsize=8)
            continue
        each = [value[COLUMNS[name]] for value in standing.rows] if name in COLUMNS else []
        axes.plot(each, [row + 0.22] * len(each), "|", color=FAINT, ms=5)
        ends = [end if np.isfinite(end) else score.value for end in (score.low, score.high)]
        axes.plot(ends, [row, row], color=FILLED, lw=1.4)
        axes.plot([score.value], [row], "o", color=FILLED, ms=4)
    axes.set_title(name, fontsize=9)
    axes.grid(axis="x", lw=0.4, alpha=0.5)
    if name == "free distance (m)":
        axes.set_xscale("log")
        axes.xaxis.set_minor_formatter(NullFormatter())


def _tracks(axes: Axes, standing: Standing, played: Played) -> None:
    """Every episode's path from above; a cross where one ended by touching something."""
    axes.add_patch(Circle((0, 0), ARENA_RADIUS_CM, fill=False, color="0.6", lw=0.8))
    for row in standing.rows:
        steps = played.steps.filter(pc.equal(played.steps["trial"], row["trial"]))
        x, y = steps["x_cm"].to_numpy(), steps["y_cm"].to_numpy()
        axes.plot(x, y, lw=0.5, color=FILLED, alpha=0.5)
        if row["touched"]:
            axes.plot(x[-1:], y[-1:], "x", color=MARK, ms=4)
    axes.set(xlim=(-47, 47), ylim=(-47, 47), aspect="equal")
    axes.set_title(standing.behaviour, fontsize=8)
    axes.set_axis_off()
