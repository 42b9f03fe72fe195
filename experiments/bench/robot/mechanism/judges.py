"""The judges of claims that compare the DSNN with variants of itself on the same frames.

Each takes the trials of all the models that its claim names. `DSNN` stands for the network as it is: N_con = 8, d = 1,
delays that rise with spacing from 10 to 200 ms.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

from experiments.bench.judging.statistics import paired
from experiments.bench.judging.verdict import Check, Outcome, decide
from experiments.bench.robot.judges import Rows, paper_trials
from experiments.bench.robot.mechanism import peaks
from experiments.bench.robot.mechanism.peaks import POTENTIAL, Curve

DSNN = "dsnn"
CONNECTIONS = {1: "dsnn:n_con=1", 2: "dsnn:n_con=2", 4: "dsnn:n_con=4", 8: DSNN}
"""N_con -> label."""
FIXED = {delay: f"dsnn:tau_s={delay},{delay}" for delay in (10, 50, 100, 200)}
"""The one delay of all pairs, ms -> label."""
FALLING = "dsnn:tau_s=200,10"
"""Delays that fall with spacing: the other reading of "a linearly decaying function"."""
WIDER = "dsnn:d=2"
"""Twice the sampling distance."""

ENSEMBLES = frozenset(CONNECTIONS[n] for n in (1, 2, 8))
DELAYS = frozenset({DSNN, FALLING, *FIXED.values()})
SPACINGS = frozenset({WIDER, *CONNECTIONS.values()})
VARIANTS = (*(CONNECTIONS[n] for n in (1, 2, 4)), WIDER, *FIXED.values(), FALLING)
"""Every variant that a claim names, to be shown beside `DSNN`."""

ROBOT_SPEEDS = (2.0, 4.0, 6.0, 10.0)
"""Those of the paper's robot tests."""
DELAY_SPEEDS = (4.0, 6.0, 8.0, 10.0)


def ensembles(rows: Rows, threshold: float) -> Outcome:
    """C24, the robot's part. Every speed shown counts, not the paper's alone. Of a speed, the mean peak over trials.

    The peak passes T at a speed if its mean does.
    """
    curves = {n: _curve(rows, CONNECTIONS[n], "peak_hs") for n in (1, 2, 8)}
    if not set(ROBOT_SPEEDS) <= set(_common(curves)):
        return Outcome("untested", "needs rightward translations at 8 cm, 2, 4, 6 and 10 cm/s")
    means = {n: {speed: peaks.mean(curves[n][speed]) for speed in _common(curves)} for n in curves}
    past = {n: sum(peak > threshold for peak in mean.values()) for n, mean in means.items()}
    checks = [
        _higher(means[8][speed], "N_con = 8", means[n][speed], f"N_con = {n}", speed, "peak HS")
        for n in (1, 2)
        for speed in means[8]
    ]
    for n in (1, 2):
        said = f"N_con = 8 passes T = {threshold:g} at {past[8]} of {len(means[8])} speeds"
        checks.append(Check(f"{said} (needs more than N_con = {n}: {past[n]})", float(past[8] - past[n])))
    listed = "; ".join(f"N_con = {n}: {_listed(mean)}, past T at {past[n]}" for n, mean in means.items())
    effect = "; ".join(f"N_con = 8 against {n}: {_paired(curves[8], curves[n])}" for n in (1, 2))
    return _decided(checks, curves, f"robot, rightward at 8 cm, mean peak HS: {listed}", effect)


def delays(rows: Rows, threshold: float) -> Outcome:
    """C25. Mean HS over the frames near the axis. The delays of the DSNN as it is rise with spacing.

    Delays that fall with spacing are the other reading; their numbers stand beside and decide nothing.
    """
    curves = {label: _curve(rows, label, POTENTIAL) for label in (DSNN, FALLING, *FIXED.values())}
    if not set(DELAY_SPEEDS) <= set(_common(curves)):
        return Outcome("untested", "needs rightward translations at 8 cm, 4, 6, 8 and 10 cm/s")
    named = {label: {speed: curve[speed] for speed in DELAY_SPEEDS} for label, curve in curves.items()}
    means = {label: {speed: peaks.mean(values) for speed, values in curve.items()} for label, curve in named.items()}
    checks = [
        _higher(means[DSNN][speed], "rising delays", means[label][speed], f"{delay} ms", speed, "mean HS")
        for delay, label in FIXED.items()
        for speed in DELAY_SPEEDS
    ]
    won = sum(check.passes for check in checks)
    said = {"rising 10..200 ms": DSNN, **{f"{delay} ms": label for delay, label in FIXED.items()}}
    listed = "; ".join(f"{name}: {_listed(means[label])}" for name, label in said.items())
    other = f"the other reading, falling 200..10 ms: {_listed(means[FALLING])}"
    effect = "; ".join(f"against {delay} ms: {_paired(named[DSNN], named[label])}" for delay, label in FIXED.items())
    measured = (
        f"higher in {won} of {len(checks)} comparisons; rightward at 8 cm, mean HS near the axis, {listed}; {other}"
    )
    return _decided(checks, named, measured, effect)


def fastest(rows: Rows, threshold: float) -> Outcome:
    """C30. The speed, of all those shown, at which mean HS near the axis is largest.

    It moves with d if it is another at d = 2 than at d = 1. It moves with N_con if over N_con = 1, 2, 4, 8 it goes
    one way, up or down, and ends elsewhere than it began. The paper's text gives neither a direction nor an amount.
    """
    labels = {"d = 1, N_con = 8": DSNN, "d = 2": WIDER, **{f"N_con = {n}": CONNECTIONS[n] for n in (1, 2, 4)}}
    curves = {name: _curve(rows, label, POTENTIAL) for name, label in labels.items()}
    speeds = _common(curves)
    if not set(ROBOT_SPEEDS) < set(speeds):
        return Outcome("untested", "needs rightward translations at 8 cm, 2, 4, 6, 10 cm/s and others")
    means = {name: {speed: peaks.mean(curve[speed]) for speed in speeds} for name, curve in curves.items()}
    top = {name: peaks.peak(mean).speed for name, mean in means.items()}
    usual, wide = top["d = 1, N_con = 8"], top["d = 2"]
    over = [*(top[f"N_con = {n}"] for n in (1, 2, 4)), usual]
    steps = [after - before for before, after in itertools.pairwise(over)]
    one_way = all(step >= 0 for step in steps) or all(step <= 0 for step in steps)
    listed = ", ".join(f"{speed:g}" for speed in over)
    checks = [
        Check(f"largest potential at {wide:g} cm/s at d = 2 (needs another than at d = 1: {usual:g})",
              abs(wide - usual)),
        Check(f"largest potential at {listed} cm/s over N_con = 1, 2, 4, 8 (needs to go one way, and to end elsewhere)",
              abs(over[-1] - over[0]) if one_way else -min(max(steps), -min(steps))),
    ]  # fmt: skip
    measured = "; ".join(
        f"{name}: largest at {top[name]:g} cm/s ({mean[top[name]]:.2f}), at 6 cm/s {mean[6.0]:.2f}"
        for name, mean in means.items()
    )
    said = f"rightward at 8 cm, {', '.join(f'{speed:g}' for speed in speeds)} cm/s, mean HS near the axis, {measured}"
    return _decided(checks, curves, said, "")


def _curve(rows: Rows, model: str, column: str) -> dict[float, dict[int, float]]:
    """Values of a column in one model's rightward crossings at 8 cm."""
    own = paper_trials(rows, model=model, motion="translation", direction="rightward", distance_cm=8.0)
    return peaks.curve(own, column)


def _common(curves: Mapping[Any, Curve]) -> list[float]:
    """The speeds at which every curve has a value."""
    return sorted(set.intersection(*(set(curve) for curve in curves.values())))


def _higher(value: float, name: str, bound: float, other: str, speed: float, what: str) -> Check:
    said = f"{what} of {name} {value:.3f} at {speed:g} cm/s (needs more than of {other}: {bound:.3f})"
    return Check(said, value - bound)


def _listed(means: Mapping[float, float]) -> str:
    return ", ".join(f"{mean:.2f} at {speed:g}" for speed, mean in means.items()) + " cm/s"


def _paired(first: Curve, second: Curve) -> str:
    """A paired test over all speeds: the models saw the same frames."""
    speeds = _common({0: first, 1: second})
    pairs = [
        (value, second[speed][trial])
        for speed in speeds
        for trial, value in first[speed].items()
        if trial in second[speed]  # one may have failed in some
    ]
    return str(paired([a for a, _ in pairs], [b for _, b in pairs]))


def _decided(checks: Sequence[Check], curves: Mapping[Any, Curve], measured: str, effect: str) -> Outcome:
    """The outcome; n counts the trials in which any of the models was judged, once each."""
    holds, decided = decide(checks)
    of_all = [curve[speed] for curve in curves.values() for speed in _common(curves)]
    n, each = len({trial for values in of_all for trial in values}), min(map(len, of_all))
    return Outcome("holds" if holds else "fails", measured, effect, n, decided, each)
