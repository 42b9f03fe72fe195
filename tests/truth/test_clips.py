"""What a clip shows and tells, recomputed from its recording: motion, sums, time."""

import numpy as np
import pytest

import experiments
from tests.truth.files import recount, trials
from tests.truth.flow import moved

AXES = {"rightward": (0, 1), "leftward": (0, -1), "downward": (1, 1), "upward": (1, -1)}
"""Motion -> the axis of the flow, and its sign in the image: right and down are positive."""


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    place = tmp_path_factory.mktemp("truth") / "clean"
    experiments.run("clean", repeats=1, seed=3, out=place, workers=0, quiet=True)
    return trials(place)


def test_the_images_flow_the_way_the_table_says(played):
    seen = set()
    for trial in played:
        if trial.row["motion"] not in AXES:
            continue
        axis, sign = AXES[trial.row["motion"]]
        flow = moved(trial.recording.images[::2])
        assert np.sign(flow[axis]) == sign and abs(flow[axis]) > 3 * abs(flow[1 - axis]), trial.row["clip"]
        potential = trial.frames[("hs", "vs")[axis]]
        assert np.sign(potential[np.abs(potential).argmax()]) == sign, trial.row["clip"]
        seen.add((trial.row["motion"], trial.row["clip"].split()[0]))
    assert len(seen) == 2 * len(AXES), "dark and light, four ways"


def test_counts_and_peaks_are_those_of_the_frames(played):
    for trial in played:
        recount(trial)
        assert trial.recording.columns["/__properties/stimulus"]["seed"] == [[trial.row["seed"]]]
    assert {-1, 1} == {int(np.sign(v)) for trial in played for v in trial.frames["vs_spikes"] if v}
