"""Trials in an arena of one's own: what does not fit, or is not seen, is refused before anything runs; reruns."""

import math

import cv2
import numpy as np
import pytest

from experiments import Experiment, Translation
from experiments.base.errors import UsageError
from experiments.draw.video import Reel
from experiments.show.course import nominal
from tests.helpers import plans
from tests.helpers.arenas import pillar, written
from tests.helpers.played import Played
from tests.helpers.recordings import columns


def planned(arena, *settings):
    return plans.planned("speed", ("dsnn",), [f"scene.arena={arena}", *settings], 1)


def test_a_hull_fits_by_the_room_that_is_measured(tmp_path):
    """The path is at 9.95 cm; its body has 2 cm, and no errors."""
    exact = ("experiment.pose_sd_mm=0", "experiment.heading_sd_deg=0")
    planned(written(tmp_path, pillar(0.0995 + 0.0301, 0.0)), *exact)
    with pytest.raises(UsageError, match="stimulus meets"):
        planned(written(tmp_path, pillar(0.0995 + 0.0298, 0.0)), *exact)
    with pytest.raises(UsageError, match="observer meets"):
        planned(written(tmp_path, pillar(0.0, 0.0)))


def test_a_wider_stimulus_begins_farther_out(tmp_path):
    """The run-up is as long; the edge of the view is passed by a body of the width that is set."""
    usual, wide = (planned("bright", f"scene.shell_width_cm={width}").trials[0] for width in (4, 6))
    (one, other) = (nominal(spec.condition, spec.settings)["stimulus"].route.start.y for spec in (usual, wide))
    half_view = math.radians(usual.settings.camera.hfov_deg / 2)
    assert 100 * (other - one) == pytest.approx(1.0 / math.cos(half_view))


def test_the_files_of_a_scene_are_on_its_run_s_record(tmp_path):
    """Columns of tables have their names alone. How a repetition compares them is in test_cli.py."""
    arena, picture = written(tmp_path, ""), str(tmp_path / "own.png")
    cv2.imwrite(picture, np.full((8, 8), 90, np.uint8))
    made = planned(arena, f"scene.shell_picture={picture}")
    assert made.resolved["files"].keys() == {arena, picture}
    assert [names["dsnn"] for names in made.parameters.values()] == ["own.xml", "own.png"]


def test_an_edited_arena_is_compiled_anew(tmp_path):
    """A notebook keeps the scenes of its process."""
    source = written(tmp_path, "")
    peaks = []
    for body in ("", '<geom type="box" size="0.001 0.3 0.15" pos="0.2 0 0.15" rgba="0.02 0.02 0.02 1"/>'):
        written(tmp_path, body)
        spec = plans.planned(
            Experiment("e", "one", Translation((20,), (8,)), varies="speed_cm_s", arena=source), ("dsnn",), repeats=1
        ).trials[0]
        peaks.append(Played(spec).answers[0].peak_hs)
    assert peaks[0] > peaks[1] + 0.1, "a black robot before a black card"


def test_a_recording_draws_the_obstacles(tmp_path):
    reels = []
    for arena in ("bright", written(tmp_path, pillar(0.2, 0.0))):
        path = tmp_path / "trial.rrd"
        path.write_bytes(Played(planned(arena, "experiment.speeds_cm_s=30").trials[0], maps=True).recording)
        reels.append(Reel(path))
    assert not reels[0].obstacles
    (outline,) = reels[1].obstacles
    np.testing.assert_allclose(np.hypot(outline[:, 0] - 20.0, outline[:, 1]), 1.0, atol=0.01)


def test_a_recording_draws_the_shell_as_the_condition_of_its_trial_sets_it(tmp_path):
    """As it draws one that is set for the whole scene, before which the condition goes."""

    def colours(experiment, *settings):
        path = tmp_path / "trial.rrd"
        path.write_bytes(Played(plans.planned(experiment, ("dsnn",), settings, 1).trials[0]).recording)
        return columns(path, static=True)["/world/stimulus"]["colors"]

    by_condition = colours("contrast", "experiment.shell_greys=0.7", "scene.shell_grey=0.3")
    dark, light = (colours("speed", "experiment.speeds_cm_s=30", f"scene.shell_grey={grey}") for grey in (0.3, 0.7))
    assert by_condition == light != dark
