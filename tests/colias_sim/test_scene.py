"""Scenes: they load in MuJoCo as they stand, measure what they should, and show what a camera there would see."""

import dataclasses
import math
from contextlib import nullcontext
from unittest.mock import patch

import cv2
import mujoco
import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, RobotConfig, SceneConfig, Simulation
from colias_sim.scene import compile_model, compose, groups_of, hidden, texels
from scenes import ARENAS, FOLDER, ROBOTS, generate
from tests.colias_sim.views import QUIET, STILL, drawn, owners, view
from tests.helpers.arenas import written


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
    model = compose(SceneConfig(), robot, camera, {"stimulus": "colias_black"}).compile()
    left, right = (model.body(f"stimulus/{side}_wheel").pos for side in ("left", "right"))
    assert [left[0], left[1], right[0], right[1]] == pytest.approx([-0.002, 0.015, -0.002, -0.015])
    assert model.body("stimulus/base").subtreemass[0] == pytest.approx(0.04)
    motor = model.actuator("stimulus/left")
    assert motor.ctrllimited and motor.ctrlrange.tolist() == pytest.approx([-20, 20])
    assert model.camera("stimulus/eye").pos[2] == pytest.approx(0.015)
    assert camera.focal_px == pytest.approx(49.5 / math.tan(math.radians(30.0)))


PAIR = {"left": "colias", "right": "colias_black"}


@pytest.fixture
def pair():
    """Two robots that face each other, each with its eye behind and above its own body, which is then in its view."""
    with Simulation(camera=CameraConfig(multisample=0), robots=PAIR, seeing=False) as sim:
        sim.reset({"left": Pose(0.0, 0.0, 0.0), "right": Pose(0.12, 0.0, math.pi)}, np.random.default_rng(0))
        for name in PAIR:
            sim.model.camera(f"{name}/eye").pos[:] = -0.08, 0.0, 0.04
        mujoco.mj_forward(sim.model, sim.data)
        yield sim


def hit(sim, name):
    """The robots that rays through the pixels of an eye hit."""
    model, eye = sim.model, sim.data.camera(f"{name}/eye")
    rows, columns = np.mgrid[0:72, 0:99] + 0.5
    ways = np.stack([columns - 49.5, 36.0 - rows, np.full_like(rows, -CameraConfig().focal_px)], axis=-1)
    ways = (ways / np.linalg.norm(ways, axis=-1, keepdims=True)).reshape(-1, 3) @ eye.xmat.reshape(3, 3).T
    geoms, distances = np.zeros(len(ways), np.int32), np.zeros(len(ways))
    mujoco.mj_multiRay(model, sim.data, eye.xpos, ways.ravel(), mujoco.MjvOption().geomgroup, True, -1, geoms,
                       distances, None, len(ways), 10.0)  # fmt: skip
    return set(owners(model, geoms))


@pytest.mark.parametrize(("name", "other"), [("left", "right"), ("right", "left")])
def test_an_eye_sees_every_robot_but_its_own(pair, name, other):
    """In its picture, and by rays through its pixels; without hiding, it would see itself."""
    with hidden(groups_of(pair.model, name)):
        by_ray = hit(pair, name)
    assert name not in by_ray and other in by_ray
    seen = set(owners(pair.model, drawn(pair, name)).ravel())
    assert name not in seen and other in seen
    with patch("colias_sim.offscreen.hidden", nullcontext):
        assert {name, other} <= set(owners(pair.model, drawn(pair, name)).ravel()) & hit(pair, name)


def test_hidden_geoms_are_put_back_after_an_error_too(pair):
    groups = pair.model.geom_group.copy()
    with pytest.raises(KeyError), hidden(groups_of(pair.model, "left")), hidden(groups_of(pair.model, "left")):
        changed = {name for name in PAIR if np.ptp(groups_of(pair.model, name)) == 0}
        raise KeyError
    assert changed == {"left"}
    np.testing.assert_array_equal(pair.model.geom_group, groups)


def test_a_geom_of_an_arena_is_seen_in_every_group_that_mujoco_draws(tmp_path):
    """No group is a robot's own, so that an arena may use them all."""

    def luma(group):
        box = f'<geom name="box" type="box" size=".02 .02 .02" pos=".15 0 .02" rgba="0 0 0 1" group="{group}"/>'
        return view(QUIET, dataclasses.replace(STILL, arena=written(tmp_path, box)))

    usual, without = luma(0), luma(3)
    assert np.abs(usual.astype(int) - without).max() > 100
    for group in (1, 2):
        np.testing.assert_array_equal(luma(group), usual)


@pytest.mark.parametrize(("arena", "low", "high"), [("bright", 220, 252), ("plain", 220, 252), ("dim", 90, 150)])
def test_brightness_of_the_arenas(arena, low, high):
    luma = view(CameraConfig(), SceneConfig(arena=arena, light_sd=0))
    assert low < luma.mean() < high
    # Lamps shade the wall gradually, clutter has edges.
    clutter = np.abs(np.diff(luma[:30], axis=1)).mean() / luma.mean()
    assert (clutter > 0.01) == (arena != "plain"), clutter


def test_a_picture_on_the_wall_stands_as_the_arena_s_own_texture_does():
    """The arena's own picture, given as a user's, is upright and not mirrored; the wall goes once around."""
    parts = RobotConfig(), CameraConfig(), {"observer": "colias"}

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


def test_settings_of_the_apparatus_may_be_dictionaries():
    given = {"robot": {"track_cm": 3}, "camera": {"read_noise": 0}, "scene": {"arena": "dim"}}
    with Simulation(**given, seeing=False) as sim:
        assert sim.camera_config == CameraConfig(read_noise=0) and sim.scene == SceneConfig(arena="dim")
    for wrong in ({"camera": {"read_nois": 0}}, {"robot": {"track_cm": -1}}, {"scene": 5}):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            Simulation(**wrong, seeing=False)


def test_a_floor_s_reflectance_is_that_of_the_arena_or_the_one_given():
    """Light is linear, so the floor is as much darker as it reflects less, and the wall stays."""
    own, same, black = (view(QUIET, dataclasses.replace(STILL, floor=floor)) for floor in (None, 0.81, 0.1))
    np.testing.assert_array_equal(same, own)
    np.testing.assert_array_equal(black[:38], own[:38])
    np.testing.assert_allclose(black[41:], own[41:] * 0.1 / 0.81, atol=1.0)


@pytest.mark.parametrize("wall_cm", [30.0, 45.0, 100.0])
def test_the_wall_stands_as_far_away_as_it_says(wall_cm):
    """Its foot is below the horizon by the height of the lens over its distance, and it fills the view above."""
    camera = dataclasses.replace(QUIET, width=990, height=720)
    column = view(camera, SceneConfig(arena="plain", light_sd=0, turn_wall=False, floor=0.0, wall_cm=wall_cm))[:, 495]
    assert (column > 100).sum() == pytest.approx(360 + camera.focal_px * 2.0 / (wall_cm - camera.forward_cm), abs=1.5)
    assert column[0] > 100
