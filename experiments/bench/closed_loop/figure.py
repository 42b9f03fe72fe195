"""Behaviours as a picture: each measure with its interval and every episode, and where they drove."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pyarrow.compute as pc
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from colias_sim.envs import ENVS
from experiments.bench.closed_loop.run import Played
from experiments.bench.core.figures import plotting
from experiments.bench.core.figures.plotting import INCHES_A_ROW, Panel, scoreboard
from experiments.bench.core.scores import Standing
from scenes import ARENA_RADIUS_CM

FILLED, FAINT, MARK = "#1f4e79", "#9ab3cc", "#b5485d"
TRACK_INCHES = 2.3


def write(played: Played) -> Path | None:
    """Draw into the run's folder; ``None`` where no episode was finished."""
    return plotting.save(draw(played), played.folder) if played.standings else None


def draw(played: Played) -> Figure:
    """A row for each behaviour above, the one asked for on top; below, where each of them drove."""
    standings = played.standings
    env = ENVS[played.env]
    panels = [
        Panel(
            measure.name, (measure.name,), log=measure.kind == "free_distance",
            column=measure.column if measure.kind == "mean" else "",
        )
        for measure in env.all_measures
    ]  # fmt: skip
    tracks = env.draws_paths
    upper = 0.9 + INCHES_A_ROW * len(standings)
    with mpl.rc_context(plotting.STYLE):
        drawn = Figure(figsize=(9.6, upper + (TRACK_INCHES + 0.4 if tracks else 0.0)), layout="constrained")
        parts: list[Any] = [drawn]
        if tracks:
            split: Any = drawn.subfigures(2, 1, height_ratios=[upper, TRACK_INCHES + 0.4])
            parts = list(split)
        axes = np.atleast_1d(parts[0].subplots(1, len(panels), sharey=True))
        scoreboard(list(axes), panels, standings, dict.fromkeys((each.name for each in standings), FILLED))
        short, count = played.env.partition("/")[2], len(standings[0].rows)
        parts[0].suptitle(f"{short}, {count} episodes each; 95 % intervals", fontsize=9, x=0.01, ha="left")
        if tracks:
            for place, standing in zip(np.atleast_1d(parts[1].subplots(1, len(standings))), standings, strict=True):
                _tracks(place, standing, played)
    return drawn


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
    axes.set_title(standing.name, fontsize=8)
    axes.set_axis_off()
