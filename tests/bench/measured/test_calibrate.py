"""`colias_sim.calibrate` and ``colias camera`` on frames of the simulated eye: its settings come back.

Each check holds for a camera as it is set, and fails for one with the constant 10 % off. `tests.colias_sim.test_eye`
holds the eye to closed forms by the same functions.
"""

from __future__ import annotations

import dataclasses
import math
from functools import cache

import cv2
import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, SceneConfig, Simulation
from colias_sim.calibrate import (
    CalibrationError,
    ExposureLoop,
    exposure_loop,
    fixed_pattern,
    noise_levels,
    photon_transfer,
    row_time_us,
    unsteadiness,
)
from colias_sim.scene import FrameClock
from experiments.bench.cli import main
from experiments.bench.measured.camera import leaning
from experiments.bench.run.errors import UsageError
from experiments.bench.store.pictures import write_pictures

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
    measured = measured_noise(NOISY)
    for name, value in measured.items():
        assert value == pytest.approx(getattr(NOISY, name), rel=0.05)


@pytest.mark.parametrize("constant", ["shot_noise", "read_noise"])
def test_noise_off_by_a_tenth_is_measured_so(constant):
    measured = measured_noise(dataclasses.replace(NOISY, **{constant: 1.1 * getattr(NOISY, constant)}))
    assert measured[constant] != pytest.approx(getattr(NOISY, constant), rel=0.05)


@cache
def crossing(camera: CameraConfig) -> np.ndarray:
    """The empty scene, then a robot that crosses the view at 8 cm/s."""
    with Simulation(camera=camera, scene=PLAIN) as sim:
        rng = np.random.default_rng(0)
        sim.reset({"stimulus": AWAY}, rng)
        frames = [sim.step(rng).luma]
        sim.reset({"stimulus": Pose(LENS + 0.08, 0.032, -math.pi / 2)}, rng)
        robot = sim.robots["stimulus"]
        robot.drive(robot.wheels_for(0.08, 0.0))
        return np.stack([*frames, *(sim.step(rng).luma for _ in range(4))])


def measured_rows(camera: CameraConfig) -> float:
    leans, speeds = zip(*leaning(crossing(camera), camera.fps), strict=True)
    return row_time_us(leans, speeds)


def test_the_row_time_comes_back():
    assert measured_rows(ROLLING) == pytest.approx(ROLLING.row_time_us, rel=0.05)


def test_a_row_time_off_by_a_tenth_is_measured_so():
    other = dataclasses.replace(ROLLING, row_time_us=1.1 * ROLLING.row_time_us)
    assert measured_rows(other) != pytest.approx(ROLLING.row_time_us, rel=0.05)


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


def constants(loop: ExposureLoop) -> dict[str, float]:
    assert loop.target is not None and loop.zone is not None
    return {"ae_step": loop.step, "ae_steps": loop.steps, "ae_target": loop.target, "ae_zone": loop.zone}


TOLERANCE = {"ae_step": 0.02, "ae_steps": 0.0, "ae_target": 0.01, "ae_zone": 0.05}
"""Relative. An end of the zone lies in an interval of about a step over the number of settlings: half a grey level."""


def test_the_exposure_loop_comes_back():
    loop = exposure_loop(settlings(LOOP))
    for interval, end in ((loop.low, LOOP.ae_target - LOOP.ae_zone), (loop.high, LOOP.ae_target + LOOP.ae_zone)):
        assert interval is not None and interval[0] <= end <= interval[1] < interval[0] + 1.5
    measured = constants(loop)
    for name, tolerance in TOLERANCE.items():
        assert measured[name] == pytest.approx(getattr(LOOP, name), rel=tolerance), name


@pytest.mark.parametrize("constant", TOLERANCE)
def test_a_loop_off_by_a_tenth_is_measured_so(constant):
    value = getattr(LOOP, constant)
    wrong = value + 1 if isinstance(value, int) else 1.1 * value
    measured = constants(exposure_loop(settlings(dataclasses.replace(LOOP, **{constant: wrong}))))
    assert measured[constant] != pytest.approx(value, rel=TOLERANCE[constant])


def test_a_fixed_pattern_is_told_from_temporal_noise_and_shading():
    rng = np.random.default_rng(5)
    y, x = np.indices((40, 60))
    lit = 120 + 0.2 * x - 0.1 * y + 0.002 * x * x
    pattern = rng.normal(0, 1.5, lit.shape)
    for strength in (0.0, 1.0):
        frames = lit + strength * pattern + rng.normal(0, 2.0, (100, *lit.shape))
        measured = fixed_pattern(np.rint(frames).astype(np.uint8))
        assert measured == pytest.approx(1.5 * strength, rel=0.03, abs=0.1)


def test_frames_that_show_something_else_are_refused():
    flat = np.full((20, 10, 10), 100, np.uint8)
    with pytest.raises(CalibrationError):
        noise_levels(flat[:3])
    with pytest.raises(CalibrationError):
        noise_levels(np.full((20, 10, 10), 255, np.uint8))
    with pytest.raises(CalibrationError):
        photon_transfer([noise_levels(flat)])
    with pytest.raises(CalibrationError):
        exposure_loop([flat])
    with pytest.raises(CalibrationError):
        row_time_us([0.1], [0.0])


def test_the_command_prints_settings_to_paste(tmp_path, capsys):
    """What it prints, given to ``--set``, is the camera that took the frames."""
    scene = SceneConfig(light_sd=0, turn_wall=False)
    write_pictures(tmp_path / "still-dim", still(NOISY, scene, 60, 0.3), ".png")
    write_pictures(tmp_path / "edge", crossing(ROLLING), ".pgm")
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


def grey(count: int = 20, read: float = 2.0, seed: int = 0, drift: float = 0.0, flicker: float = 0.0) -> np.ndarray:
    """Frames of a scene of many greys, made by hand, (T, 40, 60); light drifts by a share, or flickers with an sd."""
    rng = np.random.default_rng(seed)
    scene = np.linspace(40, 215, 40 * 60).reshape(40, 60)
    light = 1.0 + drift * np.arange(count) / max(count - 1, 1) + flicker * rng.normal(size=count)
    frames = light[:, None, None] * scene
    noise = rng.normal(size=frames.shape) * np.sqrt(read**2 + 16.0 * scene / 255)
    return np.clip(np.rint(frames + noise), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("share", [0.2, 0.8])
def test_pixels_that_clip_at_times_are_left_out(share):
    """However many do: what is clipped shows less noise, and the line would lean."""
    rng = np.random.default_rng(0)
    scene = np.tile(np.linspace(255 - 200 * (1 - share), 255 + 200 * share, 200), (40, 1))
    frames = np.clip(np.rint(scene + rng.normal(0, 3.0, (60, *scene.shape))), 0, 255).astype(np.uint8)
    line = photon_transfer([noise_levels(frames)])
    assert line.dark_sd == pytest.approx(3.0, rel=0.15)


def run_camera(folder, capsys, *options: str) -> tuple[dict[str, str], str, list[str]]:
    """The settings that ``colias camera`` prints, its table, and its notes."""
    assert main.command(["camera", str(folder), *options]) == 0
    out, err = capsys.readouterr()
    settings = dict(line.removeprefix("--set camera.").split("=") for line in out.splitlines() if "--set" in line)
    return settings, out, err.splitlines()


def test_pictures_come_in_the_order_of_their_numbers(tmp_path, capsys):
    """Of a program that writes 1.png to 12.png."""
    frames = grey(12)
    edge = crossing(ROLLING)
    for name in ("edge-padded", "edge-plain"):
        (tmp_path / name / "edge").mkdir(parents=True)
    for number, frame in enumerate([*edge[:1]] * 9 + [*edge], start=1):
        cv2.imwrite(str(tmp_path / "edge-padded" / "edge" / f"{number:03d}.png"), frame)
        cv2.imwrite(str(tmp_path / "edge-plain" / "edge" / f"{number}.PNG"), frame)
    settings = [run_camera(tmp_path / name, capsys, "--fps", "5")[0] for name in ("edge-padded", "edge-plain")]
    assert settings[0] == settings[1] and "row_time_us" in settings[0]
    cv2.imwrite(str(tmp_path / "edge-plain" / "edge" / "99.jpg"), frames[0])
    with pytest.raises(UsageError, match=r"99\.jpg: legal are pictures that keep every grey level: \.pgm, \.png"):
        run_camera(tmp_path / "edge-plain", capsys)


@pytest.mark.parametrize("kind", ["still", "flat"])
@pytest.mark.parametrize(("change", "told"), [({}, False), ({"drift": 0.1}, True), ({"flicker": 0.02}, True)], ids=str)
def test_greys_that_change_are_told_from_noise(kind, change, told, tmp_path, capsys):
    write_pictures(tmp_path / f"{kind}-1", grey(60, **change), ".png")
    _, table, notes = run_camera(tmp_path, capsys)
    assert ("change of" in table) is told
    assert len(notes) == told
    assert all(note.startswith(f"note: {tmp_path / kind}-1: its greys drift or flicker") for note in notes)


def test_unsteadiness_is_the_share_of_the_variance():
    """Light that rises by a share s of grey g over T frames adds (s g)^2 T (T + 1) / (12 (T - 1)^2) to the variance."""
    frames = grey(60, drift=0.1)
    scene = np.linspace(40, 215, 40 * 60)
    added = float(((0.1 * scene) ** 2).mean()) * 60 * 61 / (12 * 59**2)
    noise = 4.0 + 16.0 * float(scene.mean()) / 255 + 1 / 12
    assert unsteadiness(frames) == pytest.approx(added / (added + noise), rel=0.05)
    assert unsteadiness(grey(60)) == 0.0 and unsteadiness(np.full((9, 4, 4), 7, np.uint8)) == 0.0
    moved = grey(60)
    moved[30:, 10:20, 10:20] = 40  # an object that was put there
    assert unsteadiness(moved) > 0.1
    assert unsteadiness(still(NOISY, SceneConfig(light_sd=0), 20)) == 0.0


def pairs() -> list[tuple[int, ...]]:
    """One settling from below and one from above, and the two from far below with another."""
    two = [(low, high) for low in range(0, 14, 3) for high in range(14, 26, 3)]
    return two + [(0, 1, high) for high in range(14, 26)]


def test_few_settlings_exclude_no_truth_unflagged():
    """What is said to be certain holds the zone that the frames were taken with; two folders never are."""
    frames = settlings(LOOP)
    low, high = LOOP.ae_target - LOOP.ae_zone, LOOP.ae_target + LOOP.ae_zone
    certain = 0
    for chosen in (*pairs(), tuple(range(0, 26, 3)), tuple(range(26))):
        loop = exposure_loop([frames[i] for i in chosen])
        assert not loop.certain or len(chosen) > 2
        if loop.certain:
            certain += 1
            assert loop.step == pytest.approx(LOOP.ae_step, rel=0.02) and loop.steps == LOOP.ae_steps, chosen
            for interval, end in ((loop.low, low), (loop.high, high)):
                assert interval is not None and interval[0] <= end <= interval[1], chosen
    assert certain >= 2 and loop.certain


def test_the_command_says_what_is_not_certain_of_a_loop(tmp_path, capsys):
    frames = settlings(LOOP)
    for number in (0, 14):
        write_pictures(tmp_path / f"loop{number}", frames[number], ".pgm")
    settings, table, notes = run_camera(tmp_path, capsys)
    assert settings == {} and table.count("not certain") == 2
    assert len(notes) == 1 and "2 folders loop*" in notes[0] and "take more" in notes[0]


def test_one_frame_of_a_flat_sheet_is_refused(tmp_path):
    write_pictures(tmp_path / "flat", grey(1), ".png")
    with pytest.raises(UsageError, match="flat"):
        main.command(["camera", str(tmp_path)])
