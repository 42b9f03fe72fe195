"""Plan a camera's renders: the moments of an exposure, row by row, and the loop that controls the exposure time.

Nothing here renders. A frame is planned one frame ahead, because its first rows may be exposed before the previous
frame has ended. So the exposure loop's response to frame n takes effect in frame n + 2.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from colias_sim.config import CameraConfig

LAG_SDS = 3.0
"""With clock jitter exposures end this many sd before the frame's end on average, and never after it."""
_MOST_TURNS = 200
"""Most renders until a loop has settled: each except the last moves by at least a step, from one limit to the other."""


@dataclass(frozen=True, slots=True)
class Render:
    """One render of an exposure.

    Parameters
    ----------
    step
        The physics step after which it is due, from the start of its frame; 0 and less are in the previous frame.
    parts
        Number of equal parts of the exposure that it stands for.
    top, bottom
        The rows of the picture: from ``top``, 0 at the upper edge, to before ``bottom``. A ``bottom`` of 0 means the
        whole picture.
    ahead
        Whether it belongs to the frame after the current one.
    """

    step: int
    parts: int = 1
    top: int = 0
    bottom: int = 0
    ahead: bool = False


WHOLE = Render(0)
"""One render of the whole picture, which is all of the exposure."""


def plan_frame(
    config: CameraConfig, steps_per_frame: int, exposure_ms: float, early_steps: int = 0
) -> tuple[Render, ...]:
    """Plan a frame's renders.

    Row r of R is exposed for ``exposure_ms``, up to ``(R - 1 - r) row_time_us`` before the last row's end. A band of
    rows shares the moments of its middle. Moments are rounded to whole physics steps.

    Parameters
    ----------
    config
        The camera's settings.
    steps_per_frame
        Number of physics steps in a frame.
    exposure_ms
        Exposure time.
    early_steps
        Physics steps from the end of the last row's exposure to the end of the frame.

    Returns
    -------
    tuple of Render
        The renders, in the order of their steps.
    """
    renders = []
    for top, bottom in row_bands(config):
        rows_after = config.height - 1 - (top + bottom - 1) / 2 if bottom else 0.0
        before = rows_after * config.row_time_us * 1e-6 * config.fps * steps_per_frame
        earliest = 1 - steps_per_frame if bottom else 1  # a whole picture's exposure is cut to its frame
        moments = _moments(config, steps_per_frame, exposure_ms, early_steps + before, earliest)
        renders += [Render(step, parts, top, bottom) for step, parts in Counter(moments).items()]
    return tuple(sorted(renders, key=lambda render: (render.step, render.top)))


def light_factor(config: CameraConfig, exposure_ms: float) -> float:
    """Compute the factor on the lamps' strength: gain, and exposure time if a loop controls it."""
    return config.gain * (exposure_ms / config.ae_unit_ms if config.auto_exposure else 1.0)


def row_bands(config: CameraConfig) -> list[tuple[int, int]]:
    """Divide the rows into bands of nearly equal height: (first row, the row after the last) of each.

    A camera with a global shutter has one band, (0, 0): the whole picture.
    """
    if config.row_time_us == 0.0:
        return [(0, 0)]
    edges = [round(band * config.height / config.row_bands) for band in range(config.row_bands + 1)]
    return list(pairwise(edges))


def exposure_samples(config: CameraConfig, exposure_ms: float, steps_per_frame: int) -> int:
    """Count the renders that stand for an exposure: ``exposure_samples``.

    With an exposure loop this is the maximum: no part of an exposure is shorter than two physics steps.
    """
    if not config.auto_exposure:
        return config.exposure_samples
    steps = exposure_ms * config.fps * steps_per_frame / 1000.0
    return max(1, min(config.exposure_samples, int(steps / 2)))


def _moments(config: CameraConfig, steps: int, exposure_ms: float, before: float, earliest: int) -> tuple[int, ...]:
    """Return the middles of the parts of an exposure that ends ``before`` steps before the frame."""
    length = exposure_ms * config.fps / 1000.0
    length = (min(length, 1.0) if earliest == 1 else length) * steps
    samples = exposure_samples(config, exposure_ms, steps)
    parts = (np.arange(samples) + 0.5) / samples
    moments = np.rint(steps - before - length * (1.0 - parts)).astype(int)
    return tuple(int(m) for m in np.clip(moments, earliest, steps))


def next_exposure(config: CameraConfig, exposure_ms: float, mean: float, taken_ms: float) -> float:
    """Control the exposure time by up to ``ae_steps`` steps towards the control zone, as documented for the OV9650.

    A step is ``ae_step`` of the present exposure. Steps are made while the picture's mean, scaled to the exposure
    reached, is outside ``ae_target`` -+ ``ae_zone``.

    Parameters
    ----------
    config
        The camera's settings.
    exposure_ms
        The present exposure time.
    mean
        Mean grey of the last picture.
    taken_ms
        The exposure time of the last picture.

    Returns
    -------
    float
        The exposure time to set; ``exposure_ms`` in the zone.
    """
    for _ in range(config.ae_steps):
        level = mean * exposure_ms / taken_ms
        if abs(level - config.ae_target) <= config.ae_zone:
            break
        factor = 1.0 + config.ae_step if level < config.ae_target else 1.0 - config.ae_step
        exposure_ms = min(max(exposure_ms * factor, config.ae_min_ms), config.ae_max_ms)
    return exposure_ms


def settle(config: CameraConfig, mean: Callable[[float], float]) -> float:
    """Run the loop on a still scene until it rests, from ``exposure_ms``.

    Parameters
    ----------
    config
        The camera's settings.
    mean
        Gives the mean grey of a picture at an exposure time in ms.

    Returns
    -------
    float
        The exposure time at which the loop rests, in ms. It is one of its limits if the scene is too bright or dark.
    """
    exposure_ms = config.exposure_ms
    for _ in range(_MOST_TURNS):
        before, exposure_ms = exposure_ms, next_exposure(config, exposure_ms, mean(exposure_ms), exposure_ms)
        if exposure_ms == before:
            break
    return exposure_ms
