"""Episodes that are made up: rows of their table, the verdicts on them, and one as it is kept."""

import polars as pl

from experiments.declare.behaviour import AVOIDANCE, FIXATION, OPTOMOTOR
from experiments.judge.scores import verdicts
from experiments.kinds.registry import claims_on
from experiments.show.episodes import EPISODES


def rows(hits, misses=0, *, metres=1.0, seconds=10.0, name="mine", env=AVOIDANCE, **values):
    """Episodes of a behaviour at seeds from 0 up, of which the first ``hits`` end by touching something."""
    shared = {"driven_m": metres, "seconds": seconds, "reward": 0.0, "model": name, "env": env, **values}
    played = [{**shared, "trial": i, "repeat": i, "seed": i, "touched": i < hits} for i in range(hits + misses)]
    return pl.DataFrame(played, EPISODES)


STILL = {"optomotor_gain": 0.0, "rms_slip_deg_s": 60.0, "in_view": 0.2, "rms_off_axis_deg": 90.0, "reward": 50.0}
"""Measures of a robot that stands still."""


def gaze(**values):
    """Episodes of Optomotor and Fixation at 20 seeds: a PI reflex with these ``values``, and a still robot."""
    better = {"optomotor_gain": 0.6, "rms_slip_deg_s": 59.0, "in_view": 0.9, "rms_off_axis_deg": 89.0, "reward": 51.0}
    played = []
    for env, name in ((OPTOMOTOR, "optomotor-pi"), (FIXATION, "fixation-pi")):
        played.append(rows(0, 20, name=name, env=env, **{**better, **values}))
        played.append(rows(0, 20, name="still", env=env, **STILL))
    return played


def outcomes(played):
    """Outcomes of the claims by id, of tables of one behaviour each."""
    found, claims = {}, claims_on("behaviours").values()
    for env in (AVOIDANCE, OPTOMOTOR, FIXATION):
        tables = [table for table in played if table["env"][0] == env]
        if tables:
            names = [table["model"][0] for table in tables]
            found |= {verdict.id: verdict.outcome for verdict in verdicts(claims, env, names, pl.concat(tables))}
    return found


def judged(**played):
    """Outcomes of the claims about Avoidance by id, of rows by the behaviour's name."""
    return outcomes([table.with_columns(model=pl.lit(name)) for name, table in played.items()])
