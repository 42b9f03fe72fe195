"""Laws of the street: who is painted is where the truth says, walkers' feet rest on the ground, leaves go nowhere."""

import dataclasses
import math
from itertools import pairwise

import cv2
import numpy as np
import pytest

from dsnn.stimuli import stimulus
from dsnn.stimuli.movers import FOOT_SWING, Mover, group
from dsnn.stimuli.streams import stream
from experiments import street as declared
from experiments.bench.offline import play_clip
from experiments.bench.run.models import choose
from experiments.bench.sources.clips import Clip, OfflineExperiment

EVEN = {"foliage": "none", "ground": "even"}
KINDS = {"person": {"height": 61.3, "speed": 53.7}, "car": {"kind": "car", "height": 31.7, "speed": 97.0}}
MOVERS = ("one", "opposite", "group")


def lumas(clip):
    return np.stack([frame.luma for frame in clip])


def painted(clip, empty):
    """Which pixels differ from those of the same street without anybody, (T, R, C)."""
    return lumas(clip) != lumas(empty)


@pytest.mark.parametrize(
    ("foliage", "movers", "motion"),
    [("none", "group", "rightward"), ("windblown", "one", "leftward"), ("windblown", "opposite", "rightward")],
)
def test_everyone_is_inside_the_truth_s_box_and_nobody_outside(foliage, movers, motion):
    common = {"seed": 3, "movers": movers, "motion": motion, "foliage": foliage, "height": 60.0, "speed": 150.0}
    clip, empty = stimulus("street", **common), stimulus("street", object="absent", **common)
    assert len(clip) == len(empty)
    for there, frame in zip(painted(clip, empty), clip, strict=True):
        rows, columns = np.nonzero(there)
        box = frame.truth.box
        if box is None:
            assert not there.any()
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


@pytest.mark.parametrize(("kind", "movers"), [("person", "group"), ("car", "opposite")])
def test_leftward_on_an_even_ground_is_the_mirror_image(kind, movers):
    changes = {"movers": movers, "seed": 2, **EVEN, **KINDS[kind]}
    right, left = (stimulus("street", motion=motion, **changes) for motion in ("rightward", "leftward"))
    difference = lumas(right).astype(int) - lumas(left)[:, :, ::-1]
    assert np.abs(difference).max() <= 1  # by rounding
    for one, other in zip(right, left, strict=True):
        if one.truth.box is not None:
            assert one.truth.velocity.x == pytest.approx(-other.truth.velocity.x)
            assert one.truth.box.left == pytest.approx(320 - other.truth.box.left - other.truth.box.width)


@pytest.mark.parametrize("motion", ["rightward", "leftward"])
def test_two_go_one_after_the_other_with_nobody_in_view_between(motion):
    clip = stimulus("street", movers="opposite", motion=motion, gap_s=0.8)
    words = [frame.truth.motion for frame in clip]
    kept = [word for word, after in pairwise([*words, ""]) if word != after]
    other = {"rightward": "leftward", "leftward": "rightward"}[motion]
    assert kept == ["swaying", motion, "swaying", other, "swaying"]
    last, first = len(words) - words[::-1].index(motion), words.index(other)
    assert (first - last) / 30 == pytest.approx(0.8, abs=2 / 30)


def test_a_group_goes_one_way_at_speeds_and_sizes_of_its_members_own():
    nearest = Mover("person", 90.0, -70.0, 0.5, 167.4, 320, (40.0, 60.0, 120.0))
    members = group(nearest, 40, stream("street.movers", 0))
    heights, speeds = np.array([m.height for m in members]), np.array([m.velocity for m in members])
    assert (np.diff(heights) >= 0).all(), "from the farthest to the nearest"
    assert 58.5 <= heights.min() < 65 and 85 < heights.max() <= 90
    pace = -speeds / heights * 90 / 70
    assert 0.9 <= pace.min() < 0.93 and 1.07 < pace.max() <= 1.1
    assert (np.diff([m.ground for m in members]) >= 0).all(), "the nearer stand lower in the frame"
    words = {frame.truth.motion for frame in stimulus("street", movers="group", motion="leftward", seed=4)}
    assert words == {"swaying", "leftward"}


def test_a_walker_s_foot_rests_on_the_ground_once_a_stride():
    """The swing's fastest backward speed is the body's own: a larger one would slide back, a smaller one drag on."""
    stride = FOOT_SWING * 2 * math.pi
    phase = np.linspace(0, 1, 1000)
    foot = phase * stride + FOOT_SWING * np.sin(2 * np.pi * phase)
    assert np.diff(foot).min() == pytest.approx(0.0, abs=1e-6) and np.diff(foot).min() > -1e-9


def test_leaves_sway_on_the_spot_and_nothing_else_moves():
    clip = stimulus("street", object="absent", seed=1, speed=40.0)
    frames = lumas(clip).astype(float)
    moved = frames.std(axis=0) > 0
    assert 0.3 < moved.mean() < 0.6, "in parts of the view"
    assert {frame.truth.motion for frame in clip} == {"swaying"}
    still = stimulus("street", object="absent", foliage="none", seed=1)
    assert np.ptp(lumas(still), axis=0).max() == 0 and {frame.truth.motion for frame in still} == {"still"}
    calm = stimulus("street", object="absent", seed=1, amplitude_px=(0.0, 0.0))
    rest = calm[0].luma.astype(float)
    near = cv2.dilate((calm[0].luma != still[0].luma).astype(np.uint8), np.ones((9, 25), np.uint8)).astype(bool)
    assert not moved[~near].any() and near.mean() < 0.7, "the house front stands still"
    # On the average of the clip the leaves are where they hang at rest.
    mean = frames.mean(axis=0)
    at = [np.corrcoef(np.roll(rest, x, axis=1)[moved], mean[moved])[0, 1] for x in range(-4, 5)]
    assert abs(int(np.argmax(at)) - 4) <= 1


def test_a_seed_is_one_street_whoever_crosses_it():
    first = [
        stimulus("street", seed=6, movers=movers, motion=way)[0].luma for movers in MOVERS for way in declared.WAYS
    ]
    for other in first[1:]:
        np.testing.assert_array_equal(first[0], other)
    assert not np.array_equal(first[0], stimulus("street", seed=7)[0].luma)


# The experiment.


def test_a_row_tells_hs_in_each_direction_and_against_it():
    clip = Clip("two", "street", {"movers": "opposite", "rows": 60, "columns": 96, "height": 50, "speed": 120})
    experiment = OfflineExperiment("mine", "", (clip,), ("dsnn",))
    done = play_clip(experiment.trials((choose("dsnn", "offline"),), 1, 0)[0])
    hs = done.frames["hs"].to_numpy()
    words = np.array([frame.truth.motion for frame in clip.build(0)])
    (row,) = done.rows
    assert row["hs_rightward"] == pytest.approx(hs[words == "rightward"].max())
    assert row["hs_leftward"] == pytest.approx(hs[words == "leftward"].min())
    against = max(-hs[words == "rightward"].min(), hs[words == "leftward"].max(), 0.0)
    assert row["hs_against"] == pytest.approx(against)
    assert (row["movers"], row["foliage"]) == ("opposite", "windblown")
    alone = dataclasses.replace(clip, changes=(*clip.changes, ("object", "absent")))
    experiment = OfflineExperiment("mine", "", (alone,), ("dsnn",))
    (row,) = play_clip(experiment.trials((choose("dsnn", "offline"),), 1, 0)[0]).rows
    assert row["hs_rightward"] is row["hs_leftward"] is row["hs_against"] is None
