"""Scenes: they load in MuJoCo as they stand, measure what they should, and show what a camera there would see."""

import math

import cv2
import mujoco
import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, RobotConfig, SceneConfig, Simulation
from colias_sim.scene import OWN_BODY_GROUP, compile_model, compose, texels
from scenes import ARENAS, FOLDER, ROBOTS, generate
from tests.colias_sim.views import QUIET, STILL, view


@pytest.mark.parametrize("name", [*ARENAS, *ROBOTS])
def test_every_file_opens_by_itself(name):
    """As MuJoCo's own viewer would open it."""
    model = mujoco.MjModel.from_xml_path(str(FOLDER / f"{name}.xml"))
    mujoco.mj_step(model, mujoco.MjData(model))


def test_assets_are_what_the_generator_draws(tmp_path):
    generate.main(tmp_path)
    drawn = cv2.imread(str(tmp_path / "assets" / "clutter.png"), cv2.IMREAD_GRAYSCALE)
    kept = cv2.imread(str(FOLDER / "assets" / "clutter.png"), cv2.IMREAD_GRAYSCALE)
    assert np.abs(drawn.astype(int) - kept.astype(int)).max() <= 1
    assert (tmp_path / "arena_wall.xml").read_text() == (FOLDER / "arena_wall.xml").read_text()


def test_parameters_reach_the_model():
    robot = RobotConfig(track_cm=3.0, axle_back_cm=0.2, mass_g=40.0, max_speed_cm_s=20.0)
    camera = CameraConfig(up_cm=1.5, hfov_deg=60.0)
    model = compose(SceneConfig(), robot, camera, {"stimulus": "colias_black"}, "stimulus").compile()
    left, right = (model.body(f"stimulus/{side}_wheel").pos for side in ("left", "right"))
    assert [left[0], left[1], right[0], right[1]] == pytest.approx([-0.002, 0.015, -0.002, -0.015])
    assert model.body("stimulus/base").subtreemass[0] == pytest.approx(0.04)
    motor = model.actuator("stimulus/left")
    assert motor.ctrllimited and motor.ctrlrange.tolist() == pytest.approx([-20, 20])
    assert model.camera("stimulus/eye").pos[2] == pytest.approx(0.015)
    width = 2 * math.degrees(math.atan(99 / 2 / camera.focal_px))
    assert width == pytest.approx(60.0)


def test_the_observer_does_not_see_itself():
    """Leaving its own body out of its picture is a saving, not a change: the lens stands in front of it."""
    with Simulation(camera=QUIET, scene=STILL) as sim:
        sim.reset({"observer": Pose(0, 0, 0), "stimulus": Pose(0.1, 0.0, 1.0)}, np.random.default_rng(0))
        without = sim.step(np.random.default_rng(0)).luma
        sim.camera._option.geomgroup[OWN_BODY_GROUP] = 1
        with_body = sim.step(np.random.default_rng(0)).luma
        assert np.abs(with_body.astype(int) - without).max() <= 1  # rounding: no two frames are quite the same


@pytest.mark.parametrize(("arena", "low", "high"), [("bright", 220, 252), ("plain", 220, 252), ("dim", 90, 150)])
def test_brightness_of_the_arenas(arena, low, high):
    luma = view(CameraConfig(), SceneConfig(arena=arena, light_sd=0))
    assert low < luma.mean() < high
    # Lamps shade the wall gradually, clutter has edges.
    clutter = np.abs(np.diff(luma[:30], axis=1)).mean() / luma.mean()
    assert (clutter > 0.01) == (arena != "plain"), clutter


def test_a_picture_on_the_wall_stands_as_the_arena_s_own_texture_does():
    """The arena's own picture, given as a user's, is upright and not mirrored; the wall goes once around."""
    parts = RobotConfig(), CameraConfig(), {"observer": "colias"}, "observer"

    def wall(scene):
        model = compile_model(scene, *parts)
        tex = model.tex("wall").id
        return texels(model, "wall").reshape(model.tex_height[tex], model.tex_width[tex], -1)[..., 0].astype(float)

    default_wall = wall(SceneConfig())
    given = wall(SceneConfig(wall=str(FOLDER / "assets" / "clutter.png")))
    half = cv2.resize(given[:, : given.shape[1] // 2], default_wall.shape[::-1], interpolation=cv2.INTER_AREA)
    assert np.corrcoef(half.ravel(), default_wall.ravel())[0, 1] > 0.9
    for turned in (half[::-1], half[:, ::-1]):
        assert np.corrcoef(turned.ravel(), default_wall.ravel())[0, 1] < 0.5
    assert given.mean() == pytest.approx(default_wall.mean(), abs=1.0)
    np.testing.assert_array_equal(given[:, 0], given[:, -1])  # where it meets itself
