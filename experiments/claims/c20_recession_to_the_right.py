"""C20. Recession to the right counts more."""

from __future__ import annotations

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import Rows, more_on_one_side
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown, at 15 and 30 degrees together."""
    return more_on_one_side(rows, "recession", more=1.0, name="to the right against to the left")


CLAIM = RobotClaim(
    id="C20",
    title="Recession to the right counts more",
    eye="The weight of inhibition favours one direction at any contrast.",
    says="recession to the right elicits more than to the left",
    source="robot-sys-ar",
    motions=("recession",),
    implied=(
        "With w_i = 0.9 HS is from 0.9 times a part that changes sign with the direction and 0.1 times an excitation "
        "that is always rightward; a recession to the right moves rightward."
    ),
    mechanism=(
        "recession-mechanism",
        "excitation and inhibition over time, and what w_i = 0.9 leaves of symmetric motion",
    ),
    judge=judge,
)
