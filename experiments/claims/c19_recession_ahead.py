"""C19. Recession: fewest straight ahead."""

from __future__ import annotations

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import Rows, fewest_ahead
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown."""
    return fewest_ahead(rows, "recession")


CLAIM = RobotClaim(
    id="C19",
    title="Recession: fewest straight ahead",
    eye="Recession at -15 degrees is as silent as straight recession.",
    says="recession: fewest at 0; more at 30 than at 15 on each side",
    source="robot-sys-ar",
    motions=("recession",),
    cause=(
        "At -15 degrees w_i = 0.9 cancels most of the response; few trials fire, and a tie at 0 spikes counts "
        "as failed."
    ),
    tried=(
        "Recession at -15 degrees fires in few trials, straight recession in none, so the means of a few trials"
        " are often a tie at 0, which counts as a failure. At 15 cm/s2 or less -15 degrees is silent, and C13 "
        "wants no sharper start: of the accelerations tried between 10 and 100 cm/s2 none let both hold at nine"
        " seeds of ten. What silences it is what w_i = 0.9, the paper's own, leaves of symmetric motion, always"
        " rightward: with w_i = 1 a recession at -15 degrees fires in every trial tried. Without errors of the "
        "start pose it is silent in every trial."
    ),
    mechanism=(
        "recession-mechanism",
        "excitation and inhibition over time, and what w_i = 0.9 leaves of symmetric motion",
    ),
    judge=judge,
)
