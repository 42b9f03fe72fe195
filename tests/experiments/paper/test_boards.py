"""The leaderboard: scores of generated tables. Ranks and who is on a board are the golden run's."""

import numpy as np
import polars as pl
import pytest

from experiments.declare.clip import Clip
from experiments.paper import boards as board
from experiments.paper.benchmark.rows import ROWS, row_of
from experiments.paper.boards import LOOMING
from experiments.paper.claims.clips import answer
from experiments.show.clips import ClipTrial


def table(*rows):
    """Responses; each row is a condition of its own where it names none."""
    made = [{"condition": f"c{i}", "model": "m", **row} for i, row in enumerate(rows)]
    return pl.DataFrame([dict.fromkeys(ROWS) | row for row in made], {"model": pl.String, **ROWS})


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


def looming_clips(peak, alarms, spiking=True):
    """Three approaches straight ahead at 0.9, and others at ``peak``."""
    ahead = zip((0.04, 0.08, 0.16), (0.2, 0.4, 1.0), strict=True)
    rows = [{"shown": "looming", "looming": 0.9, "condition": f"looming-even dark looming {s:g} s", "contact_s": t}
            for s, t in ahead]  # fmt: skip
    rows += [{"shown": shown, "looming": peak} for shown in ("receding", "upward", "grating")]
    counts = [alarms] * 3 + [0, 0, 3]
    spikes = [{"alarms": count, "seconds": 30.0} if spiking else {"contact_s": None} for count in counts]
    return table(*(row | spike for row, spike in zip(rows, spikes, strict=True)))


def scores(clips):
    """Scores of the looming board."""
    return {name: board.score(measure, clips) for name, measure in board.SCORES[LOOMING].items()
            if measure.task == "clips"}  # fmt: skip


def test_scores_of_an_ideal_looming_detector_of_a_silent_one_and_of_one_without_a_threshold():
    ideal = scores(looming_clips(0.6, 1))
    assert ideal["auc_translation"].value == ideal["auc_recession"].value == ideal["auc_background"].value == 1.0
    assert (ideal["answered"].value, ideal["answered"].n) == (1.0, 3)
    dark = ideal["contact_dark_s"]
    assert (dark.value, dark.low, dark.high, dark.n) == (0.4, 0.2, 1.0, 3) and ideal["contact_light_s"] is None
    assert (ideal["alarms_translation"].value, ideal["alarms_gratings"].value) == (0.0, 6.0)
    assert ideal["alarms_background"] is None
    silent = scores(looming_clips(0.9, 0))
    assert (silent["auc_translation"].value, silent["answered"].value) == (0.5, 0.0)
    without = scores(looming_clips(0.6, 0, spiking=False))
    assert without["answered"] is without["alarms_gratings"] is without["contact_dark_s"] is None
    assert without["auc_recession"].value == 1.0
