"""Laws of the street: who is painted is where the truth says, walkers' feet rest on the ground, leaves go nowhere."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest

from dsnn.stimuli import stimulus
from experiments.declare.clip import Clip, OfflineExperiment
from experiments.kinds.clips import play_clip
from experiments.paper.clips import SIDEWAYS
from experiments.settings.models import choose
from experiments.show.clips import trials_of
from tests.helpers.recordings import columns

EVEN = {"foliage": "none", "ground": "even"}
KINDS = {"person": {"height": 61.3, "speed": 53.7}, "car": {"kind": "car", "height": 31.7, "speed": 97.0}}
MOVERS = ("one", "opposite", "group")


@pytest.mark.parametrize(
    ("foliage", "movers", "motion"),
    [("none", "group", "rightward"), ("windblown", "one", "leftward"), ("windblown", "opposite", "rightward")],
)
def test_everyone_is_inside_the_truth_s_box_and_nobody_outside(foliage, movers, motion):
    common = {"seed": 3, "movers": movers, "motion": motion, "foliage": foliage, "height": 30.0, "speed": 100.0,
              "rows": 90, "columns": 160}  # fmt: skip
    clip, empty = stimulus("street", **common), stimulus("street", object="absent", **common)
    for frame, ground in zip(clip, empty, strict=True):
        rows, columns = np.nonzero(frame.luma != ground.luma)
        box = frame.truth.box
        if box is None:
            assert not len(rows)
            continue
        if len(rows):  # none if only a swinging leg's reach has come in
            assert rows.min() >= math.floor(box.top) and rows.max() < math.ceil(box.top + box.height)
            assert columns.min() >= math.floor(box.left) and columns.max() < math.ceil(box.left + box.width)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("motion", ["rightward", "leftward"])
def test_the_painted_mover_moves_at_the_speed_that_the_truth_says(kind, motion):
    """By the centroid of the rows above the legs or the wheels, on an even ground, to a tenth of a pixel."""
    clip = stimulus("street", motion=motion, ground_grey=200.0, **EVEN, **KINDS[kind])
    whole = [i for i in range(len(clip)) if (box := clip[i].truth.box) and box.left > 0 and box.left + box.width < 320]
    assert len(whole) > 30
    places, truths = [], []
    for i in whole:
        box = clip[i].truth.box
        dark = 200.0 - clip[i].luma[: int(box.top + 0.5 * box.height)].astype(float)
        places.append((dark * (np.arange(320) + 0.5)).sum() / dark.sum())
        truths.append(box.left + box.width / 2)
    offset = np.array(places) - truths  # a car's cabin is not over its middle
    assert np.ptp(offset) < 0.1 and abs(offset.mean()) < (4.0 if kind == "car" else 0.1)
    sign = 1 if motion == "rightward" else -1
    assert np.diff(places).mean() * 30 == pytest.approx(sign * KINDS[kind]["speed"], rel=2e-3)
    assert {clip[i].truth.velocity for i in whole} == {(sign * KINDS[kind]["speed"], 0.0)}


@pytest.mark.parametrize("motion", ["rightward", "leftward"])
def test_two_go_one_after_the_other_with_nobody_in_view_between(motion):
    clip = stimulus("street", movers="opposite", motion=motion, gap_s=0.8, rows=60, columns=96, height=50.0)
    words = [frame.truth.motion for frame in clip]
    kept = [word for word, after in pairwise([*words, ""]) if word != after]
    other = {"rightward": "leftward", "leftward": "rightward"}[motion]
    assert kept == ["swaying", motion, "swaying", other, "swaying"]
    last, first = len(words) - words[::-1].index(motion), words.index(other)
    assert (first - last) / 30 == pytest.approx(0.8, abs=2 / 30)


def test_a_seed_is_one_street_whoever_crosses_it():
    first = [stimulus("street", seed=6, movers=movers, motion=way)[0].luma for movers in MOVERS for way in SIDEWAYS]
    for other in first[1:]:
        np.testing.assert_array_equal(first[0], other)
    assert not np.array_equal(first[0], stimulus("street", seed=7)[0].luma)


# The experiment.


def test_a_row_tells_counts_and_peaks_and_hs_in_each_direction_and_against_it(tmp_path):
    clip = Clip("two", "street", {"movers": "opposite", "rows": 60, "columns": 96, "height": 50, "speed": 120})
    experiment = OfflineExperiment("mine", "", (clip,), ("dsnn",))
    done = play_clip(trials_of(experiment, (choose("dsnn", "offline"),), 1, 0)[0], recordings=True)
    (tmp_path / "clip.rrd").write_bytes(done.recording)
    assert columns(tmp_path / "clip.rrd")["/__properties/stimulus"]["seed"] == [[0]]
    hs = done.frames["hs"].to_numpy()
    words = np.array([frame.truth.motion for frame in clip.build(0)])
    (row,) = done.rows
    for name in ("hs", "vs"):
        assert (row[f"peak_{name}"], row[f"trough_{name}"]) == (done.frames[name].max(), done.frames[name].min())
        assert row[f"{name}_spikes"] == done.frames[f"{name}_spikes"].abs().sum()
    assert row["hs_rightward"] == pytest.approx(hs[words == "rightward"].max())
    assert row["hs_leftward"] == pytest.approx(hs[words == "leftward"].min())
    against = max(-hs[words == "rightward"].min(), hs[words == "leftward"].max(), 0.0)
    assert row["hs_against"] == pytest.approx(against)
    assert (row["movers"], row["foliage"], row["polarity"]) == ("opposite", "windblown", None)
    alone = dataclasses.replace(clip, changes=(*clip.changes, ("object", "absent")))
    experiment = OfflineExperiment("mine", "", (alone,), ("dsnn",))
    (row,) = play_clip(trials_of(experiment, (choose("dsnn", "offline"),), 1, 0)[0]).rows
    assert row["hs_rightward"] is row["hs_leftward"] is row["hs_against"] is None
