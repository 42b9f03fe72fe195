"""Our own claims about behaviours, B1 to B4. Their words are in ``claims.toml``."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from experiments.behaviours import AVOIDANCE, FIXATION, OPTOMOTOR
from experiments.bench.closed_loop.claims import (
    LGMD_RATIO,
    BehaviourClaim,
    Episodes,
    better_than_still,
    collisions_text,
    rarer,
    underpowered_text,
)
from experiments.bench.closed_loop.scores import rate_ratio
from experiments.bench.stats.claim import shipped
from experiments.bench.stats.verdict import Outcome

claim = partial(shipped, BehaviourClaim)

TIMES = 5.0
"""How many times less often B1 asks a collision to be, in collisions a metre."""


@claim("B1", env=AVOIDANCE)
def b1(played: Episodes) -> Outcome:
    """Judge the ratio of both rates."""
    return rarer(played, against="straight", times=TIMES)


@claim("B2", env=AVOIDANCE)
def b2(played: Episodes) -> Outcome:
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


@claim("B3", env=OPTOMOTOR)
def b3(played: Episodes) -> Outcome:
    """Judge the PI reflex, and tell what the plain reflex and the privileged one do.

    The gain is a signed mean, so a reflex that swings to and fro may have much of it.
    """
    beside = ("optomotor", "oracle-heading")
    return better_than_still(played, OPTOMOTOR, "optomotor-pi", "optomotor_gain", 0.5, "rms_slip_deg_s", beside)


@claim("B4", env=FIXATION)
def b4(played: Episodes) -> Outcome:
    """Judge the PI reflex, and tell what the plain reflex and the privileged one do."""
    beside = ("fixation", "oracle-target")
    return better_than_still(played, FIXATION, "fixation-pi", "in_view", 0.8, "rms_off_axis_deg", beside)
