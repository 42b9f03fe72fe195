"""`colias_sim.calibrate` and ``colias camera`` on frames of the simulated eye: its settings come back.

Each check holds for a camera as it is set, and fails for one with the constant 10 % off.
"""

import dataclasses
import math
from functools import cache

import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, Simulation, calibrate
from colias_sim.calibrate import control_zone, exposure_loop, leaning, noise_levels, photon_transfer
from experiments.cli import main
from experiments.store.recordings import write_pictures
from tests.colias_sim.views import AWAY, LENS, PLAIN, ROLLING, STILL, crossing

NOISY = CameraConfig(shot_noise=4.0, read_noise=2.0, gain=1.5)
LOOP = CameraConfig(auto_exposure=True, ae_start="cold")
TOLERANCE = {"ae_step": 0.02, "ae_steps": 0.0, "ae_target": 0.01, "ae_zone": 0.05}
"""Relative. An end of the zone lies in an interval of about a step over the number of settlings: half a grey level."""


def still(camera: CameraConfig, count: int, light: float = 1.0) -> np.ndarray:
    """Frames of a scene at rest, (T, R, C)."""
    with Simulation(camera=camera, scene=STILL) as sim:
        rng = np.random.default_rng(3)
        sim.reset({"stimulus": AWAY}, np.random.default_rng(0), light=light)
        return np.stack([sim.step(rng).luma for _ in range(count)])


@cache
def crossed(camera: CameraConfig) -> np.ndarray:
    """The empty scene, then a robot that crosses the view at 8 cm/s."""
    with Simulation(camera=camera, scene=PLAIN) as sim:
        start = Pose(LENS + 0.08, 0.032, -math.pi / 2)
        return np.stack([frame.luma for frame in (*crossing(sim, AWAY, 0.0, 1), *crossing(sim, start, 0.08, 4))])


def test_the_row_time_comes_back():
    for factor in (1.0, 1.1):
        camera = dataclasses.replace(ROLLING, row_time_us=factor * ROLLING.row_time_us)
        leans, speeds = zip(*leaning(crossed(camera), camera.fps), strict=True)
        measured = calibrate.row_time_us(leans, speeds)
        assert (measured == pytest.approx(ROLLING.row_time_us, rel=0.05)) is (factor == 1.0)


@cache
def settlings(camera: CameraConfig) -> list[np.ndarray]:
    """From below and from above, each from another light, so that their last steps differ; two from far below."""
    frames = []
    with Simulation(camera=camera, scene=PLAIN) as sim:
        for light in (0.14, 0.17, *(0.25 * 1.023**i for i in range(12)), *(0.85 / 1.029**i for i in range(12))):
            rng = np.random.default_rng(0)
            sim.reset({"stimulus": AWAY}, rng, light=light)
            frames.append(np.stack([sim.step(rng).luma for _ in range(7)]))
    return frames


@pytest.mark.parametrize("wrong", [None, *TOLERANCE])
def test_the_exposure_loop_comes_back(wrong):
    value = None if wrong is None else getattr(LOOP, wrong)
    changed = {} if value is None else {wrong: value + 1 if isinstance(value, int) else 1.1 * value}
    films = settlings(dataclasses.replace(LOOP, **changed))
    step, steps, _ = exposure_loop(films)
    low, high = map(np.mean, control_zone(films, step))
    measured = {"ae_step": step, "ae_steps": steps, "ae_target": (low + high) / 2, "ae_zone": (high - low) / 2}
    near = {name: measured[name] == pytest.approx(getattr(LOOP, name), rel=TOLERANCE[name]) for name in measured}
    assert all(near.values()) if wrong is None else not near[wrong]


def test_few_settlings_exclude_no_truth_unflagged():
    """What is said to be certain holds the zone that the frames were taken with; two folders never are."""
    frames = settlings(LOOP)
    low, high = LOOP.ae_target - LOOP.ae_zone, LOOP.ae_target + LOOP.ae_zone
    few = [(0, 1, end) for end in range(14, 26)]
    for chosen in (*((a, b) for a in range(0, 14, 3) for b in range(14, 26, 3)), *few, tuple(range(26))):
        films = [frames[i] for i in chosen]
        step, steps, certain = exposure_loop(films)
        assert not certain or len(chosen) > 2
        if certain:
            assert step == pytest.approx(LOOP.ae_step, rel=0.02) and steps == LOOP.ae_steps, chosen
            for interval, end in zip(control_zone(films, step), (low, high), strict=True):
                assert interval is not None and interval[0] <= end <= interval[1], chosen
    assert certain  # of all of them


def grey(count: int, drift: float = 0.0) -> np.ndarray:
    """Frames of a scene of many greys, made by hand, (T, 40, 60); light drifts by a share."""
    rng = np.random.default_rng(0)
    scene = np.linspace(40, 215, 40 * 60).reshape(40, 60)
    light = 1.0 + drift * np.arange(count) / (count - 1)
    frames = light[:, None, None] * scene
    noise = rng.normal(size=frames.shape) * np.sqrt(4.0 + 16.0 * scene / 255)
    return np.clip(np.rint(frames + noise), 0, 255).astype(np.uint8)


def test_unsteadiness_is_the_share_of_the_variance():
    """Light that rises by a share s of grey g over T frames adds (s g)^2 T (T + 1) / (12 (T - 1)^2) to the variance."""
    scene = np.linspace(40, 215, 40 * 60)
    added = float(((0.1 * scene) ** 2).mean()) * 60 * 61 / (12 * 59**2)
    noise = 4.0 + 16.0 * float(scene.mean()) / 255 + 1 / 12
    assert calibrate.unsteadiness(grey(60, drift=0.1)) == pytest.approx(added / (added + noise), rel=0.05)
    assert calibrate.unsteadiness(grey(60)) == 0.0 and calibrate.unsteadiness(still(NOISY, 20)) == 0.0


BLINKS = (10, 20, (0, 255)), (30, 50, (20, 240))
SCENES = {
    "a ramp": np.linspace(40, 215, 40 * 60).reshape(40, 60),
    "black and white": np.where(np.random.default_rng(2).random((40, 60)) < 0.6, 20.0, 200.0),
    "low contrast": np.linspace(100, 125, 40 * 60).reshape(40, 60),
}


def lit(scene: np.ndarray, flicker: float = 0.0, row_us: float = 0.0) -> np.ndarray:
    """Frames, (200, R, C), at 30 a second under lamps on 50 Hz, by the data sheet's noise and a rolling shutter."""
    rng = np.random.default_rng(1)
    time_s = np.arange(200)[:, None] / 30 + 1e-6 * row_us * np.arange(len(scene))
    light = (1.0 + flicker * np.sin(2 * math.pi * 100 * time_s))[:, :, None] * scene
    noise = rng.normal(size=light.shape) * np.sqrt(0.64**2 + 1.28**2 * light / 255)
    return np.clip(np.rint(light + noise), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("scene", SCENES)
def test_neither_lamps_nor_bad_pixels_are_taken_for_noise(scene):
    """Lamps flicker by 5 % at 100 Hz: as a whole, as stripes of rows, and as columns of a camera on its side."""
    steady = lit(SCENES[scene])
    expected = photon_transfer([noise_levels(steady)])
    if scene != "low contrast":
        assert expected == pytest.approx((1.28, 0.64), rel=0.05)
    assert calibrate.unsteadiness(steady) == 0.0
    stripes = lit(SCENES[scene], 0.05, 418.0)
    for frames in (lit(SCENES[scene], 0.05), stripes, stripes.transpose(0, 2, 1)):
        assert photon_transfer([noise_levels(frames)]) == pytest.approx(expected, rel=0.05)
        assert calibrate.unsteadiness(frames) > 0.3, "and it is told"
    for frames in (steady, stripes):
        for row, column, greys in BLINKS:
            frames[:, row, column] = np.random.default_rng(3).choice(greys, len(frames))
        frames[:, 20, 20] = 240  # stuck
        assert photon_transfer([noise_levels(frames)]) == pytest.approx(expected, rel=0.05)
        assert (calibrate.unsteadiness(frames) > 0.3) is (frames is stripes)


def test_a_pixel_that_blinks_hides_no_edge():
    """Of a grey object, whose contrast is less than the pixel's."""
    frames = (80 + 0.3 * crossed(ROLLING)).astype(np.uint8)
    frames[:, 20, 50] = [255, 0, 255, 0, 255]
    measured = calibrate.row_time_us(*zip(*leaning(frames, ROLLING.fps), strict=True))
    assert measured == pytest.approx(ROLLING.row_time_us, rel=0.05)


def test_the_command_names_what_is_doubtful_and_gives_no_uncertain_setting(tmp_path, capsys):
    write_pictures(tmp_path / "still", grey(60, drift=0.1), ".png")
    for number in (0, 14):
        write_pictures(tmp_path / f"loop{number}", settlings(LOOP)[number], ".pgm")
    settings, notes = camera(tmp_path, capsys)
    assert set(settings) == {"gain", "shot_noise", "read_noise"} and len(notes) == 2


def camera(folder, capsys, *options: str) -> tuple[dict[str, str], list[str]]:
    """The settings that ``colias camera`` prints, and its notes."""
    assert main.command(["camera", str(folder), *options]) == 0
    out, err = capsys.readouterr()
    return dict(line.removeprefix("--set camera.").split("=") for line in out.splitlines() if "--set" in line), (
        err.splitlines()
    )


def test_the_command_prints_settings_to_paste(tmp_path, capsys):
    """What it prints, given to ``--set``, is the camera that took the frames."""
    write_pictures(tmp_path / "still-dim", still(NOISY, 60, 0.3), ".png")
    write_pictures(tmp_path / "edge", crossed(ROLLING), ".png")
    for number, frames in enumerate(settlings(LOOP)):
        write_pictures(tmp_path / f"loop-{number:02d}", frames, ".pgm")
    settings, notes = camera(tmp_path, capsys, "--fps", "5", "--gain", "1.5")
    assert set(settings) == {"gain", "shot_noise", "read_noise", "row_time_us", "auto_exposure", *TOLERANCE}
    assert not notes and CameraConfig(fps=5, **settings).ae_steps == 10
    assert float(settings["shot_noise"]) == pytest.approx(NOISY.shot_noise, rel=0.1)
    assert float(settings["read_noise"]) == pytest.approx(NOISY.read_noise, rel=0.1)
    assert float(settings["row_time_us"]) == pytest.approx(ROLLING.row_time_us, rel=0.05)
