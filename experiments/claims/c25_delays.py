"""C25. Varied delays beat every fixed delay."""

from __future__ import annotations

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import ACROSS, DSNN, Rows
from experiments.bench.robot.mechanism import peaks
from experiments.bench.robot.mechanism.peaks import POTENTIAL
from experiments.bench.robot.mechanism.variants import (
    FALLING,
    FIXED,
    common_speeds,
    crossings,
    higher,
    means_text,
    outcome_of,
    paired_text,
)
from experiments.bench.stats.verdict import Outcome

SPEEDS = (4.0, 6.0, 8.0, 10.0)


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge mean HS over the frames near the axis. The delays of the DSNN as it is rise with spacing.

    Delays that fall with spacing are the other reading; their numbers stand beside and decide nothing.
    """
    curves = {label: crossings(rows, label, POTENTIAL) for label in (DSNN, FALLING, *FIXED.values())}
    if not set(SPEEDS) <= set(common_speeds(curves)):
        return Outcome.unjudged("needs rightward translations at 8 cm, 4, 6, 8 and 10 cm/s")
    named = {label: {speed: curve[speed] for speed in SPEEDS} for label, curve in curves.items()}
    means = {label: {speed: peaks.mean(values) for speed, values in curve.items()} for label, curve in named.items()}
    checks = [
        higher(means[DSNN][speed], "rising delays", means[label][speed], f"{delay} ms", speed, "mean HS")
        for delay, label in FIXED.items()
        for speed in SPEEDS
    ]
    won = sum(check.passes for check in checks)
    labels = {"rising 10..200 ms": DSNN, **{f"{delay} ms": label for delay, label in FIXED.items()}}
    texts = "; ".join(f"{name}: {means_text(means[label])}" for name, label in labels.items())
    other = f"the other reading, falling 200..10 ms: {means_text(means[FALLING])}"
    effect = "; ".join(
        f"against {delay} ms: {paired_text(named[DSNN], named[label])}" for delay, label in FIXED.items()
    )
    measured = (
        f"higher in {won} of {len(checks)} comparisons; rightward at 8 cm, mean HS near the axis, {texts}; {other}"
    )
    return outcome_of(checks, named, measured, effect)


CLAIM = RobotClaim(
    id="C25",
    title="Varied delays beat every fixed delay",
    says=(
        "spacing-dependent delays improve the speed response: a higher mean HS than each fixed delay (10, 50, "
        "100, 200 ms) at 4, 6, 8 and 10 cm/s"
    ),
    source=(
        "simu-clean-dth and its text; motion-models; the text on ensembles and dynamic delays; simu-sys-grayscale (c)"
    ),
    motions=ACROSS,
    reads=(POTENTIAL,),
    models=frozenset({DSNN, FALLING, *FIXED.values()}),
    cause="A fixed delay near the middle of the range answers as strongly as delays that rise with spacing.",
    tried=(
        "Delays that rise with spacing beat the shortest and the longest fixed delay at every speed, and "
        "neither of those between: a fixed delay of 100 ms, which is near their middle, answers as they do, and"
        " one of 50 ms answers more strongly to fast crossings. Delays that fall with spacing, the other "
        "reading of the paper's words, do worse than both."
    ),
    mechanism=(
        "ensembles",
        "count, time in view, firing rate and potential, 2 to 30 cm/s, beside variants of the DSNN",
    ),
    judge=judge,
)
