"""Cost of each way of antialiasing, and its nearness to 16x16 samples a pixel, a third of a pixel a frame."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import ExitStack
from functools import partial

import mujoco
import numpy as np
import numpy.typing as npt
from rich.table import Table

from benchmarks.timing import interleaved, ratio
from colias_sim import CameraConfig, Pose, SceneConfig, Simulation
from dsnn import DSNN, DSNNParams

FRAMES = 45
STEP = 1 / 3  # px a frame, at 8 cm


def samples(multisample: int, supersample: int = 1, columns: int = 1) -> CameraConfig:
    """A camera without noise and with so many samples a pixel."""
    return CameraConfig(
        multisample=multisample, supersample=supersample, supersample_columns=columns,
        exposure_ms=0, shot_noise=0, read_noise=0,
    )  # fmt: skip


def simulation(camera: CameraConfig) -> Simulation:
    """A room in which nothing but the sampling of ``camera`` differs from another's."""
    return Simulation(camera=camera, scene=SceneConfig(light_sd=0, turn_wall=False))


def renders(sim: Simulation) -> Iterator[None]:
    """Expose the camera to each frame of a crossing: the stimulus is put a third of a pixel farther each time."""
    camera, rng = sim.camera("observer").config, np.random.default_rng(0)
    for i in range(FRAMES):
        place = Pose(camera.forward_cm / 100 + 0.08, 0.006 - i * STEP * 0.08 / camera.focal_px, -math.pi / 2)
        if i == 0:
            sim.reset({"stimulus": place}, rng)
        sim.robots["stimulus"].place(place)
        mujoco.mj_forward(sim.model, sim.data)
        sim.camera("observer").expose(sim.data)
        yield


def crossing(camera: CameraConfig) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Frames (T, R, C) without noise, and HS on them."""
    with simulation(camera) as sim:
        stack = np.stack([sim.camera("observer").develop(np.random.default_rng(0), 0.0).luma for _ in renders(sim)])
    return stack.astype(float), DSNN((72, 99), DSNNParams.robot()).run(stack).hs[20:]


def rendered(sim: Simulation) -> int:
    """Render a crossing, and return the number of frames."""
    for _ in renders(sim):
        sim.camera("observer").skip()
    return FRAMES


COMPARED = {
    "1 in 1x1": samples(0),
    "* 4 in 1x1": samples(4),
    "1 in 2x2": samples(0, 2),
    "1 in 3x3": samples(0, 3),
    "4 in 2x2": samples(4, 2),
    "1 in 4x4": samples(0, 4),
    "4 in 4x4": samples(4, 4),
    "4 in 2x1": samples(4, columns=2),
    "4 in 3x1": samples(4, columns=3),
}
DEFAULT = "* 4 in 1x1"
TRUTH = samples(0, 16)


def table() -> Table:
    """Error of a frame's change against its true change, HS's error, and the cost, side by side."""
    truth, hs_truth = crossing(TRUTH)
    change = np.diff(truth, axis=0)
    moving = np.abs(change).max(0) > 10
    with ExitStack() as open_ones:
        sims = {name: open_ones.enter_context(simulation(camera)) for name, camera in COMPARED.items()}
        times = interleaved({name: partial(rendered, sim) for name, sim in sims.items()}, rounds=9)
    result = Table(
        title=f"Antialiasing against 16x16 samples a pixel, a third of a pixel a frame (true HS {hs_truth.mean():.4f})"
    )
    for name in ("samples", "error of change", "HS", "rms error of HS", "render us", "times the default"):
        result.add_column(name, justify="left" if name == "samples" else "right")
    for name, camera in COMPARED.items():
        frames, hs = crossing(camera)
        error = (np.diff(frames, axis=0) - change)[:, moving].std() / change[:, moving].std()
        rms = float(np.sqrt(((hs - hs_truth) ** 2).mean()))
        cost = f"{times[name].min():.0f}", f"{ratio(times[name], times[DEFAULT]):.2f}"
        result.add_row(name, f"{error:.0%}", f"{hs.mean():.4f}", f"{rms:.4f}", *cost)
    return result
