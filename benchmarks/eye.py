"""What the eye ``ov7670`` costs, and how far its few renders are from a dense reference, in HS and in spikes."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from rich.table import Table

from benchmarks.timing import interleaved
from colias_sim import CameraConfig, PathFollower, Pose, Simulation
from colias_sim.path import Line
from dsnn import DSNN, DSNNParams

FRAMES = 60
SPEEDS = (0.04, 0.06, 0.10)
"""Of the crossings by which the approximation is judged, in m/s at 8 cm."""

EYE = CameraConfig.preset("ov7670")
DENSE = dataclasses.replace(EYE, row_bands=EYE.height, exposure_samples=8)
"""One render a row, and eight an exposure."""


def variants() -> dict[str, CameraConfig]:
    """The cameras compared: name -> settings."""
    made = {"default": CameraConfig(), "* ov7670": EYE}
    for bands, samples in ((4, 1), (6, 1), (8, 1), (12, 1), (6, 2), (8, 2), (18, 1), (12, 3)):
        name = f"  {bands} bands, {samples} samples"
        made[name] = dataclasses.replace(EYE, row_bands=bands, exposure_samples=samples)
    made["  global shutter"] = dataclasses.replace(EYE, row_time_us=0.0)
    return made


def table() -> Table:
    """Camera time as a ratio to the default's, side by side; errors against a render a row, without noise."""
    cameras = variants()
    sims = {name: Simulation(camera=camera) for name, camera in cameras.items()}
    blind = Simulation(seeing=False)
    work: dict[str, Callable[[], int]] = {name: _crossing(sim) for name, sim in sims.items()}
    times = interleaved({"physics": _blind_crossing(blind), **work}, rounds=9)
    for sim in (*sims.values(), blind):
        sim.close()
    physics = times.taken["physics"]
    result = Table(title=f"The eye ov7670 against {DENSE.row_bands} bands of {DENSE.exposure_samples} samples: "
                   "crossings at 4, 6, 10 cm/s, 8 cm away, without noise")  # fmt: skip
    for name in ("camera", "us a frame", "times the default", "rms error of grey", "rms error of HS", "mean HS", "spikes"):
        result.add_column(name, justify="left" if name == "camera" else "right")
    truth = [_answers(DENSE, speed) for speed in SPEEDS]
    for name, camera in cameras.items():
        own = times.taken[name] - physics
        ratio = float(np.median(own / (times.taken["default"] - physics)))
        seen = [_answers(camera, speed) for speed in SPEEDS]
        result.add_row(name, f"{own.min():.0f}", f"{ratio:.2f}", *_errors(seen, truth))
    result.add_row("  dense", "", "", *_errors(truth, truth))
    return result


Answers = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64], int]


def _errors(seen: list[Answers], truth: list[Answers]) -> tuple[str, ...]:
    grey = math.sqrt(np.mean([np.mean((a[0] - b[0]) ** 2) for a, b in zip(seen, truth, strict=True)]))
    hs = math.sqrt(np.mean([np.mean((a[1] - b[1]) ** 2) for a, b in zip(seen, truth, strict=True)]))
    mean = np.mean([np.mean(a[1]) for a in seen])
    return f"{grey:.2f}", f"{hs:.4f}", f"{mean:.4f}", ", ".join(str(a[2]) for a in seen)


def _crossing(sim: Simulation, speed: float = 0.06) -> Callable[[], int]:
    """A crossing as a function that can be timed; it returns its number of frames."""
    return lambda: len(_frames(sim, speed, FRAMES))


def _frames(sim: Simulation, speed: float, count: int) -> list[npt.NDArray[np.uint8]]:
    rng = np.random.default_rng(0)
    robot, follower = _start(sim, speed, rng)
    return [sim.step(rng, lambda dt: robot.drive(follower.wheels(dt))).luma for _ in range(count)]


def _blind_crossing(sim: Simulation) -> Callable[[], int]:
    def run() -> int:
        robot, follower = _start(sim, 0.06, np.random.default_rng(0))
        for _ in range(FRAMES):
            sim.advance(lambda dt: robot.drive(follower.wheels(dt)))
        return FRAMES

    return run


def _start(sim: Simulation, speed: float, rng: np.random.Generator):  # type: ignore[no-untyped-def]
    robot, line = sim.robots["stimulus"], Line(Pose(0.1, 0.08, -math.pi / 2), 0.25)
    sim.reset({"stimulus": line.start}, rng)
    return robot, PathFollower(robot, line, speed)


def _answers(camera: CameraConfig, speed: float) -> Answers:
    """Frames of a crossing without noise, HS on them, and the number of spikes."""
    with Simulation(camera=dataclasses.replace(camera, shot_noise=0.0, read_noise=0.0)) as sim:
        frames = np.stack(_frames(sim, speed, round(0.15 / speed * camera.fps)))
    answer = DSNN(frames.shape[1:], DSNNParams.robot()).run(frames)
    return frames.astype(float), answer.hs, int(np.abs(answer.hs_spikes).sum())
