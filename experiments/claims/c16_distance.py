"""C16. Spike count falls with distance."""

from __future__ import annotations

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import ACROSS, Rows, by_level, means, means_text, more_spikes, outcome_of
from experiments.bench.stats.checks import Check
from experiments.bench.stats.tests import trend
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge rightward crossings, as in the paper."""
    groups = by_level(rows, "distance_cm", motion="translation", speed_cm_s=6.0, direction="rightward")
    if not {5.0, 10.0, 15.0} <= groups.keys():
        return Outcome.unjudged("needs rightward translations at 6 cm/s, 5, 10 and 15 cm")
    mean = means(groups)
    half = mean[5.0] / 2
    text, asks = f"{mean[15.0]:.1f} spikes at 15 cm", f"at most half of those at 5: {half:.1f}"
    checks = [
        more_spikes(mean, 5.0, 10.0, "cm"),
        more_spikes(mean, 10.0, 15.0, "cm"),
        Check(text, mean[15.0], half, "at most", unit="spikes", asks=asks),
    ]
    effect = str(trend([(d, groups[d]) for d in (5.0, 10.0, 15.0)]))
    return outcome_of(checks, groups, f"rightward at 6 cm/s: {means_text(groups, 'cm')}", effect)


CLAIM = RobotClaim(
    id="C16",
    title="Spike count falls with distance",
    eye="At 6 cm/s crossings are silent at every distance.",
    says="at 6 cm/s: spikes fall 5 > 10 > 15 cm, by at least half from 5 to 15",
    source="robot-sys-trans",
    motions=ACROSS,
    mechanism=(
        "distance-mechanism",
        "count, time in view, firing rate and potential at 6 cm/s, 5 to 15 cm",
    ),
    judge=judge,
)
