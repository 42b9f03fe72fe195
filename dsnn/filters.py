"""Building blocks of the models: the retina, first-order low-passes, Gaussian blurs, exact sums, decaying states."""

from __future__ import annotations

import math
from typing import Any, TypeVar, cast

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.exponential import exp

Floats = npt.NDArray[np.float32]


class Retina:
    """Compute the change of luminance (`high-pass`), the first layer of every model here except the DSNN."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self._before: npt.NDArray[Any] = np.zeros(shape, np.uint8)
        self._change: Floats = np.zeros(shape, np.float32)
        self._first = True

    def reset(self) -> None:
        """Forget every frame."""
        self._first = True

    def step(self, luminance: npt.NDArray[Any]) -> Floats:
        """Return P of this frame, 0 on the first. The buffer is valid until the next step."""
        before = luminance if self._first else self._before
        cv2.subtract(luminance, before, self._change, None, cv2.CV_32F)
        if luminance.dtype == self._before.dtype:
            np.copyto(self._before, luminance)
        else:
            self._before = luminance.copy()
        self._first = False
        return self._change


def alpha(tau: float, dt: float, *, exact: bool = False) -> float:
    """Compute the gain of a first-order low-pass ``y += alpha (x - y)``, with ``tau`` and frame interval ``dt`` in ms.

    The default is backward Euler; ``exact`` solves for an input that is constant between two frames.
    """
    if exact:
        return 1.0 - exp(-dt / tau) if tau > 0.0 else 1.0
    return dt / (dt + tau)


def residue(u: float, i: int) -> float:
    """Compute the residue ``a_i`` of the luminance change ``i`` frames ago: ``1 / (1 + exp(u i))`` (`high-pass`)."""
    decay = exp(-u * i)  # written so that it cannot overflow
    return decay / (1.0 + decay)


def gaussian_kernel(sigma: float) -> npt.NDArray[np.float64]:
    """Make a Gaussian column (2 r + 1, 1) of sum 1, cut at ``r = ceil(4 sigma)`` px (`gauss-function`)."""
    radius = math.ceil(4.0 * sigma)
    return np.asarray(cv2.getGaussianKernel(2 * radius + 1, sigma, cv2.CV_64F), np.float64)


FloatArray = TypeVar("FloatArray", npt.NDArray[np.float32], npt.NDArray[np.float64])


def blur(image: FloatArray, kernel: FloatArray) -> FloatArray:
    """Convolve (R, C) with ``kernel`` along both axes, the border replicated."""
    return cast(FloatArray, cv2.sepFilter2D(image, -1, kernel, kernel, borderType=cv2.BORDER_REPLICATE))


def total(values: npt.NDArray[Any]) -> float:
    """Sum an array in double precision, with equal bits on each call.

    OpenCV's order of additions depends on the array's place in memory, and so do the last bits of its sums.
    """
    return float(np.add.reduce(values, axis=None, dtype=np.float64))


FACTOR = 1e-9
"""Floor of states that are multiplied with one another. Products of smaller values are subnormal."""
FADED = np.float32(1e-6)
"""Floor of a signal in grey levels that retains a residue of its last value. Smaller values are set to 0."""


class States:
    """Decaying arrays: all 0 after a reset, and periodically cleared of values below a floor.

    In a still scene a low-pass decays into subnormal numbers, which slow a processor many times. Clearing them costs
    almost nothing.

    Parameters
    ----------
    arrays
        The states.
    every
        Frames between two clearings. Use 16 for low-passes of 40 ms and less, which decay from 1e-30 to subnormal
        numbers in under 64 frames.
    floor
        Values below it are cleared; `FACTOR` for states that are multiplied with one another.
    """

    def __init__(self, *arrays: Floats, every: int = 64, floor: float = 1e-30) -> None:
        self._arrays, self._every, self._floor = arrays, every, floor
        self.frames = 0

    def reset(self) -> None:
        """Return to the state before the first frame."""
        for array in self._arrays:
            array[:] = 0.0
        self.frames = 0

    def count(self) -> None:
        """Count a frame, and clear values below the floor when it is time."""
        self.frames += 1
        if self.frames % self._every == 0:
            for array in self._arrays:
                array[np.abs(array) < self._floor] = 0.0
