"""B2. Avoidance: fewer collisions than LGMD."""

from __future__ import annotations

from dataclasses import replace

from experiments.behaviours import AVOIDANCE
from experiments.bench.closed_loop.claims import (
    LGMD_RATIO,
    BehaviourClaim,
    Episodes,
    collisions_text,
    rarer,
    underpowered_text,
)
from experiments.bench.closed_loop.scores import rate_ratio
from experiments.bench.stats.verdict import Outcome


def judge(played: Episodes) -> Outcome:
    """Judge the ratio of both rates, and tell what the hybrid without direction does."""
    outcome = rarer(played, "lgmd", LGMD_RATIO)
    if not outcome.checks:
        return outcome
    outcome = replace(outcome, decided=outcome.decided + underpowered_text(played))
    if not played.get("lgmd-hybrid"):
        return outcome
    blind = rate_ratio(played["lgmd-hybrid"], played["hybrid"])
    beside = f"the hybrid without direction, a side by chance, {collisions_text(played['lgmd-hybrid'])}: {blind} times"
    return replace(outcome, measured=f"{outcome.measured}; {beside}")


CLAIM = BehaviourClaim(
    id="B2",
    title="Avoidance: fewer collisions than LGMD",
    says="hybrid avoidance collides less often per metre than LGMD alone",
    env=AVOIDANCE,
    cause="Either collides so seldom that the interval is wide; more episodes narrow it.",
    tried=(
        "Either collides seldom: a handful of collisions leave a wide interval (--full "
        "plays more seeds, and longer episodes). What the hybrid's own collisions have in common is that the "
        "LGMD1 is silent shortly before, though its potential is at its ceiling: a thing close ahead changes "
        "the picture by more grey levels a frame than the published veto of 10. With a veto of 22 it touched "
        "nothing, but only because the echo of each turn then set off the next and it circled on the spot, with"
        " direction and without; so the veto stays as published. Part of the gain is keeping to one side, which"
        " the hybrid without direction, measured beside it, does too."
    ),
    judge=judge,
)
