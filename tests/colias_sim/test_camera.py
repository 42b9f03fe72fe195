"""The camera against geometry, photon statistics and a supersampled render."""

import math
from unittest.mock import patch

import cv2
import mujoco
import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, SceneConfig, Simulation
from colias_sim.exposure import plan_frame
from colias_sim.scene import FrameClock

LENS = CameraConfig().forward_cm / 100
STILL = SceneConfig(light_sd=0, turn_wall=False)
PLAIN = SceneConfig(arena="plain", light_sd=0, turn_wall=False)
AWAY = Pose(-0.3, 0.0, 0.0)


def quiet(**changes: float) -> CameraConfig:
    return CameraConfig(**{"shot_noise": 0, "read_noise": 0, **changes})


def view(camera: CameraConfig, stimulus: Pose, scene: SceneConfig = STILL) -> np.ndarray:
    with Simulation(camera=camera, scene=scene) as sim:
        sim.reset({"stimulus": stimulus}, np.random.default_rng(0))
        return sim.step(np.random.default_rng(0)).luma.astype(float)


@pytest.mark.parametrize("distance", [0.05, 0.08, 0.10, 0.15])
def test_projected_size_is_the_pinhole_s(distance):
    """A cylinder of radius r at d subtends 2 asin(r / d), so its row of the image reaches f r / sqrt(d^2 - r^2)."""
    camera = CameraConfig.ideal()
    empty, row = view(camera, AWAY, PLAIN)[36], view(camera, Pose(LENS + distance, 0.0, 0.0), PLAIN)[36]
    width = float(((empty - row) / (empty - row.min())).sum())  # partly covered pixels count by their share
    expected = 2 * camera.focal_px * 0.02 / math.sqrt(distance**2 - 0.02**2)
    assert width == pytest.approx(expected, rel=0.01)


def test_left_of_the_robot_is_left_in_the_image():
    """The silhouette lies between the two tangents from the lens, at atan(y / x) -+ asin(r / d)."""
    luma = view(CameraConfig.ideal(), Pose(LENS + 0.08, 0.03, 0.0), PLAIN)
    dark = np.flatnonzero(luma[36] < 100)
    middle, half = math.atan2(0.03, 0.08), math.asin(0.02 / math.hypot(0.03, 0.08))
    edges = [49.5 - CameraConfig().focal_px * math.tan(middle + side * half) for side in (1, -1)]
    assert [dark[0], dark[-1] + 1] == pytest.approx(edges, abs=0.8)


@pytest.mark.parametrize("side", [1, -1])
def test_outside_the_field_of_view_is_unseen(side):
    """35 degrees to each side: a robot wholly beyond that leaves the picture as it was."""
    empty = view(quiet(), AWAY)
    beyond = side * (0.1 * math.tan(math.radians(35)) + 0.02 / math.cos(math.radians(35)) + 0.001)
    np.testing.assert_array_equal(view(quiet(), Pose(LENS + 0.1, beyond, 0.0)), empty)
    assert not np.array_equal(view(quiet(), Pose(LENS + 0.1, beyond - side * 0.004, 0.0)), empty)


def noise_of(camera: CameraConfig, stimulus: Pose, count: int = 200) -> tuple[np.ndarray, np.ndarray]:
    with Simulation(camera=camera, scene=STILL) as sim:
        sim.reset({"stimulus": stimulus}, np.random.default_rng(0))
        rng = np.random.default_rng(1)
        frames = np.stack([sim.step(rng).luma for _ in range(count)]).astype(float)
    return frames.mean(0), frames.var(0)


def test_noise_has_the_stated_variance():
    """read^2 + shot^2 L / 255, and 1/12 of quantisation, at every grey level that does not clip."""
    camera = CameraConfig(shot_noise=4.0, read_noise=2.0)
    mean, variance = noise_of(camera, Pose(LENS + 0.08, 0.0, 0.0))
    for low, high in ((100, 200), (200, 235), (235, 242)):
        chosen = (mean > low) & (mean < high)
        if chosen.sum() < 20:
            continue
        expected = camera.read_noise**2 + camera.shot_noise**2 * mean[chosen].mean() / 255 + 1 / 12
        assert variance[chosen].mean() == pytest.approx(expected, rel=0.05)


def test_noise_is_fresh_in_every_frame_and_pixel():
    with Simulation(camera=CameraConfig(shot_noise=0, read_noise=3.0), scene=SceneConfig(light=0.6, light_sd=0)) as sim:
        sim.reset({"stimulus": AWAY}, np.random.default_rng(0))
        rng = np.random.default_rng(1)
        frames = np.stack([sim.step(rng).luma for _ in range(100)]).astype(float)
    noise = frames - frames.mean(0)
    assert noise.std(0).min() > 2.0, "no pixel is stuck, the first of the generator's included"
    assert abs((noise[1:] * noise[:-1]).mean()) < 0.1
    assert abs((noise[:, :, 1:] * noise[:, :, :-1]).mean()) < 0.1


@pytest.mark.parametrize(
    ("changes", "silent"), [({}, True), ({"read_noise": 1.0}, False), ({"shot_noise": 1.0}, False)]
)
def test_each_noise_switches_by_itself(changes, silent):
    with Simulation(camera=quiet(**changes), scene=STILL) as sim:
        sim.reset({"stimulus": AWAY}, np.random.default_rng(0))
        rng = np.random.default_rng(1)
        first, second = sim.step(rng).luma, sim.step(rng).luma
    assert (np.abs(first.astype(int) - second).max() <= 1) == silent


def test_frames_saturate_instead_of_wrapping():
    luma = view(CameraConfig(shot_noise=30.0, read_noise=30.0), AWAY, SceneConfig(light=1.5, light_sd=0))
    assert luma.min() > 60


def test_luma_is_bt601():
    """The Y of YUV: a pure red, green and blue render weigh 0.299, 0.587 and 0.114."""
    with Simulation(camera=quiet(), scene=STILL) as sim:
        camera = sim.camera
        for channel, weight in enumerate((0.299, 0.587, 0.114)):
            rgb = np.zeros((72, 99, 3), np.uint8)
            rgb[..., channel] = 255
            with patch.object(camera._offscreen, "render", return_value=rgb):
                camera.expose(sim.data)
            assert camera.develop(np.random.default_rng(0), 0.0).luma[0, 0] == pytest.approx(255 * weight, abs=1)


@pytest.mark.parametrize(("luma_range", "black", "white"), [("full", 0, 255), ("video", 16, 235)])
def test_black_and_white_are_those_of_the_luma_range(luma_range, black, white):
    """ITU-R BT.601: 16 and 235 in the video range."""
    with Simulation(camera=quiet(luma_range=luma_range), scene=STILL) as sim:
        for grey, luma in ((0, black), (255, white)):
            with patch.object(sim.camera._offscreen, "render", return_value=np.full((72, 99, 3), grey, np.uint8)):
                sim.camera.expose(sim.data)
            assert set(sim.camera.develop(np.random.default_rng(0), 0.0).luma.ravel()) == {luma}


def test_exposure_blurs_by_the_distance_moved():
    """The dark edge of a fast stimulus widens to speed times exposure, in pixels; an instant leaves it sharp."""
    widths = {}
    for exposure in (0.0, 33.0):
        camera = quiet(exposure_ms=exposure, exposure_samples=16 if exposure else 1, supersample=4)
        with Simulation(camera=camera, scene=PLAIN) as sim:
            sim.reset({"stimulus": AWAY}, np.random.default_rng(0))
            empty = sim.step(np.random.default_rng(0)).luma[36].astype(float)
            sim.reset({"stimulus": Pose(LENS + 0.08, 0.027, -math.pi / 2)}, np.random.default_rng(0))
            robot = sim.robots["stimulus"]
            robot.drive(robot.wheels_for(0.2, 0.0))
            for _ in range(8):
                row = sim.step(np.random.default_rng(0)).luma[36].astype(float)
        cover = (empty - row) / (empty - row.min())
        widths[exposure] = 6 * (cover * (1 - cover)).sum() / 2  # a linear ramp of n px sums to n / 6; two ramps
    moved = 0.2 * 0.033 / 0.08 * CameraConfig().focal_px
    assert widths[0.0] < 1.5
    assert widths[33.0] == pytest.approx(moved, rel=0.2)


@pytest.mark.parametrize("supersample", [1, 2])
def test_a_still_scene_is_equally_bright_in_any_number_of_samples(supersample):
    one, two, three = (
        view(quiet(exposure_ms=20.0, exposure_samples=count, supersample=supersample), Pose(LENS + 0.08, 0.0, 0.0))
        for count in (1, 2, 3)
    )
    assert one.max() > 150.0
    assert np.abs(two - one).max() <= 1.0 and np.abs(three - one).max() <= 1.0


def test_a_picture_shows_the_scene_as_it_is_when_it_is_rendered():
    """Not as it was a physics step before, in which this robot comes 0.4 mm further."""
    camera = quiet(exposure_ms=0.0, exposure_samples=1, supersample=2)
    with Simulation(camera=camera, scene=PLAIN) as sim:
        rng = np.random.default_rng(0)
        sim.reset({"stimulus": Pose(LENS + 0.06, 0.02, -math.pi / 2)}, rng)
        robot = sim.robots["stimulus"]
        robot.drive(robot.wheels_for(0.2, 0.0))
        for _ in range(4):
            luma = sim.step(rng).luma
        mujoco.mj_forward(sim.model, sim.data)
        sim.camera.expose(sim.data)
        np.testing.assert_array_equal(sim.camera.develop(rng, sim.data.time).luma, luma)


def exposure_steps(config, steps):
    """The physics steps after which a frame's renders are due, one for each part of its exposure."""
    renders = plan_frame(config, steps, config.exposure_ms, 0).renders
    return tuple(render.step for render in renders for _ in range(render.parts))


def test_exposure_moments_are_the_middles_of_equal_parts_and_end_with_the_frame():
    n = FrameClock(30.0).steps
    assert exposure_steps(CameraConfig(exposure_ms=0, exposure_samples=1), n) == (n,)
    assert exposure_steps(CameraConfig(exposure_ms=1000 / 30, exposure_samples=2), n) == (
        round(n / 4),
        round(3 * n / 4),
    )
    moments = exposure_steps(CameraConfig(exposure_ms=200, exposure_samples=9), n)
    assert (min(moments) >= 1, max(moments) <= n, len(moments)) == (True, True, 9)


def shifted_frames(camera: CameraConfig, count: int = 24) -> np.ndarray:
    """The stimulus moved by a third of a pixel per frame, by hand, so that nothing but sampling differs."""
    step = 0.08 / camera.focal_px / 3
    frames = []
    with Simulation(camera=camera, scene=STILL) as sim:
        for i in range(count):
            sim.reset({"stimulus": Pose(LENS + 0.08, 0.004 - step * i, -math.pi / 2)}, np.random.default_rng(0))
            frames.append(sim.step(np.random.default_rng(0)).luma)
    return np.stack(frames).astype(float)


def test_antialiasing_keeps_a_third_of_a_pixel_smooth():
    """Against 16x16 samples a pixel: the default's error is well below a moving edge's change per frame.

    One sample a pixel, the renderer's cheapest, is worse than the signal itself.
    """
    truth = shifted_frames(quiet(exposure_ms=0, multisample=0, supersample=16))
    signal = np.diff(truth, axis=0)
    moving = np.abs(signal).max(0) > 10

    def error(camera: CameraConfig) -> float:
        return float((np.diff(shifted_frames(camera), axis=0) - signal)[:, moving].std() / signal[:, moving].std())

    default, none = error(quiet(exposure_ms=0)), error(quiet(exposure_ms=0, multisample=0))
    assert default < 0.6
    assert none > 1.0
    assert error(quiet(exposure_ms=0, supersample=4)) < 0.1


def test_luma_reference_of_the_supersampled_camera():
    """Supersampling averages areas: the mean grey of the picture stays."""
    few, many = view(quiet(supersample=1), Pose(LENS + 0.08, 0, 0)), view(quiet(supersample=8), Pose(LENS + 0.08, 0, 0))
    assert cv2.absdiff(few, many).mean() < 1.0
    assert few.mean() == pytest.approx(many.mean(), abs=0.5)


def test_cameras_come_and_go_without_touching_each_other():
    """Two contexts alive at once, one closed, one merely dropped: the survivor renders what it rendered before."""

    def picture(sim: Simulation) -> np.ndarray:
        sim.reset({"stimulus": Pose(LENS + 0.08, 0.0, 0.0)}, np.random.default_rng(0))
        return sim.step(np.random.default_rng(0)).luma

    with Simulation(camera=quiet(), scene=STILL) as survivor:
        before = picture(survivor)
        dropped, closed = Simulation(camera=quiet(), scene=PLAIN), Simulation(camera=quiet(), scene=STILL)
        np.testing.assert_array_equal(picture(closed), before)
        assert not np.array_equal(picture(dropped), before)
        closed.close()
        closed.close()
        del dropped
        np.testing.assert_array_equal(picture(survivor), before)


def test_a_simulation_tells_whether_it_has_a_camera():
    with Simulation() as simulation:
        assert simulation.seeing and simulation.camera is not None
    with Simulation(seeing=False) as simulation:
        assert not simulation.seeing
        with pytest.raises(ValueError, match="seeing=False"):
            _ = simulation.camera
