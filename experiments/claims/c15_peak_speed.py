"""C15. Spike count peaks near 6 cm/s."""

from __future__ import annotations

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import ACROSS, Rows, by_level, means, means_text, more_spikes, outcome_of
from experiments.bench.stats.tests import contrast, trend
from experiments.bench.stats.verdict import Outcome

PAIRS = ((4.0, 2.0), (6.0, 4.0), (6.0, 10.0))
"""Speeds in cm/s: more spikes are asked for at the first than at the second."""


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge rightward crossings, as in the paper, at the paper's four speeds; at all from 2 to 10 cm/s C31 does."""
    groups = by_level(rows, "speed_cm_s", motion="translation", distance_cm=8.0, direction="rightward")
    if not {2.0, 4.0, 6.0, 10.0} <= groups.keys():
        return Outcome.unjudged("needs rightward translations at 8 cm, 2, 4, 6 and 10 cm/s")
    mean = means(groups)
    checks = [more_spikes(mean, more, less, "cm/s") for more, less in PAIRS]
    rise = trend([(speed, groups[speed]) for speed in (2.0, 4.0, 6.0)])
    effect = f"2 to 6 cm/s: {rise}; 10 against 6: {contrast(groups[10.0], groups[6.0])}"
    return outcome_of(checks, groups, f"rightward at 8 cm: {means_text(groups, 'cm/s')}", effect)


CLAIM = RobotClaim(
    id="C15",
    title="Spike count peaks near 6 cm/s",
    eye="Crossings at 6 cm/s and slower are silent: HS stays below T.",
    says="at 8 cm: spikes rise 2 < 4 < 6 cm/s, peak near 6, and are fewer at 10 than at 6",
    source="robot-sys-trans",
    motions=ACROSS,
    mechanism=(
        "ensembles",
        "count, time in view, firing rate and potential, 2 to 30 cm/s, beside variants of the DSNN",
    ),
    judge=judge,
)
