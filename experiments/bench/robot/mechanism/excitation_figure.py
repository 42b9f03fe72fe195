"""The figure of excitation and inhibition over a trial, and of what w_i leaves of symmetric motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from experiments.bench.figures.palette import HUES
from experiments.bench.figures.plotting import PAGE, STYLE, WIDTH, headline
from experiments.bench.robot.figure import level_text
from experiments.bench.stats.excitation import Course, Floats

ACROSS = 3
"""Conditions side by side."""
EXCITED, INHIBITED, POTENTIAL, BALANCED = HUES[0], HUES[4], "black", HUES[1]
LEFTOVER = HUES[2]
HEIGHTS = (1.4, 1.7, 0.8)
"""Heights of the three panels of a condition, inches: E and I, HS, spikes; all lower where a page asks for it."""
LEAST_HEIGHTS = 1.9
"""Least height of the three together, inches."""
ROOM, KEY_INCHES = 1.22, 0.3
"""Room for titles and axes of a row of conditions, and for the key, inches."""
QUIET = 0.01
"""Share of the largest E or I below which a frame is quiet: the time before the first other and after the last one, in
any condition, is not shown."""
MARGIN_S = 0.15
LEAST_SPREAD, BAND = 3, 0.25
"""Trials from which their spread is shown, and opacity of its band."""


def figure(courses_shown: Sequence[Course], heading: str, threshold: float | None) -> Figure:
    """Draw the conditions of a run side by side.

    Parameters
    ----------
    courses_shown
        One or more conditions; see `experiments.bench.stats.excitation.courses`.
    heading
        Title of the figure.
    threshold
        T of the network as it is; ``None``: it does not spike.

    Returns
    -------
    matplotlib.figure.Figure
        Three panels for each condition, against time: excitation and weighted inhibition; HS, its leftover of
        symmetric motion, and HS with w_i = 1; the spikes of every trial. Lines are means over trials, shades one
        standard deviation to either side, from `LEAST_SPREAD` trials on.
    """
    blocks = [courses_shown[start : start + ACROSS] for start in range(0, len(courses_shown), ACROSS)]
    across = min(len(courses_shown), ACROSS)
    high = min(sum(HEIGHTS), max((PAGE - KEY_INCHES) / len(blocks) - ROOM, LEAST_HEIGHTS))
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(WIDTH, (high + ROOM) * len(blocks) + KEY_INCHES), layout="constrained")
        grid = drawn.subplots(3 * len(blocks), across, squeeze=False, sharex=True, height_ratios=HEIGHTS * len(blocks))
        highest, deepest = _limits(courses_shown, threshold)
        for row, block in enumerate(blocks):
            for column in range(across):
                panels = list(grid[3 * row : 3 * row + 3, column])
                if column >= len(block):
                    for axes in panels:
                        axes.set_axis_off()
                    continue
                _condition(block[column], panels, threshold, first=column == 0)
                panels[0].set_ylim(-0.05 * highest, 1.08 * highest)
                panels[1].set_ylim(-1.1 * deepest, 1.1 * deepest)
        grid[0, 0].set_xlim(*_busy(courses_shown, QUIET * highest))
        headline(drawn, heading)
        drawn.legend(handles=_keys(courses_shown, threshold), loc="outside lower center", ncols=3, frameon=False,
                     fontsize=8)  # fmt: skip
    return drawn


def _limits(courses_shown: Sequence[Course], threshold: float | None) -> tuple[float, float]:
    """The largest mean of E and I, and the largest size of HS, over all conditions: they share their axes."""
    every = [course.curves() for course in courses_shown]
    sums = [curves[name].mean(axis=0) + curves[name].std(axis=0) for curves in every
            for name in ("excitation", "weighted_inhibition")]  # fmt: skip
    finite = [float(values[np.isfinite(values)].max(initial=0.1)) for values in sums]
    sizes = [float(np.abs(curves[name]).max()) for curves in every for name in ("hs", "hs_w_i_1")]
    return max(finite), max([*sizes, threshold or 0.1])


def _busy(courses_shown: Sequence[Course], quiet: float) -> tuple[float, float]:
    """Find the time in which E or I is above ``quiet`` in any condition, with a margin; the whole time if it
    never is.
    """
    times = [
        course.time_s[np.maximum(curves["excitation"], curves["weighted_inhibition"]).mean(axis=0) > quiet]
        for course in courses_shown
        for curves in [course.curves()]
    ]
    busy = np.concatenate(times)
    if not busy.size:
        return 0.0, max(float(course.time_s[-1]) for course in courses_shown)
    return max(0.0, float(busy.min()) - MARGIN_S), float(busy.max()) + MARGIN_S


def _condition(course: Course, panels: Sequence[Axes], threshold: float | None, *, first: bool) -> None:
    """The three panels of one condition, top to bottom; the ``first`` of a row has the labels."""
    sums, potential, raster = panels
    curves, time_s = course.curves(), course.time_s
    _mean(sums, time_s, curves["excitation"], EXCITED)
    _mean(sums, time_s, curves["weighted_inhibition"], INHIBITED)
    sums.set_title(_heading(course.condition), fontsize=8)
    for course_of_trial in curves["hs"]:
        potential.plot(time_s, course_of_trial, color=POTENTIAL, lw=0.4, alpha=0.35)
    leftover = curves["residue"].mean(axis=0)
    potential.fill_between(time_s, 0.0, leftover, color=LEFTOVER, alpha=0.55, lw=0)
    potential.plot(time_s, curves["hs_w_i_1"].mean(axis=0), color=BALANCED, lw=1.2, ls="-.")
    potential.plot(time_s, curves["hs"].mean(axis=0), color=POTENTIAL, lw=1.4)
    potential.axhline(0.0, color="black", lw=0.4)
    for level in () if threshold is None else (threshold, -threshold):
        potential.axhline(level, color="black", ls="--", lw=0.8)
    _raster(raster, course)
    raster.set_xlabel("time in the trial (s)", fontsize=8)
    for axes in panels:
        axes.tick_params(labelsize=8, labelleft=first and axes is not raster, labelbottom=axes is raster)
    if first:
        sums.set_ylabel("E and $w_i$ I", fontsize=8)
        potential.set_ylabel("HS potential\n(right positive)", fontsize=8)
        raster.set_ylabel("trials", fontsize=8)


def _mean(axes: Axes, time_s: Floats, values: Floats, colour: str) -> None:
    """The mean over trials, and of `LEAST_SPREAD` and more one standard deviation to either side."""
    mean = values.mean(axis=0)
    if len(values) >= LEAST_SPREAD:
        spread = values.std(axis=0, ddof=1)
        axes.fill_between(time_s, mean - spread, mean + spread, color=colour, alpha=BAND, lw=0)
    axes.plot(time_s, mean, color=colour, lw=1.2)


def _raster(axes: Axes, course: Course) -> None:
    """A row for each trial, a mark for each frame with spikes: those with w_i = 1 below those of the network as it is.

    The heading counts the trials that fire.
    """
    count = len(course.trials)
    for place, trial in enumerate(course.trials):
        for shift, spikes, colour in ((0.0, trial.spikes, POTENTIAL), (count + 1, trial.spikes_balanced, BALANCED)):
            times = course.time_s[spikes != 0]
            axes.vlines(times, shift + place, shift + place + 0.9, color=colour, lw=1.0)
    axes.set_ylim(2 * count + 1, -0.5)
    axes.set_yticks([])
    caption = f"trials that fire: {course.firing()} of {count}; $w_i$ = 1: {course.firing(balanced=True)}"
    axes.set_title(caption, fontsize=8, pad=2)


def _heading(condition: Mapping[str, Any]) -> str:
    angle = condition["angle_deg"]
    where = f"{condition['distance_cm']:g} cm" if angle is None else f"{level_text(angle)}°"
    way = condition["direction"]
    return f"{condition['motion']} {where}\n{'on the axis' if way == 'straight' else f'image {way}'}"


def _keys(courses_shown: Sequence[Course], threshold: float | None) -> list[Any]:
    w_i = courses_shown[0].w_i
    keys = [
        Line2D([], [], color=EXCITED, label="excitation E"),
        Line2D([], [], color=INHIBITED, label=f"weighted inhibition, {w_i:g} I"),
        Line2D([], [], color=POTENTIAL, label=f"HS and spikes, $w_i$ = {w_i:g}"),
        Line2D([], [], color=BALANCED, ls="-.", label="HS and spikes, $w_i$ = 1"),
        Patch(color=LEFTOVER, alpha=0.55, lw=0, label=f"what symmetric motion leaves, {1 - w_i:.2g} (E + I) / 2"),
    ]
    if any(len(course.trials) >= LEAST_SPREAD for course in courses_shown):
        keys.append(Patch(color="black", alpha=BAND, lw=0, label="one standard deviation of trials"))
    if threshold is not None:
        keys.append(Line2D([], [], color="black", ls="--", lw=0.8, label=f"threshold ±{threshold:g}"))
    return keys
