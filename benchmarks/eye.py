"""Cost of the eye ``ov7670``, and distance of its few renders from a dense reference, in HS and in spikes."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from rich.table import Table

from benchmarks.timing import interleaved, ratio
from colias_sim import CameraConfig, Frame, PathFollower, Pose, Robot, Route, Simulation
from colias_sim.exposure import exposure_samples
from colias_sim.scene import steps_per_frame
from dsnn import DSNN, DSNNParams

FRAMES = 60
SPEEDS = (0.04, 0.06, 0.10)
"""Speeds of the crossings by which the approximation is judged, in m/s at 8 cm."""

EYE = CameraConfig.preset("ov7670")
DENSE_SAMPLES = 8


def fixed(camera: CameraConfig, exposure_ms: float, samples: int = 0) -> CameraConfig:
    """The camera without noise and with the exposure at which its loop rests, fixed, and so many ``samples`` of it.

    With 0 it has as many as under the loop.
    """
    if not camera.auto_exposure:
        return dataclasses.replace(camera, shot_noise=0.0, read_noise=0.0)
    steps = steps_per_frame(camera.fps)
    return dataclasses.replace(
        camera, auto_exposure=False, gain=camera.gain * exposure_ms / camera.ae_unit_ms, exposure_ms=exposure_ms,
        exposure_samples=samples or exposure_samples(camera, exposure_ms, steps), shot_noise=0.0, read_noise=0.0,
    )  # fmt: skip


def variants() -> dict[str, CameraConfig]:
    """The cameras compared: name -> settings."""
    configs = {"default": CameraConfig(), "* ov7670": EYE}
    for bands in (3, 4, 8, 12):
        configs[f"  {bands} bands"] = dataclasses.replace(EYE, row_bands=bands)
    configs["  (global shutter)"] = dataclasses.replace(EYE, row_time_us=0.0)
    return configs


def table() -> Table:
    """Camera time as a ratio to the default's, side by side; errors against a render a row, without noise."""
    cameras = variants()
    sims = {name: Simulation(camera=camera) for name, camera in cameras.items()}
    blind = Simulation(seeing=False)
    work: dict[str, Callable[[], int]] = {name: _crossing(sim) for name, sim in sims.items()}
    times = interleaved({"physics": _blind_crossing(blind), **work}, rounds=9)
    for sim in (*sims.values(), blind):
        sim.close()
    physics = times["physics"]
    title = "The eye ov7670; crossings at 4, 6, 10 cm/s, 8 cm away; dense: a render a row, 8 an exposure"
    result = Table(title=title)
    for name in ("camera", "us a frame", "times the default", "rms of grey", "rms of HS", "mean HS", "spikes"):
        result.add_column(name, justify="left" if name == "camera" else "right")
    rests = _rest()
    dense = fixed(dataclasses.replace(EYE, row_bands=EYE.height), rests, DENSE_SAMPLES)
    truth = [_answers(dense, speed) for speed in SPEEDS]
    for name, camera in cameras.items():
        rendering = times[name] - physics
        seen = [_answers(fixed(camera, rests), speed) for speed in SPEEDS]
        cost = f"{rendering.min():.0f}", f"{ratio(rendering, times['default'] - physics):.2f}"
        result.add_row(name, *cost, *_errors(seen, truth))
    result.add_row("  dense", "", "", *_errors(truth, truth))
    return result


Answers = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], int]


def _errors(seen: list[Answers], truth: list[Answers]) -> tuple[str, ...]:
    grey = math.sqrt(np.mean([np.mean((a[0] - b[0]) ** 2) for a, b in zip(seen, truth, strict=True)]))
    hs = math.sqrt(np.mean([np.mean((a[1] - b[1]) ** 2) for a, b in zip(seen, truth, strict=True)]))
    mean = np.mean([np.mean(a[1]) for a in seen])
    return f"{grey:.2f}", f"{hs:.4f}", f"{mean:.4f}", ", ".join(str(a[2]) for a in seen)


def _rest() -> float:
    """The exposure time at which the loop rests on the bright arena, in ms."""
    with Simulation(camera=EYE) as sim:
        return _frames(sim, 0.06, 1)[0].exposure_ms


def _crossing(sim: Simulation, speed: float = 0.06) -> Callable[[], int]:
    """A crossing as a function that can be timed; it returns its number of frames."""
    return lambda: len(_frames(sim, speed, FRAMES))


def _frames(sim: Simulation, speed: float, count: int) -> list[Frame]:
    rng = np.random.default_rng(0)
    robot, follower = _start(sim, speed, rng)
    return [sim.step(rng, lambda dt: robot.drive(follower.wheels(dt))) for _ in range(count)]


def _blind_crossing(sim: Simulation) -> Callable[[], int]:
    def run() -> int:
        robot, follower = _start(sim, 0.06, np.random.default_rng(0))
        for _ in range(FRAMES):
            sim.advance(lambda dt: robot.drive(follower.wheels(dt)))
        return FRAMES

    return run


def _start(sim: Simulation, speed: float, rng: np.random.Generator) -> tuple[Robot, PathFollower]:
    robot, line = sim.robots["stimulus"], Route.line(Pose(0.1, 0.08, -math.pi / 2), 0.25, speed)
    sim.reset({"stimulus": line.start}, rng)
    return robot, PathFollower(robot, line)


def _answers(camera: CameraConfig, speed: float) -> Answers:
    """Frames of a crossing, HS on them, and the number of spikes."""
    with Simulation(camera=camera) as sim:
        frames = np.stack([frame.luma for frame in _frames(sim, speed, round(0.15 / speed * camera.fps))])
    answer = DSNN(frames.shape[1:], DSNNParams.robot()).run(frames)
    return frames.astype(float), answer.hs, int(np.abs(answer.hs_spikes).sum())
