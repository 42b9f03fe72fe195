"""Two eyes on one trial: the same physics, the answer of each eye as of a run with that camera alone."""

import numpy as np
import pytest

from experiments.show.robot import through
from tests.helpers import plans
from tests.helpers.played import Played
from tests.helpers.recordings import columns


def planned(*changes, eyes="one"):
    return plans.planned("distance", ("dsnn",), changes, 1, eyes=eyes).trials


@pytest.fixture(scope="module")
def seen():
    (spec, *_) = planned(eyes="both")
    return Played(spec, maps=True)


def alone(*changes):
    (spec, *_) = planned(*changes)
    return Played(spec)


def test_the_recording_shows_what_each_eye_saw_through_its_lens_and_what_its_model_counted(seen, tmp_path):
    (tmp_path / "both.rrd").write_bytes(seen.recording)
    held, true = columns(tmp_path / "both.rrd"), alone("camera.preset=ov7670")
    default, other = "/world/observer/camera", "/world/observer/camera_ov7670"
    for eye, single in ((default, alone()), (other, true)):
        np.testing.assert_array_equal(held[f"{eye}/image"]["buffer"], single.media.images[""].reshape(-1, 1, 72 * 99))
        assert all(held[eye][name] == held[default][name] for name in ("image_from_camera", "mat3x3", "translation"))
    for answer, eye in zip(seen.answers, (default, other), strict=True):
        images = np.array(held[f"{eye}/image"]["buffer"])
        assert (answer.darkest, answer.brightest) == (images.min(), images.max())
    assert f"{default}/exposure" not in held, "of a fixed exposure of all rows there is nothing to tell"
    np.testing.assert_array_equal(np.ravel(held[f"{other}/exposure"]["scalars"]), true.columns.exposure_ms)
    told = held["/__properties/trial"]
    assert told["seed"] == [[seen.trial.seed]] and len({answer.spikes for answer in seen.answers}) == 2
    assert all(told[f"{answer.model}_spikes"] == [[answer.spikes]] for answer in seen.answers)


def test_only_the_name_of_a_preset_is_an_eye():
    assert [through(label) for label in ("dsnn", "dsnn@ov7670", "me@home", "dsnn:w_i=1@ov7670")] == [
        "", "ov7670", "", "ov7670"
    ]  # fmt: skip


def test_the_eyes_have_size_clock_field_and_place_in_common():
    """A setting that says where the camera is, and how far it sees, is one of the robot: each eye has it."""
    place = ("camera.width=50", "camera.fps=25", "camera.hfov_deg=60", "camera.forward_cm=1", "camera.up_cm=1")
    both = Played(planned(*place, eyes="both")[0]).media.images["ov7670"]
    (single,) = alone("camera.preset=ov7670", *place).media.images.values()
    assert np.array_equal(both, single)


def test_each_eye_answers_as_in_a_run_with_that_camera_alone(seen):
    default, true = seen.answers
    assert (default.model, true.model) == ("dsnn", "dsnn@ov7670")
    for answer, single in ((default, alone()), (true, alone("camera.preset=ov7670"))):
        assert np.array_equal(answer.series.hs, single.answers[0].series.hs)
        assert np.array_equal(seen.columns.stimulus_x_cm, single.columns.stimulus_x_cm)
    assert not np.array_equal(default.series.hs, true.series.hs)
