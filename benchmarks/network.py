"""The DSNN's step against its reference, its rivals and optical flow, on the same frames in the same run."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise

import cv2
import numpy as np
import numpy.typing as npt
from rich.table import Table

from benchmarks.timing import interleaved, ratio
from dsnn import DSNN, MODELS, OnboardDSNN, OnboardParams, ReferenceDSNN
from dsnn.model import VisionModel
from experiments.show.video import mean_flow

Luma = npt.NDArray[np.uint8]
FRAMES = 24


def clip(shape: tuple[int, int]) -> Luma:
    """A dark object over a textured, shifting background with camera noise: what a step costs depends little on it."""
    rng = np.random.default_rng(0)
    rows, columns = shape
    ground = cv2.GaussianBlur(rng.integers(0, 256, (rows, columns + FRAMES)).astype(np.float32), (0, 0), 3)
    ground = cv2.normalize(ground, ground, 120, 250, cv2.NORM_MINMAX)
    frames = []
    for i in range(FRAMES):
        frame = ground[:, i : i + columns].copy()
        frame[rows // 3 : rows * 2 // 3, 2 * i : 2 * i + columns // 4] = 10
        frames.append(np.clip(frame + rng.normal(0, 1, shape), 0, 255).astype(np.uint8))
    return np.stack(frames)


def stepped(model: VisionModel, frames: Luma) -> int:
    """Show a model the frames, and return their number."""
    return len([model.step(frame) for frame in frames])


def flowing(flow: Callable[[Luma, Luma], object], pairs: Sequence[tuple[Luma, Luma]]) -> int:
    """Compute the optical flow of each pair of frames, and return their number."""
    return len([flow(before, now) for before, now in pairs])


COLD_MB = 4


def table() -> Table:
    """Microseconds per frame and ratios to the DSNN, one thread, n_con = 8.

    "Cold" is a step after `COLD_MB` of other memory were written, as in the loop: the state is no longer in the cache.
    """
    title = "Network step, us a frame (times the DSNN), one thread, n_con 8; goals: cold 1.6, Farneback 15, DIS 1.0"
    result = Table(title=title)
    for name in ("frame", "DSNN", "cold", "reference", "Farneback", "DIS ultrafast"):
        result.add_column(name, justify="right")
    dis = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST)
    for shape in ((72, 99), (180, 320)):
        frames = clip(shape)
        fast, plain = DSNN(shape), ReferenceDSNN(shape)
        pairs = list(pairwise(frames[:9]))
        times = interleaved(
            {
                "dsnn": partial(stepped, fast, frames),
                "plain": partial(stepped, plain, frames[:12]),
                "farneback": partial(flowing, mean_flow, pairs),
                "dis": partial(
                    flowing, lambda before, now: dis.calc(before, now, np.zeros((*now.shape, 2), np.float32)), pairs
                ),
            }
        )
        cold = min(_cold(fast, frames) for _ in range(9))
        others = ("plain", "farneback", "dis")
        cells = [f"{times[name].min():.0f} ({ratio(times[name], times['dsnn']):.1f})" for name in others]
        hot = times["dsnn"].min()
        result.add_row(f"{shape[1]}x{shape[0]}", f"{hot:.0f}", f"{cold:.0f} ({cold / hot:.1f})", *cells)
    result.caption = f"form of the DSNN: {fast.form}"
    return result


def _cold(model: DSNN, frames: Luma) -> float:
    """Mean microseconds of a step that finds other memory in the cache."""
    other, spent = np.zeros(COLD_MB << 18, np.float32), 0.0
    for frame in frames:
        other += 1.0
        began = time.perf_counter()
        model.step(frame)
        spent += time.perf_counter() - began
    return spent / len(frames) * 1e6


def rivals() -> Table:
    """Each registered model on the robot's frames, with its parameters for the robot."""
    frames = clip((72, 99))
    models = {name: entry.build((72, 99), entry.robot) for name, entry in MODELS.items()}
    models["dsnn-onboard in NumPy"] = OnboardDSNN((72, 99), OnboardParams.robot(), form="reference")
    times = interleaved({name: partial(stepped, model, frames) for name, model in models.items()})
    result = Table(title="Each registered model against the DSNN at 99x72, one thread")
    for name in ("model", "us a frame", "times the DSNN"):
        result.add_column(name, justify="left" if name == "model" else "right")
    for name in models:
        result.add_row(name, f"{times[name].min():.0f}", f"{ratio(times[name], times['dsnn']):.2f}")
    return result
