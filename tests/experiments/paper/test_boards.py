"""The leaderboard: scores of generated tables. Ranks and who is on a board are the golden run's."""

import numpy as np
import polars as pl
import pytest

from experiments.declare.clip import Clip
from experiments.paper.benchmark.rows import row_of
from experiments.paper.claims.clips import answer
from experiments.show.clips import ClipTrial


def extremes(hs=(0.0, 0.0), vs=(0.0, 0.0)):
    return dict(zip(("trough_hs", "peak_hs", "trough_vs", "peak_vs"), (*hs, *vs), strict=True))


def test_the_strongest_potential_of_both_systems_is_the_answer():
    assert answer(extremes((-0.1, 0.3), (-0.2, 0.2))) == "rightward"
    assert answer(extremes((-0.4, 0.3), (-0.2, 0.2))) == "leftward"
    assert answer(extremes((-0.1, 0.3), (-0.2, 0.31))) == "downward"
    assert answer(extremes((-0.1, 0.3), (-0.31, 0.2))) == "upward"
    assert answer(extremes((-0.3, 0.3))) is answer(extremes()) is None, "two alike, or silence, is no answer"


def test_alarms_and_seconds_of_a_clip_are_by_its_own_frame_rate():
    """Spikes 40 frames apart are one alarm at 100 frames/s, and would be two at 30."""
    trial = ClipTrial("looming", 0, 0, 4, Clip("near", "looming", {"fps": 100.0}), ())
    clip = list(trial.condition.build(4))
    spikes = np.zeros(len(clip), int)
    spikes[[-60, -20]] = 1
    row = {**extremes(), "model": "m", "trial": 0, "seed": 4, "experiment": "looming", "stimulus": "looming",
           "object": None, "fps": 100.0, "motion": "looming", "hs_spikes": None, "vs_spikes": None, "looming_spikes": 2,
           "peak_looming": 0.8, "frames": len(clip)}  # fmt: skip
    found = row_of(row, trial, pl.DataFrame({"looming_spikes": spikes}))
    assert (found["alarms"], found["seconds"], found["shown"]) == (1, len(clip) / 100, "looming")
    assert found["contact_s"] == pytest.approx(clip[-60].truth.time_to_contact_s)
