"""C30. Preferred speed moves with d, N_con."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import ACROSS, DSNN, Rows
from experiments.bench.robot.mechanism import peaks
from experiments.bench.robot.mechanism.peaks import POTENTIAL
from experiments.bench.robot.mechanism.variants import (
    CONNECTIONS,
    ROBOT_SPEEDS,
    WIDER,
    common_speeds,
    crossings,
    outcome_of,
)
from experiments.bench.stats.checks import Check, exceeds
from experiments.bench.stats.verdict import Outcome

USUAL = "d = 1, N_con = 8"
"""The DSNN as it is."""


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge the speed, of all those shown, at which mean HS near the axis is largest.

    It moves with d if it is another at d = 2 than at d = 1. It moves with N_con if over N_con = 1, 2, 4, 8 it goes
    one way, up or down, and ends elsewhere than it began. The paper's text gives neither a direction nor an amount.
    Of two speeds each has to be that of a larger potential in its own case, by the margin of potentials.
    """
    labels = {USUAL: DSNN, "d = 2": WIDER, **{f"N_con = {n}": CONNECTIONS[n] for n in (1, 2, 4)}}
    curves = {name: crossings(rows, label, POTENTIAL) for name, label in labels.items()}
    speeds = common_speeds(curves)
    if not set(ROBOT_SPEEDS) < set(speeds):
        return Outcome.unjudged("needs rightward translations at 8 cm, 2, 4, 6, 10 cm/s and others")
    means = {name: {speed: peaks.mean(curve[speed]) for speed in speeds} for name, curve in curves.items()}
    top = {name: peaks.peak(mean).speed for name, mean in means.items()}
    usual, wide = top[USUAL], top["d = 2"]
    over = [*(top[f"N_con = {n}"] for n in (1, 2, 4)), usual]
    steps = [after - before for before, after in itertools.pairwise(over)]
    one_way = all(step >= 0 for step in steps) or all(step <= 0 for step in steps)
    moved = abs(over[-1] - over[0]) if one_way else -min(max(steps), -min(steps))
    tops = ", ".join(f"{speed:g}" for speed in over)
    wider, connected = f"largest potential at {wide:g} cm/s at d = 2", f"largest potential at {tops} cm/s"
    checks = [
        Check(wider, abs(wide - usual), 0.0, unit="cm/s", asks=f"another than at d = 1: {usual:g}"),
        Check(f"{connected} over N_con = 1, 2, 4, 8", moved, 0.0, unit="cm/s",
              asks="to go one way, and to end elsewhere"),
        *(_leads(means, top, *pair) for pair in (("d = 2", USUAL), ("N_con = 1", USUAL)) if top[pair[0]] != usual),
    ]  # fmt: skip
    texts = "; ".join(
        f"{name}: largest at {top[name]:g} cm/s ({mean[top[name]]:.2f}), at 6 cm/s {mean[6.0]:.2f}"
        for name, mean in means.items()
    )
    measured = f"rightward at 8 cm, {', '.join(f'{speed:g}' for speed in speeds)} cm/s, mean HS near the axis, {texts}"
    return outcome_of(checks, curves, measured, "")


def _leads(means: Mapping[str, Mapping[float, float]], top: Mapping[str, float], one: str, other: str) -> Check:
    """Return the check that both potentials are larger at their own speed than at the other's, the lesser lead."""
    ways = ((one, other), (other, one))
    pairs = [(means[name][top[name]], means[name][top[than]], name, than) for name, than in ways]
    value, less, name, than = min(pairs, key=lambda pair: pair[0] - pair[1])
    text = f"{name}: mean HS {value:.4f} at {top[name]:g} cm/s"
    return exceeds(text, value, less, f"at {top[than]:g}, the speed at {than}", "potential")


CLAIM = RobotClaim(
    id="C30",
    title="Preferred speed moves with d, N_con",
    says=(
        "the speed of the largest potential moves with the sampling distance d and N_con, as the text on the peak says"
    ),
    source="robot-sys-trans and its text",
    motions=ACROSS,
    reads=(POTENTIAL,),
    models=frozenset({WIDER, *CONNECTIONS.values()}),
    cause="N_con sets how large the potential is, not at which speed it is largest.",
    tried=(
        "Wider spacing moves the speed of the largest potential up, as the paper says of fixed delays. The "
        "number of connections does not move it among the speeds shown: it sets how large the potential is. "
        "None of the variants shown moves it down to 6 cm/s; that the count is largest there is the time in "
        "view."
    ),
    mechanism=(
        "ensembles",
        "count, time in view, firing rate and potential, 2 to 30 cm/s, beside variants of the DSNN",
    ),
    judge=judge,
)
