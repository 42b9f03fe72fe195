"""B3. Optomotor better than standing still."""

from __future__ import annotations

from experiments.behaviours import OPTOMOTOR
from experiments.bench.closed_loop.claims import BehaviourClaim, Episodes, better_than_still
from experiments.bench.stats.verdict import Outcome


def judge(played: Episodes) -> Outcome:
    """Judge the PI reflex, and tell what the plain reflex and the privileged one do.

    The gain is a signed mean, so a reflex that swings to and fro may have much of it.
    """
    beside = ("optomotor", "oracle-heading")
    return better_than_still(played, OPTOMOTOR, "optomotor-pi", "optomotor_gain", 0.5, "rms_slip_deg_s", beside)


CLAIM = BehaviourClaim(
    id="B3",
    title="Optomotor better than standing still",
    says=(
        "the optomotor reflex by a PI rule has a gain above 0.5, less RMS slip than a robot that stands still, and a"
        " higher return"
    ),
    env=OPTOMOTOR,
    judge=judge,
)
