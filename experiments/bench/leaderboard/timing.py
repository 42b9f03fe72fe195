"""Time that a model takes for a frame, all models side by side: in one process, on one thread, in turns."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Sequence

import cv2
import numpy as np
import numpy.typing as npt
from threadpoolctl import threadpool_limits

from dsnn import VisionModel
from dsnn.frames import frozen
from dsnn.stimuli import stimulus
from experiments.bench.run.models import ConfiguredModel

ROUNDS = 40
BLOCK = 4
"""Frames that a model takes in one turn."""


def time_models(models: Sequence[ConfiguredModel], shape: tuple[int, int]) -> dict[str, list[float]]:
    """Microseconds per frame of (R, C) by label, one mean of `BLOCK` frames for each round.

    A slow moment of the machine hits all of a round. The first round warms up and does not count. A model that
    cannot be built for such frames, or that raises, is left out.
    """
    rows, columns = shape
    clip = stimulus("cluttered", 0, rows=rows, columns=columns, width=columns / 6, height=rows / 2, speed=columns / 2)
    frames = [frozen(clip[index].luma) for index in range(min(len(clip), 60))]
    cv2.setNumThreads(1)
    running = _built(models, shape)
    taken: dict[str, list[float]] = {label: [] for label in running}
    with threadpool_limits(1):
        for number in range(ROUNDS + 1):
            block = [frames[(number * BLOCK + i) % len(frames)] for i in range(BLOCK)]
            for label, model in list(running.items()):
                try:
                    seconds = _time(model, [frozen(frame) for frame in block])
                except Exception:  # its trials tell why
                    del running[label]
                    continue
                if number:
                    taken[label].append(seconds / BLOCK * 1e6)
    return {label: taken[label] for label in running}


def _time(model: VisionModel, block: Sequence[npt.NDArray[np.uint8]]) -> float:
    began = time.perf_counter()
    for frame in block:
        model.step(frame)
    return time.perf_counter() - began


def _built(models: Sequence[ConfiguredModel], shape: tuple[int, int]) -> dict[str, VisionModel]:
    built: dict[str, VisionModel] = {}
    for model in models:
        with contextlib.suppress(Exception):
            built[model.label] = model.build(shape)
    return built
