"""Behaviours as a picture: each measure with its interval and every episode, and where they drove."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import polars as pl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from colias_sim.envs import ENVS, Measure
from colias_sim.envs.geometry import HULL_RADIUS
from colias_sim.envs.world import OBSERVER, TARGET
from experiments.bench.closed_loop.run import Played
from experiments.bench.closed_loop.scores import COLUMNS
from experiments.bench.engine.terminal import count
from experiments.bench.figures import plotting
from experiments.bench.figures.palette import PRIVILEGED, Mark, for_comparison, marks
from experiments.bench.figures.plotting import (
    PAGE,
    WIDTH,
    Panel,
    grid_of_panels,
    headline,
    leftmost,
    lowest,
    plain,
    rows_inches,
    scoreboard,
    wrapped,
)
from experiments.bench.stats.scores import Standing
from scenes import ARENA_RADIUS_CM

COLLISION, PARKED, DRIVING, WALL = "#111111", "#5a5a5a", "#ffffff", "#8a8a8a"
"""Colours of crosses, of robots that are parked and of those that drive, and of the arena's outline."""
ACROSS, MOST_ACROSS = 3, 6
"""Panels of paths side by side, where all fit on a page so; and the most."""
WAY_INCHES, KEYS_INCHES = 6.9, 0.9
"""Width of a row of panels of paths, each as high as it is wide, and height of the keys below them; inches."""
TITLES_INCHES = 1.1
"""Height of what stands above and below the rows of measures, inches."""
LEAST_NAME = 1.05
"""Least width of the name above a path, inches."""
SHOWN_CM = ARENA_RADIUS_CM + 2.0
"""Half the width of a panel of paths."""


def write(played: Played) -> Path | None:
    """Draw into the run's folder; ``None`` where no episode was finished."""
    return plotting.save(draw(played), played.folder) if played.standings else None


def draw(played: Played) -> Figure:
    """Draw a row for each behaviour, the one asked for on top; below, where each of them drove.

    Of the first episode the path is drawn stronger, and its world's other robots are shown where they began. Worlds
    are equal for all behaviours, and differ between episodes.
    """
    standings = played.standings
    env = ENVS[played.env]
    panels = [
        Panel(
            _heading(measure), measure.name, log=measure.kind == "free_distance",
            share=_is_share(measure), column=measure.column if measure.kind == "mean" else "",
        )
        for measure in env.all_measures
    ]  # fmt: skip
    looks = marks(standing.name for standing in standings)
    rows = rows_inches(len(standings))
    across, lower = _paths_inches(len(standings), PAGE - TITLES_INCHES - rows) if env.draws_paths else (0, 0.0)
    rows = rows_inches(len(standings), PAGE - TITLES_INCHES - lower)
    upper = TITLES_INCHES + rows
    with mpl.rc_context(plotting.STYLE):
        drawn = Figure(figsize=(WIDTH, upper + lower), layout="constrained")
        parts: list[Any] = [drawn]
        if lower:
            split: Any = drawn.subfigures(2, 1, height_ratios=[upper, lower])
            parts = list(split)
        axes = np.atleast_1d(parts[0].subplots(1, len(panels), sharey=True))
        scoreboard(list(axes), panels, standings, {name: mark.colour for name, mark in looks.items()}, rows)
        headline(parts[0], _title(played))
        if lower:
            _paths(parts[1], played, looks, across)
    return drawn


def _heading(measure: Measure) -> str:
    return f"{measure.name} (share)" if _is_share(measure) else measure.name


def _is_share(measure: Measure) -> bool:
    column = COLUMNS.get(measure.column)
    return measure.kind == "mean" and column is not None and column.kind == "share"


def _paths_inches(behaviours: int, most: float) -> tuple[int, float]:
    """Return how many paths stand side by side, and the height of all: the fewest whose height is at most ``most``."""
    for across in range(ACROSS, MOST_ACROSS + 1):
        high = -(-behaviours // across) * WAY_INCHES / across + KEYS_INCHES
        if high <= most:
            break
    return across, high


def _title(played: Played) -> str:
    options = ", ".join(
        f"{name}.{key}={part}" if key else f"{name}={part}"
        for name, value in played.options
        for key, part in (value.items() if isinstance(value, Mapping) else [("", value)])
    )
    episodes = count(len(played.standings[0].rows), "episode")
    scores = [score for standing in played.standings for score in standing.scores.values() if score is not None]
    barred = any(score.low < score.high and math.isfinite(score.high - score.low) for score in scores)
    stroked = any(measure.kind == "mean" for measure in ENVS[played.env].all_measures)
    names = [standing.name for standing in played.standings]
    what = ["short strokes: the episodes of a mean"] * stroked + ["bars: 95 % intervals"] * barred
    what += ["grey: for comparison"] * any(map(for_comparison, names))
    what += [f"{PRIVILEGED}: told the world's state"] * any(name.startswith(PRIVILEGED) for name in names)
    what += [f"set: {options}"] * bool(options)
    return "; ".join([f"{played.env.partition('/')[2]}, {episodes} each", *what])


def _paths(part: Any, played: Played, looks: dict[str, Mark], across: int) -> None:
    """Draw a panel for each behaviour, ``across`` a row, and what everything in them is."""
    standings = played.standings
    (panels,) = grid_of_panels(part, 1, len(standings), across, sharex=True, sharey=True)
    for axes, standing in zip(panels, standings, strict=True):
        _tracks(axes, standing, played, looks[standing.name].colour)
        axes.set_title(plain(wrapped(standing.name, max(WAY_INCHES / across - 0.3, LEAST_NAME), 8)), fontsize=8)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_ticks([-40, -20, 0, 20, 40] if across == ACROSS else [-40, 0, 40])
    for axes in lowest([panels]):
        axes.set_xlabel("x (cm)", fontsize=8)
    for axes in leftmost([panels]):
        axes.set_ylabel("y (cm)", fontsize=8)
    many = any(len(standing.rows) > 1 for standing in standings)
    part.legend(handles=_keys(played, many=many), loc="outside lower center", ncols=3, frameon=False, fontsize=8)


def _tracks(axes: Axes, standing: Standing, played: Played, colour: str) -> None:
    """Draw every episode's path from above, the first on top; a cross where one ended by touching something."""
    axes.add_patch(Circle((0, 0), ARENA_RADIUS_CM, fill=False, color=WALL, lw=1.0))
    for name, (x, y, _) in played.starts.items():
        if name != OBSERVER:
            face = PARKED if name.startswith("parked") else DRIVING
            axes.add_patch(Circle((x, y), 100 * HULL_RADIUS, fc=face, ec=PARKED, lw=0.9, zorder=2))
    for place, row in reversed(list(enumerate(standing.rows))):
        steps = played.steps.filter(pl.col("trial") == row["trial"])
        xs, ys = steps["x_cm"].to_numpy(), steps["y_cm"].to_numpy()
        width, alpha = (1.5, 1.0) if place == 0 else (0.6, 0.5)
        axes.plot(xs, ys, lw=width, color=colour, alpha=alpha, zorder=3)
        axes.plot(xs[:1], ys[:1], "o", ms=3.5, mfc="white", mec=colour, mew=0.9, zorder=4)
        if row["touched"]:
            axes.plot(xs[-1:], ys[-1:], "x", color=COLLISION, ms=5, mew=1.4, zorder=5)
    axes.set(xlim=(-SHOWN_CM, SHOWN_CM), ylim=(-SHOWN_CM, SHOWN_CM), aspect="equal")
    axes.tick_params(labelsize=8)


def _keys(played: Played, *, many: bool) -> list[Line2D]:
    """Return what is in the panels of paths."""
    ink = "#222222"
    keys = [Line2D([], [], color=ink, lw=1.5, label="path of the first episode" if many else "path")]
    if many:
        keys.append(Line2D([], [], color=ink, lw=0.6, alpha=0.5, label="paths of the others, in other worlds"))
    keys += [
        Line2D([], [], ls="", marker="o", ms=3.5, mfc="white", mec=ink, mew=0.9, label="start"),
        Line2D([], [], ls="", marker="x", ms=5, mew=1.4, color=COLLISION, label="end by a collision"),
        Line2D([], [], ls="", marker="o", ms=9, mfc="none", mec=WALL, label="the arena's wall"),
    ]
    kinds = {
        "parked": (PARKED, "parked robots"), "mover": (DRIVING, "driving robots at their start"),
        TARGET: (DRIVING, "the target at its start"),
    }  # fmt: skip
    which = " (first episode)" if many else ""
    for kind, (face, caption) in kinds.items():
        if any(name.startswith(kind) for name in played.starts):
            keys.append(Line2D([], [], ls="", marker="o", ms=6, mfc=face, mec=PARKED, label=caption + which))
    return keys
