"""Variants of the DSNN that claims compare on the same frames, and what the judges of these claims share.

`DSNN` stands for the network as it is: N_con = 8, d = 1, delays that rise with spacing from 10 to 200 ms.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from experiments.bench.robot.judging import DSNN, Rows, paper_trials
from experiments.bench.robot.mechanism import peaks
from experiments.bench.robot.mechanism.peaks import Curve
from experiments.bench.stats.checks import Check, exceeds
from experiments.bench.stats.tests import paired
from experiments.bench.stats.verdict import Outcome

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
    return peaks.curve(trials, column)


def common_speeds(curves: Mapping[Any, Curve]) -> list[float]:
    """Return the speeds at which every curve has a value."""
    return sorted(set.intersection(*(set(curve) for curve in curves.values())))


def higher(value: float, name: str, bound: float, other: str, speed: float, what: str) -> Check:
    """Return the check that a mean potential of ``name`` is above that of the ``other`` at a speed."""
    return exceeds(f"{what} of {name} {value:.3f} at {speed:g} cm/s", value, bound, f"of {other}", "potential")


def means_text(means: Mapping[float, float]) -> str:
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


def outcome_of(checks: Sequence[Check], curves: Mapping[Any, Curve], measured: str, effect: str) -> Outcome:
    """Return the outcome; n counts the trials in which any of the models was judged, once each."""
    trials = [curve[speed] for curve in curves.values() for speed in common_speeds(curves)]
    n, fewest = len({trial for values in trials for trial in values}), min(map(len, trials))
    return Outcome.of(checks, measured, effect, n, fewest)
