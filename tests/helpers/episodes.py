"""Rows of episodes that are made up, and the verdicts on them."""

from __future__ import annotations

from experiments.behaviours import AVOIDANCE, FIXATION, OPTOMOTOR
from experiments.bench.closed_loop import claims as closed_loop_claims
from experiments.bench.closed_loop.scores import COLUMNS


def rows(hits, misses=0, *, metres=1.0, seconds=10.0, **values):
    nothing = dict.fromkeys(COLUMNS)
    shared = {"driven_m": metres, "seconds": seconds, "reward": 0.0, **nothing, **values}
    return [{**shared, "seed": i, "touched": i < hits} for i in range(hits + misses)]


STILL = {"optomotor_gain": 0.0, "rms_slip_deg_s": 60.0, "in_view": 0.2, "rms_off_axis_deg": 90.0, "reward": 50.0}
"""Measures of a robot that stands still."""


def gaze(**values):
    """Episodes of Optomotor and Fixation at 20 seeds: a PI reflex with these ``values``, and a still robot."""
    better = {"optomotor_gain": 0.6, "rms_slip_deg_s": 59.0, "in_view": 0.9, "rms_off_axis_deg": 89.0, "reward": 51.0}
    still, steering = rows(0, 20, **STILL), rows(0, 20, **{**better, **values})
    return {
        OPTOMOTOR: {"optomotor-pi": steering, "still": still},
        FIXATION: {"fixation-pi": steering, "still": still},
    }


def outcomes(by_env):
    """Outcomes of the claims by id, of rows by env and behaviour."""
    return {claim.id: claim.outcome for claim in closed_loop_claims.judge(by_env)}


def judged(**played):
    """Outcomes of the claims about Avoidance by id, of rows by the behaviour's name."""
    return outcomes({AVOIDANCE: played})
