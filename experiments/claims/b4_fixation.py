"""B4. Fixation keeps the target in view."""

from __future__ import annotations

from experiments.behaviours import FIXATION
from experiments.bench.closed_loop.claims import BehaviourClaim, Episodes, above
from experiments.bench.judging.verdict import Outcome


def judge(played: Episodes) -> Outcome:
    """Judge the mean share of time."""
    return above(played, "fixation", "in_view", 0.8)


CLAIM = BehaviourClaim(
    id="B4",
    title="Fixation keeps the target in view",
    says="fixation keeps the target in view 80 % of the time",
    env=FIXATION,
    judge=judge,
)
