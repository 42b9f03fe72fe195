"""B4. Fixation better than standing still."""

from __future__ import annotations

from experiments.behaviours import FIXATION
from experiments.bench.closed_loop.claims import BehaviourClaim, Episodes, better_than_still
from experiments.bench.stats.verdict import Outcome


def judge(played: Episodes) -> Outcome:
    """Judge the PI reflex, and tell what the plain reflex and the privileged one do."""
    beside = ("fixation", "oracle-target")
    return better_than_still(played, FIXATION, "fixation-pi", "in_view", 0.8, "rms_off_axis_deg", beside)


CLAIM = BehaviourClaim(
    id="B4",
    title="Fixation better than standing still",
    says=(
        "fixation by a PI rule keeps the target in view 80 % of the time, with less RMS angle off the axis than a robot"
        " that stands still, and a higher return"
    ),
    env=FIXATION,
    judge=judge,
)
