"""What a robot trial shows and tells, recomputed from its recording: motion, geometry, time, sums, light."""

import csv
import math

import numpy as np
import pytest
from scipy import stats

import experiments
from tests.truth.files import EYE, OBSERVER, STIMULUS, recount, trials
from tests.truth.flow import moved

FPS, FOCAL_PX, RADIUS_CM, HEIGHT_CM = 30.0, 49.5 / math.tan(math.radians(35)), 2.0, 3.0
HORIZON = slice(34, 39)
"""Rows in which the hull is seen from near and far: the lens is 1 cm below its top."""
REPEATS = 3
SIGNS = {"rightward": 1, "leftward": -1, "straight": 0}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("truth") / "general"
    settings = {"camera.preset": "ideal", "experiment.speed_cm_s": 10}
    experiments.run("general", repeats=REPEATS, seed=2, settings=settings, out=place, workers=0, quiet=True)
    return place


@pytest.fixture(scope="module")
def played(folder):
    found = trials(folder)
    assert len(found) == 4 * REPEATS
    return found


@pytest.fixture(scope="module")
def first(played):
    """The first trial of each condition: approach, recession, and the two crossings."""
    return {(trial.row["motion"], trial.row["direction"]): trial for trial in reversed(played)}


def outline(recording, frame):
    """Columns and rows (N, 2) in which the pinhole sees the rims of the stimulus's hull."""
    lens, turn, place = recording.pinhole()
    (observer, heading), (stimulus, _) = recording.poses(OBSERVER), recording.poses(STIMULUS)
    c, s = np.cos(heading[frame]), np.sin(heading[frame])
    to_world = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    around = np.linspace(0, 2 * math.pi, 181)
    rims = np.array([(RADIUS_CM * math.cos(a), RADIUS_CM * math.sin(a), z) for a in around for z in (0.0, HEIGHT_CM)])
    in_observer = (rims + stimulus[frame] - observer[frame]) @ to_world
    in_camera = (in_observer - place) @ turn
    seen = in_camera @ lens.T
    return seen[:, :2] / seen[:, 2:]


def dark_edges(image):
    """The column at which what is dark on the horizon begins, and that at which it ends."""
    dark = np.flatnonzero((image[HORIZON] < 125).all(axis=0))
    return dark.min(), dark.max() + 1


def test_the_pinhole_is_that_of_the_robots_camera(first):
    recording = first["translation", "rightward"].recording
    lens, turn, _ = recording.pinhole()
    assert recording.images.shape[1:] == (72, 99)
    assert lens[0, 0] == pytest.approx(FOCAL_PX, abs=0.01) and lens[1, 1] == pytest.approx(FOCAL_PX, abs=0.01)
    assert np.linalg.det(turn) == pytest.approx(1), EYE


@pytest.mark.parametrize("direction", ["rightward", "leftward"])
def test_the_images_flow_the_way_the_table_says(first, direction):
    trial = first["translation", direction]
    rightward, _ = moved(trial.recording.images)
    assert abs(rightward) > 50, "it crosses a view of 99 px"
    assert np.sign(rightward) == SIGNS[direction]
    assert np.sign(trial.frames["hs"][np.abs(trial.frames["hs"]).argmax()]) == SIGNS[direction]


@pytest.mark.parametrize("condition", [("approach", "straight"), ("translation", "rightward")])
def test_the_hulls_projection_is_where_the_image_is_dark(first, condition):
    recording = first[condition].recording
    compared = 0
    for frame, image in enumerate(recording.images):
        columns = outline(recording, frame)[:, 0]
        if columns.min() > 1 and columns.max() < 98:
            left, right = dark_edges(image)
            assert left == pytest.approx(columns.min(), abs=1.5), frame
            assert right == pytest.approx(columns.max(), abs=1.5), frame
            compared += 1
    assert compared >= 15


def test_the_arena_is_bright_and_the_hull_is_dark(played):
    floors = []
    for trial in played:
        image = trial.recording.images[len(trial.recording.images) // 2]
        left, right = (round(edge) for edge in dark_edges(image))
        assert np.median(image[HORIZON, left + 1 : right - 1]) == pytest.approx(255 * 0.02, abs=1.5)
        beside = np.delete(image, np.s_[max(left - 1, 0) : right + 1], axis=1)
        floors.append(np.median(beside[60:]))
        assert 170 < np.median(beside[:30]) < floors[-1], "the wall is cluttered, and darker than the floor"
    assert np.median(floors) == pytest.approx(245, abs=10)
    assert 1 < np.std(floors) < 15, "light differs by a few per cent between trials"


def test_time_is_frames_by_the_frame_rate(played):
    for trial in played:
        count = trial.row["frames"]
        assert len(trial.recording.images) == len(trial.frames["frame"]) == count
        assert np.array_equal(trial.frames["frame"], np.arange(count))
        np.testing.assert_allclose(trial.recording.time_s, (np.arange(count) + 1) / FPS, atol=1e-6)
        np.testing.assert_allclose(trial.frames["time_s"], trial.recording.time_s, atol=1e-6)


def test_the_achieved_speed_is_that_of_the_poses(played):
    for trial in played:
        place, _ = trial.recording.poses(STIMULUS)
        speeds = np.hypot(*np.diff(place[:, :2], axis=0).T) * FPS
        steady = speeds[speeds > 0.9 * trial.row["speed_cm_s"]]  # without starts and stops
        assert np.median(steady) == pytest.approx(trial.row["achieved_speed_cm_s"], rel=0.005)
        assert trial.row["achieved_speed_cm_s"] == pytest.approx(trial.row["speed_cm_s"], rel=0.01)
        np.testing.assert_allclose(trial.frames["stimulus_x_cm"], place[:, 0], atol=1e-4)
        np.testing.assert_allclose(trial.frames["stimulus_y_cm"], place[:, 1], atol=1e-4)


def test_counts_and_peaks_are_those_of_the_frames(played):
    for trial in played:
        recount(trial)
        row = trial.row
        assert row["firing_rate_hz"] == pytest.approx(row["spikes"] * FPS / row["frames"])
        if row["motion"] == "translation":
            assert {SIGNS[row["direction"]]} == {int(np.sign(v)) for v in trial.frames["hs_spikes"] if v}


def test_the_summary_is_the_mean_of_the_trials(folder, played):
    with (folder / "summary.csv").open() as file:
        table = list(csv.DictReader(file))
    seen = set()
    for line in table:
        values = [t.row[line["quantity"]] for t in played
                  if (t.row["motion"], t.row["direction"]) == (line["motion"], line["direction"])]  # fmt: skip
        assert int(line["n"]) == len(values) == REPEATS
        mean, sd = np.mean(values), np.std(values, ddof=1)
        assert float(line["mean"]) == pytest.approx(mean, abs=1e-9)
        assert float(line["sd"]) == pytest.approx(sd, abs=1e-9)
        assert float(line["median"]) == pytest.approx(np.median(values), abs=1e-9)
        # Student's, of few trials; of a quantity that cannot be negative it ends at 0.
        low, high = stats.t.interval(0.95, REPEATS - 1, mean, sd / math.sqrt(REPEATS)) if sd > 0 else (mean, mean)
        low = low if line["quantity"].startswith(("trough", "peak", "mean_hs", "drift")) else max(low, 0.0)
        assert float(line["ci_low"]) == pytest.approx(low, abs=1e-6), line
        assert float(line["ci_high"]) == pytest.approx(high, abs=1e-6), line
        seen.add((line["motion"], line["direction"], line["quantity"]))
    assert {(*condition, "spikes") for condition in {(t.row["motion"], t.row["direction"]) for t in played}} <= seen
