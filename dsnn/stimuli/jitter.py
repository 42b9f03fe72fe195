"""A trembling camera: any other stimulus, shifted by a fraction of a pixel in every frame."""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.stimuli.stimulus import ClipParams, Stimulus, StimulusFrame, Truth, Velocity
from dsnn.stimuli.streams import stream

LARGEST_SD_PX = 10.0
LIMIT_SD = 4.0
"""Shifts are clipped at this many standard deviations."""


class Jitter(Stimulus[ClipParams]):
    """A clip seen by a trembling camera, with an independent Gaussian shift along x and y in every frame.

    The border's pixels are replicated outside the frame. The truth moves along: boxes by the shift, velocities by its
    change since the frame before.

    Parameters
    ----------
    inner
        The clip.
    sd_px
        Standard deviation of the shifts, from 0 to 10 px. Shifts beyond 4 standard deviations are clipped.
    seed
        Seed of the shifts. It is independent of the clip's seed, even if both are equal.

    Raises
    ------
    ValueError
        ``sd_px`` is outside 0 to 10, or the seed is below 0.

    Examples
    --------
    >>> from dsnn.stimuli import Jitter, stimulus
    >>> clip = Jitter(stimulus("plain"), sd_px=0.5, seed=1)
    >>> clip[0].luma.shape
    (180, 320)
    """

    def __init__(self, inner: Stimulus[ClipParams], sd_px: float = 0.3, seed: int = 0) -> None:
        super().__init__(inner.params, seed)
        if not 0.0 <= sd_px <= LARGEST_SD_PX:
            raise ValueError(f"sd_px must be between 0 and {LARGEST_SD_PX:g}, got {sd_px:g}")
        self.inner = inner
        drawn = stream("jitter", seed).standard_normal((len(inner), 2))
        self.shifts = sd_px * np.clip(drawn, -LIMIT_SD, LIMIT_SD)
        """(frames, 2): along x and y, px."""

    def __len__(self) -> int:
        return len(self.inner)

    def frame(self, index: int) -> StimulusFrame:
        """Paint a frame.

        Parameters
        ----------
        index
            From 0 to ``len(clip) - 1``.

        Returns
        -------
        StimulusFrame
            The frame and its truth.
        """
        still = self.inner.frame(index)
        x, y = self.shifts[index].tolist()
        before_x, before_y = self.shifts[max(index - 1, 0)].tolist()
        change = (x - before_x) * self.fps, (y - before_y) * self.fps
        luma = cv2.sepFilter2D(still.luma, -1, _shift(x), _shift(y), borderType=cv2.BORDER_REPLICATE)
        return StimulusFrame(np.asarray(luma, np.uint8), _moved(still.truth, x, y, change))


def _moved(truth: Truth, x: float, y: float, change: Velocity) -> Truth:
    return replace(
        truth,
        box=truth.box and truth.box.shifted(x, y),
        velocity=truth.velocity and _sum(truth.velocity, change),
        background_velocity=_sum(truth.background_velocity, change),
    )


def _sum(a: Velocity, b: Velocity) -> Velocity:
    return a[0] + b[0], a[1] + b[1]


def _shift(distance: float) -> npt.NDArray[np.float64]:
    """Make the kernel that moves an image ``distance`` px along an axis: cubic convolution (Keys 1981)."""
    radius = math.ceil(abs(distance)) + 2
    away = np.abs(np.arange(-radius, radius + 1) + distance)
    near = 1.5 * away**3 - 2.5 * away**2 + 1.0
    far = -0.5 * away**3 + 2.5 * away**2 - 4.0 * away + 2.0
    return np.where(away <= 1.0, near, np.where(away < 2.0, far, 0.0))
