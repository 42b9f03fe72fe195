"""What each way of antialiasing costs and how near it comes to 16x16 samples a pixel, a third of a pixel a frame."""

from __future__ import annotations

import math
import time

import numpy as np
from rich.table import Table

from colias_sim import CameraConfig, Pose, SceneConfig, Simulation
from dsnn import DSNN, DSNNParams

FRAMES = 45
STEP = 1 / 3  # px a frame, at 8 cm


def crossing(multisample: int, supersample: int, columns: int = 1) -> tuple[np.ndarray, np.ndarray, float]:
    """Frames (T, R, C) without noise, HS on them, and microseconds a render."""
    camera = CameraConfig(
        multisample=multisample, supersample=supersample, supersample_columns=columns, exposure_ms=0, shot_noise=0,
        read_noise=0,
    )  # fmt: skip
    frames, spent = [], []
    with Simulation(camera=camera, scene=SceneConfig(light_sd=0, turn_wall=False)) as sim:
        for i in range(FRAMES):
            place = Pose(camera.forward_cm / 100 + 0.08, 0.006 - i * STEP * 0.08 / camera.focal_px, -math.pi / 2)
            sim.reset({"stimulus": place}, np.random.default_rng(0))
            began = time.perf_counter()
            sim.camera.expose(sim.data)
            spent.append(time.perf_counter() - began)
            frames.append(sim.camera.develop(np.random.default_rng(0), 0.0).luma)
    stack = np.stack(frames)
    return stack.astype(float), DSNN((72, 99), DSNNParams.robot()).run(stack).hs[20:], float(np.median(spent)) * 1e6


def table() -> Table:
    """Error of a frame's change against its true change, HS's error, and the cost."""
    truth, hs_truth, _ = crossing(0, 16)
    change = np.diff(truth, axis=0)
    moving = np.abs(change).max(0) > 10
    result = Table(
        title=f"Antialiasing against 16x16 samples a pixel, a third of a pixel a frame (true HS {hs_truth.mean():.4f})"
    )
    for name in ("samples", "error of change", "HS", "rms error of HS", "render us"):
        result.add_column(name, justify="right")
    plain = [
        (multisample, supersample, 1)
        for multisample, supersample in ((0, 1), (4, 1), (0, 2), (0, 3), (4, 2), (0, 4), (4, 4))
    ]
    for multisample, supersample, columns in (*plain, (4, 1, 2), (4, 1, 3)):
        frames, hs, us = crossing(multisample, supersample, columns)
        error = (np.diff(frames, axis=0) - change)[:, moving].std() / change[:, moving].std()
        default = "* " if (multisample, supersample, columns) == (4, 1, 1) else ""
        name = f"{default}{max(multisample, 1)} in {columns * supersample}x{supersample}"
        rms = float(np.sqrt(((hs - hs_truth) ** 2).mean()))
        result.add_row(name, f"{error:.0%}", f"{hs.mean():.4f}", f"{rms:.4f}", f"{us:.0f}")
    return result
