"""Parts that judges of trials with the robot share: the paper's trials, means by condition, and the outcome of checks.

A judge tests its claim on every condition that the words cover among the trials it is given; where the words leave
room, its docstring says how they are read.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from experiments.bench.stats.checks import Check, exceeds, is_number
from experiments.bench.stats.tests import contrast, paired, summarise, trend
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


Curve = Mapping[float, Mapping[int, float]]
"""Speed, cm/s -> trial -> its value."""

POTENTIAL, COUNT = "mean_hs_near_axis", "spikes"
"""Columns: mean HS near the axis, which is the same stretch of path at every speed; spikes of the whole crossing."""


@dataclass(frozen=True, slots=True)
class Peak:
    """Speed where a mean over trials is largest among the speeds shown.

    Parameters
    ----------
    speed
        The speed, cm/s; of equal means the lowest speed.
    mean
        The mean over trials there.
    end
        Whether it is the first or the last speed shown: the true peak may then lie beyond. Otherwise empty.
    """

    speed: float
    mean: float
    end: Literal["", "first", "last"]


def curve(rows: Rows, column: str) -> dict[float, dict[int, float]]:
    """Values of a column by speed and trial, in the order of the rows."""
    by_speed: dict[float, dict[int, float]] = {}
    for row in rows:
        by_speed.setdefault(row["speed_cm_s"], {})[row["trial"]] = float(row[column])
    return by_speed


def mean(values: Mapping[Any, float]) -> float:
    """Return the mean over trials."""
    return float(np.mean(list(values.values())))


def peak(means: Mapping[float, float]) -> Peak:
    """Find the largest of means over trials.

    Parameters
    ----------
    means
        Speed, cm/s -> mean over trials; at least one speed.
    """
    speeds = sorted(means)
    speed = max(speeds, key=lambda level: means[level])
    return Peak(speed, means[speed], "first" if speed == speeds[0] else "last" if speed == speeds[-1] else "")


CONNECTIONS = {1: "dsnn:n_con=1", 2: "dsnn:n_con=2", 4: "dsnn:n_con=4", 8: DSNN}
"""N_con -> label."""
FIXED = {delay: f"dsnn:tau_s={delay},{delay}" for delay in (10, 50, 100, 200)}
"""The one delay of all pairs, ms -> label."""
FALLING = "dsnn:tau_s=200,10"
"""Delays that fall with spacing: the other reading of "a linearly decaying function"."""
WIDER = "dsnn:d=2"
"""Twice the sampling distance."""
PER_CORRELATOR = {n: f"{CONNECTIONS[n]},k_sig={0.01 * n / 8:g}" for n in (1, 2)}
"""N_con -> label of fewer connections read as means per correlator, beside the eight of `DSNN`: a sum over n counts
8 / n times, ahead of the sigmoid."""
VARIANTS = (*(CONNECTIONS[n] for n in (1, 2, 4)), WIDER, *FIXED.values(), FALLING, *PER_CORRELATOR.values())
"""Every variant that a claim names, to be shown beside `DSNN`."""

ROBOT_SPEEDS = (2.0, 4.0, 6.0, 10.0)
"""Those of the paper's robot tests."""


def crossings(rows: Rows, model: str, column: str) -> dict[float, dict[int, float]]:
    """Return values of a column in one model's rightward crossings at 8 cm, by speed and trial."""
    trials = paper_trials(rows, model=model, motion="translation", direction="rightward", distance_cm=8.0)
    return curve(trials, column)


def common_speeds(curves: Mapping[Any, Curve]) -> list[float]:
    """Return the speeds at which every curve has a value."""
    return sorted(set.intersection(*(set(curve) for curve in curves.values())))


def higher(value: float, name: str, bound: float, other: str, speed: float, what: str) -> Check:
    """Return the check that a mean potential of ``name`` is above that of the ``other`` at a speed."""
    return exceeds(f"{what} of {name} {value:.3f} at {speed:g} cm/s", value, bound, f"of {other}", "potential")


def potentials_text(means: Mapping[float, float]) -> str:
    """Return mean potentials by speed, in words."""
    return ", ".join(f"{mean:.2f} at {speed:g}" for speed, mean in means.items()) + " cm/s"


def paired_text(first: Curve, second: Curve) -> str:
    """Return a paired test over all speeds, in words: the models saw the same frames."""
    pairs = [
        (value, second[speed][trial])
        for speed in common_speeds({0: first, 1: second})
        for trial, value in first[speed].items()
        if trial in second[speed]  # one may have failed in some
    ]
    return str(paired([a for a, _ in pairs], [b for _, b in pairs]))


def outcome_of_curves(checks: Sequence[Check], curves: Mapping[Any, Curve], measured: str, effect: str) -> Outcome:
    """Return the outcome; n counts the trials in which any of the models was judged, once each."""
    trials = [curve[speed] for curve in curves.values() for speed in common_speeds(curves)]
    n, fewest = len({trial for values in trials for trial in values}), min(map(len, trials))
    return Outcome.of(checks, measured, effect, n, fewest)
