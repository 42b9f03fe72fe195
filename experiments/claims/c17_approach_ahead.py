"""C17. Approach: fewest straight ahead."""

from __future__ import annotations

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import Rows, fewest_ahead
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown."""
    return fewest_ahead(rows, "approach")


CLAIM = RobotClaim(
    id="C17",
    title="Approach: fewest straight ahead",
    eye="Oblique approaches are as silent as straight ones.",
    says="approach: fewest spikes at 0; more at 30 than at 15 on each side",
    source="robot-sys-ar",
    cause="At the smaller angle few trials fire, so that the claim's margin of one spike decides.",
    tried=(
        "Nothing was tried to make it hold. Approaches at the smaller angle fire in few trials, on average about as"
        " many spikes as the claim asks for."
    ),
    motions=("approach",),
    mechanism=(
        "approach-mechanism",
        "excitation and inhibition over time, and what w_i = 0.9 leaves of symmetric motion",
    ),
    judge=judge,
)
