"""Parts that judges of trials with the robot share: the paper's trials, means by condition, and the outcome of checks.

A judge tests its claim on every condition that the words cover among the trials it is given; where the words leave
room, its docstring says how they are read.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from experiments.bench.stats.checks import Check, exceeds, is_number
from experiments.bench.stats.tests import contrast, summarise, trend
from experiments.bench.stats.verdict import Outcome

Row = Mapping[str, Any]
Rows = Sequence[Row]
ByLevel = Mapping[float, Sequence[float]]
"""Level of a condition -> a value of each of its trials."""

DSNN = "dsnn"
ACROSS, DEPTH = ("translation",), ("approach", "recession")
"""Motions: crossings of the view, and those along a line to the camera."""
DEFAULTS: Mapping[str, Any] = {
    "shell_grey": None,
    "wall_contrast": None,
    "observer_speed_cm_s": 0.0,
    "observer_turn_deg_s": 0.0,
}
"""What the paper's trials leave as it is: those of other experiments do not count."""
ANGLES = (-30.0, -15.0, 0.0, 15.0, 30.0)
"""Of the paper's angular tests, degrees."""


def paper_trials(rows: Rows, **fixed: Any) -> list[Row]:
    """Return the paper's own trials with the ``fixed`` values."""
    return [row for row in rows if all(row[name] == value for name, value in {**DEFAULTS, **fixed}.items())]


def by_level(rows: Rows, column: str, measured: str = "spikes", **fixed: Any) -> dict[float, list[float]]:
    """Return level of a ``column`` -> what was ``measured`` in each of the paper's trials with the ``fixed`` values."""
    trials = paper_trials(rows, **fixed)
    levels = sorted({row[column] for row in trials})
    return {level: [row[measured] for row in trials if row[column] == level] for level in levels}


def means(groups: ByLevel) -> dict[float, float]:
    """Return level -> mean."""
    return {level: float(np.mean(values)) for level, values in groups.items()}


def mean_text(values: Sequence[float], digits: int = 1, lowest: float = -math.inf) -> str:
    """Return a mean with its 95 % interval, if there is one, in words; it does not go below ``lowest``."""
    summary = summarise(values, lowest)
    low, high = f"{summary.ci_low:.{digits}f}", f"{summary.ci_high:.{digits}f}"
    return f"{summary.mean:.{digits}f}" + (f" [{low}, {high}]" if is_number(summary.ci_low) else "")


def means_text(groups: ByLevel, unit: str) -> str:
    """Return mean spikes of each group with its 95 % interval, and how many trials each mean is of, in words."""
    texts = [f"{level:g} {unit}: {mean_text(spikes, lowest=0.0)}" for level, spikes in groups.items()]
    counts = sorted({len(spikes) for spikes in groups.values()})
    return f"mean spikes at {', '.join(texts)} (n = {'..'.join(map(str, counts))} each)"


def more_spikes(mean: Mapping[float, float], more: float, less: float, unit: str) -> Check:
    """Return the check that mean spikes at level ``more`` are above those at ``less``."""
    return exceeds(f"{mean[more]:.1f} spikes at {more:g} {unit}", mean[more], mean[less], f"at {less:g}", "spikes")


def outcome_of(checks: Sequence[Check], groups: Mapping[Any, Sequence[float]], measured: str, effect: str) -> Outcome:
    """Return the outcome of checks on ``groups``, a value of each trial by condition."""
    counts = [len(values) for values in groups.values()]
    return Outcome.of(checks, measured, effect, sum(counts), min(counts))


def at_every_speed(
    rows: Rows, motion: str, checks: Callable[[ByLevel], list[Check]], effect: Callable[[ByLevel], str]
) -> Outcome:
    """Return the outcome of ``checks`` at each speed at which the motion was shown along all `ANGLES`."""
    speeds = sorted({row["speed_cm_s"] for row in paper_trials(rows, motion=motion)})
    by_speed = {speed: by_level(rows, "angle_deg", motion=motion, speed_cm_s=speed) for speed in speeds}
    whole = {
        speed: {a: groups[a] for a in ANGLES} for speed, groups in by_speed.items() if set(ANGLES) <= groups.keys()
    }
    if not whole:
        return Outcome.unjudged(f"needs {motion} at -30, -15, 0, 15 and 30 degrees")
    every, measured, effects = [], [], []
    conditions: dict[str, Sequence[float]] = {}
    for speed, groups in whole.items():
        which = f"{speed:g} cm/s: " if len(whole) > 1 else ""
        every += [replace(check, says=f"{which}{check.says}") for check in checks(groups)]
        measured.append(f"{which}{means_text(groups, 'degrees')}")
        effects.append(f"{which}{effect(groups)}")
        conditions |= {f"{which}{angle}": spikes for angle, spikes in groups.items()}
    return outcome_of(every, conditions, "; ".join(measured), "; ".join(effects))


def of_pairs(rows: Rows, motion: str, pairs: Sequence[tuple[float, float]]) -> Outcome:
    """Return the outcome of more spikes at the first angle of each pair than at the second, at every speed shown."""

    def checks(groups: ByLevel) -> list[Check]:
        mean = means(groups)
        return [more_spikes(mean, more, less, "degrees") for more, less in pairs]

    def effect(groups: ByLevel) -> str:
        return f"against |angle|: {trend([(abs(angle), groups[angle]) for angle in sorted(groups, key=abs)])}"

    return at_every_speed(rows, motion, checks, effect)


def fewest_ahead(rows: Rows, motion: str) -> Outcome:
    """Return the outcome of fewest spikes at 0 degrees, and more at 30 than at 15 on each side, at every speed."""
    return of_pairs(rows, motion, [*((angle, 0.0) for angle in ANGLES if angle), (-30.0, -15.0), (30.0, 15.0)])


def more_on_one_side(rows: Rows, motion: str, more: float, name: str) -> Outcome:
    """Return the outcome of more spikes on the side of the sign ``more``, at 15 and 30 degrees together."""

    def split(groups: ByLevel) -> tuple[list[float], list[float]]:
        here, there = ([n for a in (15.0, 30.0) for n in groups[side * a]] for side in (more, -more))
        return here, there

    def checks(groups: ByLevel) -> list[Check]:
        here, there = (float(np.mean(side)) for side in split(groups))
        return [exceeds(f"{name}: {here:.1f} spikes a trial", here, there, "on the other side", "spikes")]

    def effect(groups: ByLevel) -> str:
        here, there = split(groups)
        here_text, there_text = mean_text(here, lowest=0.0), mean_text(there, lowest=0.0)
        return f"{name}: {here_text} and {there_text} spikes a trial, {contrast(here, there)}"

    return at_every_speed(rows, motion, checks, effect)
