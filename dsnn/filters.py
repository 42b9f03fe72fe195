"""Parts that the models are made of: first-order low-passes, Gaussian blurs, sums."""

from __future__ import annotations

import math
from typing import Any, TypeVar, cast

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.exponential import exp


def alpha(tau: float, dt: float, *, exact: bool = False) -> float:
    """Gain of a first-order low-pass ``y += alpha (x - y)`` for ``tau`` and frame interval ``dt``, both ms.

    By backward Euler, or of the ``exact`` solution for an input that is constant between two frames.
    """
    if exact:
        return 1.0 - exp(-dt / tau) if tau > 0.0 else 1.0
    return dt / (dt + tau)


def residue(u: float, i: int) -> float:
    """Share ``a_i`` of the luminance change ``i`` frames ago that is left: ``1 / (1 + exp(u i))`` (`high-pass`)."""
    decay = exp(-u * i)  # written so that it cannot overflow
    return decay / (1.0 + decay)


def gaussian_kernel(sigma: float) -> npt.NDArray[np.float64]:
    """Column (2 r + 1, 1) of a Gaussian of ``sigma`` px cut at ``r = ceil(4 sigma)``, sum 1 (`gauss-function`)."""
    radius = math.ceil(4.0 * sigma)
    return np.asarray(cv2.getGaussianKernel(2 * radius + 1, sigma, cv2.CV_64F), np.float64)


FloatArray = TypeVar("FloatArray", npt.NDArray[np.float32], npt.NDArray[np.float64])


def blur(image: FloatArray, kernel: FloatArray) -> FloatArray:
    """Convolve (R, C) with ``kernel`` along both axes, the border replicated."""
    return cast(FloatArray, cv2.sepFilter2D(image, -1, kernel, kernel, borderType=cv2.BORDER_REPLICATE))


def total(values: npt.NDArray[Any]) -> float:
    """Return the sum of an array, in double precision, with equal bits on each call.

    The order in which OpenCV adds depends on where the array lies in memory, and so do the last bits of its sums.
    """
    return float(np.add.reduce(values, axis=None, dtype=np.float64))


FLUSH_EVERY = 64
FLUSH_OFTEN = 16
"""Floor for low-passes of 40 ms and less, which fade from 1e-30 to subnormal numbers in under 64 frames."""
FACTOR = 1e-9
"""Floor of states that are multiplied with one another: nothing below it is kept: products of less are subnormal."""
FADED = np.float32(1e-6)
"""Floor of a signal in grey levels that keeps a residue of its last value: nothing is left of what is smaller."""


def flush(state: npt.NDArray[np.float32], below: float = 1e-30) -> None:
    """Set what has decayed below 1e-30, or ``below`` another value, to zero, in place.

    In a still scene a low-pass decays into subnormal numbers, on which a processor takes many
    times longer; called every `FLUSH_EVERY` steps this keeps them out and costs next to nothing.
    """
    state[np.abs(state) < below] = 0.0
