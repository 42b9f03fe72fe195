"""Rows of episodes that are made up, and the verdicts on them."""

from __future__ import annotations

from experiments.behaviours import AVOIDANCE, FIXATION, OPTOMOTOR
from experiments.bench.closed_loop import claims as closed_loop_claims


def rows(hits, misses=0, *, metres=1.0, seconds=10.0, **values):
    nothing = dict.fromkeys(("in_view", "off_axis_deg", "gap_error_cm", "optomotor_gain"))
    shared = {"driven_m": metres, "seconds": seconds, "reward": 0.0, **nothing, **values}
    return [{**shared, "seed": i, "touched": i < hits} for i in range(hits + misses)]


def judged(**played):
    """Claims by id, of rows by the behaviour's name."""
    where = {"optomotor": OPTOMOTOR, "fixation": FIXATION}
    by_env = {}
    for name, rows_of in played.items():
        by_env.setdefault(where.get(name, AVOIDANCE), {})[name] = rows_of
    return {claim.id: claim.outcome for claim in closed_loop_claims.judge(by_env)}
