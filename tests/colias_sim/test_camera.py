"""The camera against geometry, photon statistics and a supersampled render."""

import dataclasses
import math
from unittest.mock import patch

import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, SceneConfig, Simulation
from tests.colias_sim.views import LENS, PLAIN, QUIET, STILL, crossing, frames, view


@pytest.mark.parametrize("distance", [0.05, 0.08, 0.10, 0.15])
def test_projected_size_is_the_pinhole_s(distance):
    """A cylinder of radius r at d subtends 2 asin(r / d), so its row of the image reaches f r / sqrt(d^2 - r^2)."""
    camera = CameraConfig.ideal()
    empty, row = view(camera, PLAIN)[36], view(camera, PLAIN, Pose(LENS + distance, 0.0, 0.0))[36]
    width = float(((empty - row) / (empty - row.min())).sum())  # partly covered pixels count by their share
    expected = 2 * camera.focal_px * 0.02 / math.sqrt(distance**2 - 0.02**2)
    assert width == pytest.approx(expected, rel=0.01)


def test_noise_is_fresh_in_every_frame_and_pixel():
    noisy = CameraConfig(shot_noise=0, read_noise=3.0)
    lumas = np.stack([frame.luma for frame in frames(noisy, SceneConfig(light=0.6, light_sd=0), count=100)])
    noise = lumas - lumas.mean(0)
    assert noise.std(0).min() > 2.0, "no pixel is stuck, the first of the generator's included"
    assert abs((noise[1:] * noise[:-1]).mean()) < 0.1
    assert abs((noise[:, :, 1:] * noise[:, :, :-1]).mean()) < 0.1


def test_luma_is_bt601():
    """The Y of YUV: a pure red, green and blue render weigh 0.299, 0.587 and 0.114."""
    with Simulation(camera=QUIET, scene=STILL) as sim:
        camera = sim.camera("observer")
        for channel, weight in enumerate((0.299, 0.587, 0.114)):
            rgb = np.zeros((72, 99, 3), np.uint8)
            rgb[..., channel] = 255
            with patch.object(camera.offscreen, "render", return_value=rgb):
                camera.expose(sim.data)
            assert camera.develop(np.random.default_rng(0), 0.0).luma[0, 0] == pytest.approx(255 * weight, abs=1)


def test_exposure_blurs_by_the_distance_moved():
    """The dark edge of a fast stimulus widens to speed times exposure, in pixels; an instant leaves it sharp."""
    widths = {}
    for exposure in (0.0, 33.0):
        samples = 16 if exposure else 1
        camera = dataclasses.replace(QUIET, exposure_ms=exposure, exposure_samples=samples, supersample=4)
        with Simulation(camera=camera, scene=PLAIN) as sim:
            row = crossing(sim, Pose(LENS + 0.08, 0.027, -math.pi / 2), 0.2, 8)[-1].luma[36].astype(float)
        empty = view(camera, PLAIN)[36]
        cover = (empty - row) / (empty - row.min())
        widths[exposure] = 6 * (cover * (1 - cover)).sum() / 2  # a linear ramp of n px sums to n / 6; two ramps
    moved = 0.2 * 0.033 / 0.08 * CameraConfig().focal_px
    assert widths[0.0] < 1.5
    assert widths[33.0] == pytest.approx(moved, rel=0.2)


def test_a_supersampled_pixel_is_the_mean_of_those_of_a_finer_picture():
    sharp = {"exposure_ms": 0.0, "exposure_samples": 1, "multisample": 0}
    sizes: list[dict[str, int]] = [{"supersample": 4}, {"width": 4 * 99, "height": 4 * 72}]
    coarse, fine = (
        view(dataclasses.replace(QUIET, **sharp, **size), stimulus=Pose(LENS + 0.08, 0.004, 0.0)) for size in sizes
    )
    np.testing.assert_allclose(coarse, fine.reshape(72, 4, 99, 4).mean((1, 3)), atol=1.0)
