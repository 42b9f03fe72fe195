"""The eye's parts against closed forms and the standards of camera metrology: EMVA 1288, ISO 12233."""

import dataclasses
import math
from unittest.mock import patch

import numpy as np
import numpy.typing as npt
import pytest

from colias_sim import CameraConfig, Pose, SceneConfig, Simulation
from colias_sim.calibrate import noise_levels, photon_transfer
from colias_sim.exposure import exposure_samples, next_exposure, plan_frame
from colias_sim.registers import GAMMA_VENDOR
from colias_sim.scene import steps_per_frame, timestep
from tests.colias_sim.views import LENS, PLAIN, QUIET, ROLLING, frames, view

Floats = npt.NDArray[np.float64]


# Rolling shutter.


def test_a_row_is_read_as_many_steps_before_the_last_as_it_is_above_it():
    steps = steps_per_frame(ROLLING.fps)
    read = {render.top: render.step for render in plan_frame(ROLLING, steps, 0.0)}
    assert read == {row: steps - (71 - row) for row in range(72)}


def test_each_band_is_exposed_in_its_own_window():
    """The mean moment of a band is the middle of its window, to half a physics step; the window has the exposure."""
    camera = dataclasses.replace(CameraConfig.preset("ov7670"), auto_exposure=False, exposure_ms=16.0)
    steps, step = steps_per_frame(camera.fps), timestep(camera.fps)
    plan = plan_frame(camera, steps, 16.0)
    for top, bottom in {(render.top, render.bottom) for render in plan}:
        renders = [render for render in plan if render.top == top]
        assert sum(render.parts for render in renders) == exposure_samples(camera, 16.0, steps) == 8
        middle = sum(render.step * render.parts for render in renders) / 8
        rows_after = 71 - (top + bottom - 1) / 2
        expected = steps - (rows_after * 418e-6 + 0.008) / step
        assert middle == pytest.approx(expected, abs=0.5)
        span = (renders[-1].step - renders[0].step) * step
        assert span == pytest.approx(0.016 * 7 / 8, abs=step)
    assert plan[0].step < 1, "its first rows are exposed before the frame before it ends"


def test_rows_read_one_by_one_are_a_still_scene_s_picture():
    """Of a scene at rest a rolling shutter takes the same picture, bit for bit."""
    pictures = []
    for camera in (QUIET, dataclasses.replace(QUIET, row_time_us=418.0, row_bands=7, exposure_samples=3)):
        pictures += [frame.luma for frame in frames(camera, SceneConfig(), Pose(LENS + 0.08, 0.0, 0.0), count=2)]
    for picture in pictures[1:]:
        np.testing.assert_array_equal(picture, pictures[0])


# The exposure loop.


def test_the_exposure_loop_answers_a_frame_in_the_next_but_one_by_whole_steps():
    """Each exposure is start x (1 + step)^n, the picture's mean goes with it, and it rests in the zone.

    The answer to frame 1 is in force from frame 3: n is 0, 0, 12, 24, ... (That the settings of a loop are those that
    its frames tell is a law of test_calibrate.py.)
    """
    loop = {"ae_start": "cold", "exposure_ms": 0.5, "ae_step": 0.05, "ae_steps": 12, "ae_target": 95.0}
    taken = frames(dataclasses.replace(QUIET, auto_exposure=True, **loop), PLAIN, count=12)
    steps = np.log([frame.exposure_ms / 0.5 for frame in taken]) / math.log(1.05)
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-2)
    assert np.rint(steps[:4]).tolist() == [0, 0, 12, 24] and np.diff(steps).max() <= 12.01
    means = [float(frame.luma.mean()) for frame in taken]
    assert means[-1] / means[2] == pytest.approx(1.05 ** (steps[-1] - 12), rel=0.02)
    assert steps[-1] == steps[-2] and 95.0 - 9.0 <= means[-1] <= 95.0 + 9.0


def test_the_exposure_ends_at_its_limits():
    camera = CameraConfig(auto_exposure=True, ae_max_ms=20.0, ae_min_ms=0.5)
    for mean, limit in ((0.0, 20.0), (255.0, 0.5)):
        exposure = camera.exposure_ms
        for _ in range(20):
            exposure = next_exposure(camera, exposure, mean, exposure)
        assert exposure == limit


def test_no_part_of_a_short_exposure_is_shorter_than_two_physics_steps():
    """There are as many parts as that allows, and no more than ``exposure_samples``."""
    camera = CameraConfig(auto_exposure=True, exposure_samples=4)
    for steps in (0.1, 1.0, 1.9, 2.0, 3.9, 4.1, 5.9, 6.1, 7.9, 8.1, 9.9, 17.9):
        plan = plan_frame(camera, steps_per_frame(30.0), 1000.0 * steps * timestep(30.0))
        samples = sum(render.parts for render in plan)
        assert samples == exposure_samples(camera, 1000.0 * steps * timestep(30.0), steps_per_frame(30.0))
        assert samples == 1 or steps / samples >= 2.0
        assert samples == camera.exposure_samples or steps / (samples + 1) < 2.0


# Light, saturation and noise.


def test_light_doubles_until_it_saturates():
    """A picture at twice the light is twice as bright, up to 255: textured wall, floor and dark shell."""
    once, twice = (
        view(dataclasses.replace(DIM, gain=gain), stimulus=Pose(LENS + 0.08, 0.0, 0.0)) for gain in (0.6, 1.2)
    )
    expected = np.minimum(2.0 * once, 255.0)
    assert (expected == 255.0).mean() > 0.3 and ((expected > 100.0) & (expected < 250.0)).mean() > 0.05
    assert np.abs(twice - expected).max() <= 3.0  # two roundings of each render, one doubled


DIM = dataclasses.replace(QUIET, multisample=0)
"""Without mixed pixels, of which some samples saturate before others."""


# Lens.


def photographs(camera: CameraConfig, render: npt.NDArray[np.uint8], count: int = 1) -> npt.NDArray[np.uint8]:
    """What the camera makes of a render, ``count`` times."""
    rng, frames = np.random.default_rng(0), []
    with (
        Simulation(camera=camera) as sim,
        patch.object(sim.camera("observer").offscreen, "render", return_value=render),
    ):
        for _ in range(count):
            sim.camera("observer").expose(sim.data)
            frames.append(sim.camera("observer").develop(rng, 0.0).luma)
    return np.stack(frames)


@pytest.mark.parametrize("sd", [0.2, 0.31, 1.0])
def test_the_lens_spreads_a_point_by_its_transfer(sd):
    """Which is exp(sd^2 (cos 2 pi f - 1)) along rows and along columns."""
    point = np.zeros((72, 99, 3), np.uint8)
    point[36, 49] = 255
    down, across = (np.fft.ifft(np.exp(sd**2 * (np.cos(2 * np.pi * np.fft.fftfreq(n)) - 1))).real for n in (72, 99))
    expected = 255 * np.outer(np.roll(down, 35), np.roll(across, 49))  # a render has its lowest row first
    luma = photographs(dataclasses.replace(QUIET, blur_px=sd), point)[0]
    np.testing.assert_allclose(luma, expected, rtol=0, atol=0.51)


# Falloff, gamma curve, contrast and brightness.

SHEET = {
    4: 0x04, 8: 0x07, 16: 0x10, 32: 0x28, 40: 0x36, 48: 0x44, 56: 0x52, 64: 0x60, 72: 0x6C, 80: 0x78, 96: 0x8C,
    112: 0x9E, 144: 0xBB, 176: 0xD2, 208: 0xE5,
}  # fmt: skip
"""Input of the gamma curve -> its output, of the data sheet's table after a reset."""
BETWEEN = {20: 22.0, 92: 0x8C - 5.0, 232: 0xE5 + 24 * 0x24 / 64}
"""The same within a segment; the highest has the slope SLOP / 64."""
STEPS_OF_CHART = np.unique([0.0, *SHEET, *BETWEEN, *range(6, 254, 20), 255])
FLAT = np.full((72, 99, 3), 200, np.uint8)
CURVED = CameraConfig(gamma=True)


def chart(camera: CameraConfig) -> Floats:
    """Luma of a chart of grey steps, 3 columns each, as a test bench measures it."""
    width = 3 * len(STEPS_OF_CHART)
    render = np.zeros((72, 99, 3), np.uint8)
    render[:, :width] = np.repeat(STEPS_OF_CHART, 3).astype(np.uint8)[None, :, None]
    frames = photographs(camera, render, 16)
    return np.array([frames[:, :, 3 * step : 3 * step + 3].mean() for step in range(len(STEPS_OF_CHART))])


def test_a_chart_of_grey_steps_has_the_gamma_curve_of_the_data_sheet():
    vendor = dict(zip(SHEET, GAMMA_VENDOR, strict=True))
    for camera, curve in ((CURVED, SHEET | BETWEEN), (dataclasses.replace(CURVED, gamma_points=GAMMA_VENDOR), vendor)):
        luma = chart(camera)[np.searchsorted(STEPS_OF_CHART, list(curve))]
        assert luma == pytest.approx(list(curve.values()), abs=0.3)


REGISTERS = CameraConfig(contrast=0x50, contrast_center=0x60, brightness=-24)


def test_contrast_and_brightness_are_those_of_their_registers():
    """Luma is (grey - CENTER) CONTRAS / 0x40 + CENTER + BRIGHT, between the clips at 0 and 255."""
    for camera, expected in (
        (REGISTERS, (STEPS_OF_CHART - 0x60) * 0x50 / 0x40 + 0x60 - 24),
        (CameraConfig(), STEPS_OF_CHART),
    ):
        inside = (expected > 3.0) & (expected < 252.0)
        assert chart(camera)[inside] == pytest.approx(expected[inside], abs=0.3)


def test_a_flat_field_falls_off_by_the_fourth_power_of_the_cosine():
    (y, x), per_px = np.indices((72, 99)), math.tan(math.radians(35.0)) / 49.5
    luma = photographs(dataclasses.replace(QUIET, vignetting=4.0), FLAT)[0]
    expected = 200 / (1 + ((y - 35.5) ** 2 + (x - 49.0) ** 2) * per_px**2) ** 2
    np.testing.assert_allclose(luma, expected, rtol=0, atol=0.51)


def test_the_light_falls_off_before_noise_and_the_curve_bends_noise_too():
    """Photon noise is that of the light behind the lens; the curve's slope at grey 68 is (0x6C - 0x60) / 8."""
    noisy = CameraConfig(shot_noise=4.0, read_noise=0.0, vignetting=4.0)
    levels = [noise_levels(photographs(noisy, FLAT, 200))]
    assert photon_transfer(levels)[0] == pytest.approx(4.0, rel=0.03)
    render = np.full_like(FLAT, 68)
    for gamma, slope in ((False, 1.0), (True, 1.5)):
        camera = CameraConfig(shot_noise=0.0, read_noise=1.0, gamma=gamma)
        variance = photographs(camera, render, 60).var(0, ddof=1).mean()
        assert variance == pytest.approx(slope**2 + 1 / 12, rel=0.03)


def settled(**changes: object) -> tuple[float, float]:
    """Exposure and mean luma of a small eye whose loop has settled."""
    loop = dataclasses.replace(QUIET, width=33, height=24, auto_exposure=True)
    (frame,) = frames(dataclasses.replace(loop, **changes), PLAIN)
    return frame.exposure_ms, float(frame.luma.mean())


def test_the_exposure_loop_meters_behind_the_lens_and_before_or_after_the_curve():
    zone = pytest.approx(108.0, abs=9.0 + 0.5)
    exposure, luma = settled()
    assert luma == zone
    for changes in ({"gamma": True}, {"brightness": 30}):
        before, after = (settled(ae_meter=meter, **changes) for meter in ("light", "luma"))
        assert before[0] == exposure and before[1] > 108.0 + 2 * 9.0, "the loop sees none of it"
        assert after[1] == zone and after[0] < 0.8 * exposure
    longer, luma = settled(vignetting=4.0)
    assert luma == zone and longer > 1.2 * exposure
