"""The eye's frames: dropped and late ones, the range of luma, presets; a part that is off changes nothing."""

import dataclasses
import math
from itertools import pairwise

import numpy as np
import pytest

from colias_sim import CameraConfig, Frame, Pose, Simulation
from colias_sim.exposure import LAG_SDS
from colias_sim.registers import GAMMA_VENDOR
from colias_sim.scene import timestep
from colias_sim.sensor import Strips
from tests.colias_sim.views import QUIET, view

START = Pose(0.1, 0.03, -math.pi / 2)
PARTS = {
    "rolling shutter": {"row_time_us": 418.0},
    "exposure loop": {"auto_exposure": True, "exposure_samples": 4},
    "cold loop": {"auto_exposure": True, "ae_start": "cold", "exposure_ms": 0.5},
    "gain": {"gain": 0.5},
    "lens": {"blur_px": 0.31},
    "falloff": {"vignetting": 4.0},
    "gamma": {"gamma": True},
    "contrast": {"contrast": 72},
    "brightness": {"brightness": -8},
    "luma": {"luma_range": "video"},
    "drops": {"drop_probability": 0.3},
    "jitter": {"jitter_ms": 1.0},
    "antialiasing": {"supersample_columns": 3},
}


def crossing(sim: Simulation, seed: int = 1, count: int = 12) -> list[Frame]:
    rng, noise = np.random.default_rng(seed), np.random.default_rng(seed + 1)
    sim.reset({"stimulus": START}, rng)
    robot = sim.robots["stimulus"]
    robot.drive(robot.wheels_for(0.1, 0.0))
    return [sim.step(noise) for _ in range(count)]


def same(first: list[Frame], second: list[Frame]) -> bool:
    return all(
        np.array_equal(a.luma, b.luma) and (a.time, a.exposure_ms, a.age_ms) == (b.time, b.exposure_ms, b.age_ms)
        for a, b in zip(first, second, strict=True)
    )


@pytest.fixture(scope="module")
def usual() -> list[Frame]:
    with Simulation() as sim:
        return crossing(sim)


@pytest.mark.parametrize("part", PARTS)
def test_each_part_has_the_same_bits_again_and_others_without_it(part, usual):
    """After another trial in the same simulation, and in another one; and the part is not without effect."""
    camera = CameraConfig(**PARTS[part])
    with Simulation(camera=camera) as sim, Simulation(camera=camera) as other:
        first = crossing(sim)
        crossing(sim, seed=7, count=5)
        assert same(first, crossing(sim)) and same(first, crossing(other))
    assert not same(first, usual)


def test_parts_that_are_off_change_nothing(usual):
    """With every part explicitly off, whatever its other settings, the frames are the default's."""
    off = CameraConfig(
        row_time_us=0.0, row_bands=3, gain=1.0, auto_exposure=False, ae_target=50.0, ae_steps=3, ae_start="cold",
        ae_unit_ms=4.0, ae_meter="luma", blur_px=0.0, vignetting=0.0, gamma=False, gamma_points=GAMMA_VENDOR,
        contrast=64, contrast_center=50, brightness=0, luma_range="full", drop_probability=0.0, jitter_ms=0.0,
    )  # fmt: skip
    with Simulation(camera=off) as sim:
        assert same(crossing(sim), usual)
    assert {(frame.row_time_us, frame.age_ms) for frame in usual} == {(0.0, 0.0)}


def test_bands_that_are_read_together_are_those_read_one_by_one(monkeypatch):
    """Several bands of rows wait in one slot of the framebuffer, for this frame and for the next."""
    camera = dataclasses.replace(CameraConfig.preset("ov7670"), shot_noise=0.0, read_noise=0.0)
    with Simulation(camera=camera) as sim:
        together = crossing(sim, count=4)
        draw = Strips.draw

        def drawn_and_read(strips, data, eye, render, light, ahead):
            draw(strips, data, eye, render, light, ahead)
            strips.collect(light, ahead)

        monkeypatch.setattr(Strips, "draw", drawn_and_read)
        assert same(crossing(sim, count=4), together)


def test_frames_that_nobody_looks_at_leave_the_next_as_it_would_be():
    """Its first rows are exposed within the frame before, looked at or not."""
    camera = CameraConfig(row_time_us=418.0, exposure_samples=2, shot_noise=0.0, read_noise=0.0)
    with Simulation(camera=camera) as sim:
        frames = crossing(sim, count=6)
        crossing(sim, count=0)
        for i in range(6):
            sim.advance(look=i == 5)
        np.testing.assert_array_equal(
            sim.camera("observer").develop(np.random.default_rng(0), 0.0).luma, frames[5].luma
        )


def test_frames_are_dropped_as_often_as_set():
    """Within 3 standard errors; each has to be the one before again, older by a frame."""
    with Simulation(camera=CameraConfig(drop_probability=0.3)) as sim:
        rng = np.random.default_rng(3)
        sim.reset({"stimulus": START}, rng)
        frames = [sim.camera("observer").develop(rng, i / 30.0) for i in range(6000)]
    for before, frame in pairwise(frames):
        if frame.age_ms:
            assert frame.luma is before.luma
            assert frame.age_ms == pytest.approx(before.age_ms + 1000 / 30)
    share = sum(frame.age_ms > 0.0 for frame in frames) / len(frames)
    assert share == pytest.approx(0.3, abs=3 * math.sqrt(0.3 * 0.7 / 6000))


def test_the_clock_jitters_as_set():
    """Standard deviation of the clock in ms, without that of the rounding to physics steps."""
    jitter_ms = 2.0
    with Simulation(camera=CameraConfig(jitter_ms=jitter_ms, shot_noise=0.0, read_noise=0.0)) as sim:
        rng = np.random.default_rng(3)
        sim.reset({"stimulus": START}, rng)
        ages = np.array([sim.camera("observer").develop(rng, i / 30.0).age_ms for i in range(6000)])
    assert ages.min() >= 0.0, "a frame shows nothing that comes later"
    assert ages.mean() == pytest.approx(LAG_SDS * jitter_ms, rel=0.02)
    step_ms = 1000.0 * timestep(30.0)
    assert math.sqrt(ages[2:].var() - step_ms**2 / 12) == pytest.approx(jitter_ms, rel=0.04)


def test_video_range_is_16_to_235():
    """Y' = 16 + 219 Y / 255, of the sensor's clipped grey, rounded once."""
    pictures = []
    for luma_range in ("full", "video"):
        pictures.append(view(dataclasses.replace(QUIET, luma_range=luma_range), stimulus=START))
    np.testing.assert_allclose(pictures[1], 16 + 219 / 255 * pictures[0], atol=0.5)
    luma = view(CameraConfig(read_noise=64.0, luma_range="video"), stimulus=START)
    assert (luma.min(), luma.max()) == (16, 235)


def test_presets():
    assert CameraConfig.preset("default") == CameraConfig()
    eye = CameraConfig.preset("ov7670")
    assert eye.auto_exposure and eye.row_time_us * 72 == pytest.approx(480 * 2 * 784 / 25.0, rel=0.001)
    with pytest.raises(ValueError, match="ov7670"):
        CameraConfig.preset("ov9650")
    for name, meter in (("ov7670-gamma", "light"), ("ov7670-gamma-metered", "luma")):
        assert CameraConfig.preset(name) == dataclasses.replace(eye, gamma=True, ae_meter=meter)
