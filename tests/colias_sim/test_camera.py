"""The camera against geometry, photon statistics and a supersampled render."""

import math
from unittest.mock import patch

import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, SceneConfig, Simulation

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


def test_noise_is_fresh_in_every_frame_and_pixel():
    with Simulation(camera=CameraConfig(shot_noise=0, read_noise=3.0), scene=SceneConfig(light=0.6, light_sd=0)) as sim:
        sim.reset({"stimulus": AWAY}, np.random.default_rng(0))
        rng = np.random.default_rng(1)
        frames = np.stack([sim.step(rng).luma for _ in range(100)]).astype(float)
    noise = frames - frames.mean(0)
    assert noise.std(0).min() > 2.0, "no pixel is stuck, the first of the generator's included"
    assert abs((noise[1:] * noise[:-1]).mean()) < 0.1
    assert abs((noise[:, :, 1:] * noise[:, :, :-1]).mean()) < 0.1


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


def test_a_supersampled_pixel_is_the_mean_of_those_of_a_finer_picture():
    sharp = {"exposure_ms": 0.0, "exposure_samples": 1, "multisample": 0}
    sizes: list[dict[str, int]] = [{"supersample": 4}, {"width": 4 * 99, "height": 4 * 72}]
    coarse, fine = (view(quiet(**sharp, **size), Pose(LENS + 0.08, 0.004, 0.0)) for size in sizes)
    np.testing.assert_allclose(coarse, fine.reshape(72, 4, 99, 4).mean((1, 3)), atol=1.0)
