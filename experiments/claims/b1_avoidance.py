"""B1. Avoidance: five times fewer collisions."""

from __future__ import annotations

from experiments.behaviours import AVOIDANCE
from experiments.bench.closed_loop.claims import BehaviourClaim, Episodes, rarer
from experiments.bench.stats.verdict import Outcome

TIMES = 5.0


def judge(played: Episodes) -> Outcome:
    """Judge the ratio of both rates."""
    return rarer(played, against="straight", times=TIMES)


CLAIM = BehaviourClaim(
    id="B1",
    title="Avoidance: five times fewer collisions",
    says="hybrid avoidance collides at least 5 times less often per metre than the straight drive",
    env=AVOIDANCE,
    judge=judge,
)
