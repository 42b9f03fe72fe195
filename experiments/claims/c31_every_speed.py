"""C31. Most spikes at 5, 6 or 7 cm/s."""

from __future__ import annotations

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import ACROSS, Rows, by_level, means, means_text, more_spikes, outcome_of
from experiments.bench.stats.tests import contrast
from experiments.bench.stats.verdict import Outcome

SPEEDS = tuple(float(speed) for speed in range(2, 11))
"""Every speed that the words name, cm/s."""
NEAR = (5.0, 6.0, 7.0)
"""Where they put the peak, cm/s."""


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge rightward crossings, as in the paper: the most spikes near the peak against those at every other speed."""
    groups = by_level(rows, "speed_cm_s", motion="translation", distance_cm=8.0, direction="rightward")
    if not set(SPEEDS) <= groups.keys():
        return Outcome.unjudged("needs rightward translations at 8 cm, at 2 to 10 cm/s in steps of 1")
    named = {speed: groups[speed] for speed in SPEEDS}
    mean = means(named)
    top = max(NEAR, key=lambda speed: mean[speed])
    others = [speed for speed in SPEEDS if speed not in NEAR]
    checks = [more_spikes(mean, top, speed, "cm/s") for speed in others]
    second = max(others, key=lambda speed: mean[speed])
    effect = f"{top:g} against {second:g} cm/s: {contrast(named[top], named[second])}"
    return outcome_of(checks, named, f"rightward at 8 cm: {means_text(named, 'cm/s')}", effect)


CLAIM = RobotClaim(
    id="C31",
    title="Most spikes at 5, 6 or 7 cm/s",
    says="at 8 cm, at 2 to 10 cm/s in steps of 1: the most spikes at 5, 6 or 7 cm/s",
    source="robot-sys-trans and its text",
    motions=ACROSS,
    mechanism=(
        "ensembles",
        "count, time in view, firing rate and potential, 2 to 30 cm/s, beside variants of the DSNN",
    ),
    judge=judge,
)
