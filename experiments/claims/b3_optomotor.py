"""B3. Optomotor gain above one half."""

from __future__ import annotations

from experiments.behaviours import OPTOMOTOR
from experiments.bench.closed_loop.claims import BehaviourClaim, Episodes, above
from experiments.bench.judging.verdict import Outcome


def judge(played: Episodes) -> Outcome:
    """Judge the mean gain."""
    return above(played, "optomotor", "optomotor_gain", 0.5)


CLAIM = BehaviourClaim(
    id="B3",
    title="Optomotor gain above one half",
    says="the optomotor reflex's gain is above 0.5",
    env=OPTOMOTOR,
    judge=judge,
)
