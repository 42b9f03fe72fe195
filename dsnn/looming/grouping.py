"""Layers that both models of the locust's lobula giant movement detectors (LGMDs) share: grouping and the potential."""

from __future__ import annotations

import cv2
import numpy as np

from dsnn.exponential import exp
from dsnn.filters import total
from dsnn.retina import Floats

REST = 0.5
"""An LGMD's membrane potential while nothing excites it."""


class Grouping:
    """Favours excitation that comes in clusters, then gives the potential of what is left (Yue and Rind 2006).

    ``Ce`` is the 3x3 mean of S, cells outside the field counting as 0; ``G = S Ce / (delta_c + max Ce / c_w)``,
    kept where it reaches ``t_g``; ``k = 1 / (1 + exp(-sum G / N))`` for N cells.
    """

    def __init__(self, shape: tuple[int, int], c_w: float, delta_c: float, t_g: float) -> None:
        self._c_w, self._delta_c = c_w, delta_c
        # OpenCV keeps what is above its threshold, the source what reaches it.
        self._below = float(np.nextafter(np.float32(t_g), np.float32(-1.0)))
        self._ce, self._g = np.zeros((2, *shape), np.float32)

    def potential(self, s: Floats) -> float:
        """Return the membrane potential k, from `REST` up to 1, for the summed cells S, (R, C), none negative."""
        cv2.blur(s, (3, 3), dst=self._ce, borderType=cv2.BORDER_CONSTANT)
        scale = self._delta_c + float(self._ce.max()) / self._c_w
        cv2.multiply(s, self._ce, dst=self._g, scale=1.0 / scale)
        cv2.threshold(self._g, self._below, 0.0, cv2.THRESH_TOZERO, dst=self._g)
        return sigmoid(total(self._g) / s.size)


def sigmoid(drive: float) -> float:
    """Return the membrane potential of a drive of 0 or more: `REST` at 0, 1 at infinity."""
    return 1.0 / (1.0 + exp(-drive))


def ring(side: float, corner: float, centre: float = 0.0) -> Floats:
    """Return a 3x3 kernel of its centre's, its sides' and its corners' weights."""
    return np.array([[corner, side, corner], [side, centre, side], [corner, side, corner]], np.float32)


def convolve(image: Floats, kernel: Floats, out: Floats) -> Floats:
    """(R, C) by a symmetric 3x3 ``kernel``, cells outside the field counting as 0; written to ``out``."""
    cv2.filter2D(image, -1, kernel, dst=out, borderType=cv2.BORDER_CONSTANT)
    return out
