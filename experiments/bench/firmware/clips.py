"""The frames that the chip's program is measured and checked with: synthetic ones, golden clips, a trial's own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

import dsnn
from dsnn.onboard.model import OnboardDSNN
from experiments.bench.firmware.settings import Firmware
from experiments.bench.run.streams import stream

Frames = npt.NDArray[np.uint8]
"""(T, R, C)."""

GOLDEN = Path(dsnn.__file__).parents[1] / "tests" / "golden"
"""Frames that came with the network's specification: in a checkout, not in an installed package."""


def synthetic(shape: tuple[int, int], length: int) -> Mapping[str, Frames]:
    """Clips that drive the network from no work at all to all that it may have.

    Parameters
    ----------
    shape
        (R, C) of the frames.
    length
        Frames of each clip.

    Returns
    -------
    mapping of str to ndarray
        Name -> (T, R, C) uint8. ``still``: nothing changes. ``noise``: every pixel is drawn anew. ``pixel flicker``:
        every pixel is 0 or 255, drawn anew. ``field flicker`` and ``board flicker``: all pixels, or the two halves of
        a chequerboard, change from 0 to 255 at every frame. ``grating``: black and white bars of 4 px, moving by 2 px
        a frame. ``crossing``: a dark square passes on noise of 8 grey levels.
    """
    rows, columns = shape
    draw = stream("firmware.clips", 0)
    times = np.arange(length)[:, None, None]
    y, x = np.mgrid[:rows, :columns]
    black_white = np.uint8(255)
    crossing = draw.integers(180, 188, (length, rows, columns), dtype=np.uint8)
    side = max(rows // 3, 2)
    for time in range(length):
        left = (2 * time) % columns
        crossing[time, side : 2 * side, left : left + side] = 20
    return {
        "still": np.full((length, rows, columns), 128, np.uint8),
        "noise": draw.integers(0, 256, (length, rows, columns), dtype=np.uint8),
        "pixel flicker": draw.integers(0, 2, (length, rows, columns), dtype=np.uint8) * black_white,
        "field flicker": np.broadcast_to((times % 2).astype(np.uint8), (length, rows, columns)) * black_white,
        "board flicker": ((times + x + y) % 2).astype(np.uint8) * black_white,
        "grating": (((x + 0 * y - 2 * times) // 4) % 2).astype(np.uint8) * black_white,
        "crossing": crossing,
    }


def golden(shape: tuple[int, int]) -> Mapping[str, Frames]:
    """Return the golden clips, resized to ``shape`` where they have another; empty where there is no checkout."""
    by_name: dict[str, Frames] = {}
    for path in sorted(GOLDEN.glob("*.npz")):
        with np.load(path) as held:
            frames = held["frames"]
        if frames.shape[1:] != shape:
            size = shape[1], shape[0]
            frames = np.stack([cv2.resize(frame, size, interpolation=cv2.INTER_AREA) for frame in frames])
        by_name[f"golden {path.stem}"] = frames.astype(np.uint8, copy=False)
    return by_name


COUNTED_FRAMES = 16
"""Frames of each clip that the budget counts, and that the self-measuring program shows.

The slowest state of the network's work, the adaptation, is at its level after 10 frames.
"""
GOLDEN_SHOWN, SHOWN = 2, 3


def worst(wanted: Firmware) -> Mapping[str, Frames]:
    """Choose the clips that the self-measuring program shows, each from its first frame, (`COUNTED_FRAMES`, R, C).

    They are the two golden clips and the synthetic one that have the frame with the most cells in which F is not 0:
    such cells are the network's work. Without golden clips all three are synthetic.
    """
    recorded, drawn = golden(wanted.shape), synthetic(wanted.shape, COUNTED_FRAMES)
    chosen: dict[str, Frames] = {}
    for clips, count in ((recorded, GOLDEN_SHOWN), (drawn, SHOWN)):
        work = {name: _moving_cells(wanted, frames[:COUNTED_FRAMES]) for name, frames in clips.items()}
        for name in sorted(work, key=lambda clip: -work[clip])[: count - len(chosen)]:
            chosen[name] = clips[name][:COUNTED_FRAMES]
    return chosen


def _moving_cells(wanted: Firmware, frames: Frames) -> int:
    """Cells of both pathways in which F is not 0, in the frame that has the most of them."""
    model = OnboardDSNN(wanted.shape, wanted.network)
    most = 0
    for frame in frames:
        maps = model.step(frame, maps=True).maps
        assert maps is not None
        most = max(most, int(np.count_nonzero(maps.f_on)) + int(np.count_nonzero(maps.f_off)))
    return most


def of_trial(shape: tuple[int, int]) -> Frames:
    """Return the frames that the robot's camera gives in the first trial of ``speed``, rendered by MuJoCo at ``shape``.

    Raises `colias_sim.GLUnavailable` where nothing can be rendered.
    """
    from experiments.bench import registry
    from experiments.bench.sources.robot import RobotSource
    from experiments.bench.trials import plan

    rows, columns = shape
    sized = [f"camera.width={columns}", f"camera.height={rows}"]
    trials = plan(registry.load("speed"), ["dsnn"], sized, 1, 0)
    trial = trials.specs()[0]
    return np.stack([sample.image for sample in RobotSource(trial, trial.settings.camera)])
