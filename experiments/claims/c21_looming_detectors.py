"""C21. Looming detectors: most ahead."""

from __future__ import annotations

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import ANGLES, Rows, of_pairs
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge at every speed shown: more spikes at 0 degrees than at any other angle."""
    return of_pairs(rows, "approach", [(0.0, angle) for angle in ANGLES if angle])


CLAIM = RobotClaim(
    id="C21",
    title="Looming detectors: most ahead",
    says=(
        "looming detectors (LGMD1 of Yue and Rind 2006, LGMD2 of Fu, Hu and Yue 2018, with their papers' constants) in "
        "the same approach trials, in the bright arena, show the opposite pattern: most at 0"
    ),
    source="robot-sys-ar",
    about="looming",
    motions=("approach",),
    cause="Both detectors measure how much edge moves, and an oblique approach moves more of it than a straight one.",
    tried=(
        "LGMD1 and LGMD2 with the constants of their papers, nothing tuned. Both measure how much edge moves: "
        "an oblique approach adds its sideways motion and ends as near as a straight one, so both fire least "
        "straight ahead. In the bright arena LGMD1's potential is near its ceiling for most of an approach; in "
        "the dim arena, where it does not saturate, it is nearly flat over angle. The thresholds are in grey "
        "levels per frame, made for other images than 99x72 before a white wall."
    ),
    judge=judge,
)
