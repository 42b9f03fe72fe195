"""C18. Approach from the left counts more."""

from __future__ import annotations

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import Rows, more_on_one_side
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown, at 15 and 30 degrees together."""
    return more_on_one_side(rows, "approach", more=-1.0, name="from the left against from the right")


CLAIM = RobotClaim(
    id="C18",
    title="Approach from the left counts more",
    eye="The weight of inhibition favours one direction at any contrast.",
    says="approach from the left elicits more than from the right (w_i < 1 favours the preferred direction)",
    source="robot-sys-ar",
    motions=("approach",),
    implied=(
        "With w_i = 0.9 HS is from 0.9 times a part that changes sign with the direction and 0.1 times an excitation "
        "that is always rightward; an approach from the left moves rightward."
    ),
    mechanism=(
        "approach-mechanism",
        "excitation and inhibition over time, and what w_i = 0.9 leaves of symmetric motion",
    ),
    judge=judge,
)
