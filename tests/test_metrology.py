"""`colias_sim.metrology` and ``colias camera`` on frames of the simulated eye: its settings come back.

Each check holds for a camera as it is set, and fails for one with the constant 10 % off. `tests.test_eye` holds the eye
to closed forms by the same functions.
"""

from __future__ import annotations

import dataclasses
import math

import cv2
import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, SceneConfig, Simulation
from colias_sim.metrology import (
    MetrologyError,
    exposure_loop,
    fixed_pattern,
    noise_levels,
    photon_transfer,
    row_time_us,
)
from colias_sim.scene import FrameClock
from experiments.bench.cli import main
from experiments.bench.core.errors import UsageError
from experiments.bench.core.store.pictures import write_pictures
from experiments.bench.measured.camera import leaning

LENS = CameraConfig().forward_cm / 100
AWAY = Pose(-0.3, 0.0, 0.0)
PLAIN = SceneConfig(arena="plain", light_sd=0, turn_wall=False)
QUIET = CameraConfig(shot_noise=0.0, read_noise=0.0)
NOISY = CameraConfig(shot_noise=4.0, read_noise=2.0, gain=1.5)
ROLLING = dataclasses.replace(
    QUIET, fps=5.0, row_time_us=1e6 * FrameClock(5.0).timestep, row_bands=72, exposure_ms=0.0, supersample=4
)
LOOP = CameraConfig(auto_exposure=True, ae_start="cold")


def still(camera: CameraConfig, scene: SceneConfig, count: int, light: float = 1.0) -> np.ndarray:
    """Frames of a scene at rest, (T, R, C)."""
    with Simulation(camera=camera, scene=scene) as sim:
        rng = np.random.default_rng(3)
        sim.reset({"stimulus": AWAY}, np.random.default_rng(0), light=light)
        return np.stack([sim.step(rng).luma for _ in range(count)])


def measured_noise(camera: CameraConfig) -> dict[str, float]:
    """From one scene of many greys, and from the same in dimmer light."""
    scene = SceneConfig(light_sd=0, turn_wall=False)
    line = photon_transfer([noise_levels(still(camera, scene, 60, light)) for light in (0.15, 0.6)])
    return {"shot_noise": line.shot_noise(1.5), "read_noise": line.read_noise(1.5)}


def test_noise_comes_back():
    found = measured_noise(NOISY)
    for name, value in found.items():
        assert value == pytest.approx(getattr(NOISY, name), rel=0.05)


@pytest.mark.parametrize("constant", ["shot_noise", "read_noise"])
def test_noise_off_by_a_tenth_is_measured_so(constant):
    found = measured_noise(dataclasses.replace(NOISY, **{constant: 1.1 * getattr(NOISY, constant)}))
    assert found[constant] != pytest.approx(getattr(NOISY, constant), rel=0.05)


def crossing(camera: CameraConfig, speed: float) -> np.ndarray:
    """The empty scene, then a robot that crosses the view."""
    with Simulation(camera=camera, scene=PLAIN) as sim:
        rng = np.random.default_rng(0)
        sim.reset({"stimulus": AWAY}, rng)
        frames = [sim.step(rng).luma]
        sim.reset({"stimulus": Pose(LENS + 0.08, 0.032, -math.pi / 2)}, rng)
        robot = sim.robots["stimulus"]
        robot.drive(robot.wheels_for(speed, 0.0))
        return np.stack([*frames, *(sim.step(rng).luma for _ in range(4))])


def measured_rows(camera: CameraConfig) -> float:
    leans, speeds = zip(*leaning(crossing(camera, 0.08), camera.fps), strict=True)
    return row_time_us(leans, speeds)


def test_the_row_time_comes_back():
    assert measured_rows(ROLLING) == pytest.approx(ROLLING.row_time_us, rel=0.05)


def test_a_row_time_off_by_a_tenth_is_measured_so():
    other = dataclasses.replace(ROLLING, row_time_us=1.1 * ROLLING.row_time_us)
    assert measured_rows(other) != pytest.approx(ROLLING.row_time_us, rel=0.05)


def settlings(camera: CameraConfig) -> list[np.ndarray]:
    """From below and from above, each from another light, so that their last steps differ; two from far below."""
    frames = []
    with Simulation(camera=camera, scene=PLAIN) as sim:
        for light in (0.14, 0.17, *(0.25 * 1.023**i for i in range(12)), *(0.85 / 1.029**i for i in range(12))):
            rng = np.random.default_rng(0)
            sim.reset({"stimulus": AWAY}, rng, light=light)
            frames.append(np.stack([sim.step(rng).luma for _ in range(7)]))
    return frames


def found_loop(camera: CameraConfig) -> dict[str, float]:
    loop = exposure_loop(settlings(camera))
    assert loop.target is not None and loop.zone is not None
    return {"ae_step": loop.step, "ae_steps": loop.steps, "ae_target": loop.target, "ae_zone": loop.zone}


TOLERANCE = {"ae_step": 0.02, "ae_steps": 0.0, "ae_target": 0.01, "ae_zone": 0.05}
"""Relative. An end of the zone lies in an interval of about a step over the number of settlings: half a grey level."""


def test_the_exposure_loop_comes_back():
    loop = exposure_loop(settlings(LOOP))
    for interval, end in ((loop.low, LOOP.ae_target - LOOP.ae_zone), (loop.high, LOOP.ae_target + LOOP.ae_zone)):
        assert interval is not None and interval[0] <= end <= interval[1] < interval[0] + 1.5
    found = {"ae_step": loop.step, "ae_steps": loop.steps, "ae_target": loop.target, "ae_zone": loop.zone}
    for name, tolerance in TOLERANCE.items():
        assert found[name] == pytest.approx(getattr(LOOP, name), rel=tolerance), name


@pytest.mark.parametrize("constant", TOLERANCE)
def test_a_loop_off_by_a_tenth_is_measured_so(constant):
    value = getattr(LOOP, constant)
    wrong = value + 1 if isinstance(value, int) else 1.1 * value
    found = found_loop(dataclasses.replace(LOOP, **{constant: wrong}))
    assert found[constant] != pytest.approx(value, rel=TOLERANCE[constant])


def test_a_fixed_pattern_is_told_from_temporal_noise_and_shading():
    rng = np.random.default_rng(5)
    y, x = np.indices((40, 60))
    lit = 120 + 0.2 * x - 0.1 * y + 0.002 * x * x
    pattern = rng.normal(0, 1.5, lit.shape)
    for strength in (0.0, 1.0):
        frames = lit + strength * pattern + rng.normal(0, 2.0, (100, *lit.shape))
        found = fixed_pattern(np.rint(frames).astype(np.uint8))
        assert found == pytest.approx(1.5 * strength, rel=0.03, abs=0.1)


def test_frames_that_show_something_else_are_refused():
    flat = np.full((20, 10, 10), 100, np.uint8)
    with pytest.raises(MetrologyError, match="8 or more"):
        noise_levels(flat[:3])
    with pytest.raises(MetrologyError, match="clipped"):
        noise_levels(np.full((20, 10, 10), 255, np.uint8))
    with pytest.raises(MetrologyError, match="span"):
        photon_transfer([noise_levels(flat)])
    with pytest.raises(MetrologyError, match="settles"):
        exposure_loop([flat])
    with pytest.raises(MetrologyError, match="does not move"):
        row_time_us([0.1], [0.0])


def test_the_command_prints_settings_to_paste(tmp_path, capsys):
    """What it prints, given to ``--set``, is the camera that took the frames."""
    scene = SceneConfig(light_sd=0, turn_wall=False)
    write_pictures(tmp_path / "still-dim", still(NOISY, scene, 60, 0.3), ".png")
    write_pictures(tmp_path / "edge", crossing(ROLLING, 0.08), ".pgm")
    for number, frames in enumerate(settlings(LOOP)):
        write_pictures(tmp_path / f"loop-{number:02d}", frames, ".pgm")
    assert main.command(["camera", str(tmp_path), "--fps", "5", "--gain", "1.5"]) == 0
    printed = capsys.readouterr().out
    told = dict(line.removeprefix("--set camera.").split("=") for line in printed.splitlines() if "--set" in line)
    assert list(told) == [
        "gain", "shot_noise", "read_noise", "row_time_us", "auto_exposure", "ae_step", "ae_steps", "ae_target",
        "ae_zone",
    ]  # fmt: skip
    assert float(told["shot_noise"]) == pytest.approx(4.0, rel=0.1)
    assert CameraConfig(**{k: v for k, v in told.items() if k.startswith("ae") or k == "auto_exposure"}).ae_steps == 10


def test_folders_that_cannot_be_measured(tmp_path):
    with pytest.raises(UsageError, match=r"no folder of frames in it \(still\*"):
        main.command(["camera", str(tmp_path)])
    (tmp_path / "still").mkdir()
    with pytest.raises(UsageError, match="no pictures in it"):
        main.command(["camera", str(tmp_path)])
    cv2.imwrite(str(tmp_path / "still" / "0.png"), np.zeros((4, 4, 3), np.uint8))
    with pytest.raises(UsageError, match=r"0.png: expected 8-bit grey, found uint8 of shape \(4, 4, 3\)"):
        main.command(["camera", str(tmp_path)])
