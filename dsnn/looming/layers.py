"""Layers that looming detectors share: the collision count, adaptation, grouping and quadrants."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from typing import Any, Protocol, TypeVar

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.exponential import exp
from dsnn.filters import Floats, total
from dsnn.model import Model, Response

REST = 0.5
"""An LGMD's membrane potential while nothing excites it."""


class _CollisionParams(Protocol):
    @property
    def n_sp(self) -> int: ...


D = TypeVar("D", bound=_CollisionParams)


class Detector(Model[D]):
    """Base class of looming detectors. A subclass computes potential and spikes of a frame in `_detect`.

    Parameters and errors are those of `dsnn.model.Model`. ``params.n_sp`` spikes without a silent frame between them
    signal a collision.
    """

    def __init__(self, shape: tuple[int, int], params: D | None, kind: type[D]) -> None:
        super().__init__(shape, params, kind)
        self._count = 0

    @abstractmethod
    def _detect(self, luminance: npt.NDArray[Any]) -> tuple[float, int]:
        """Return the potential, from 0.5 at rest up to 1, and the spikes of the next frame, (R, C) grey levels."""

    @abstractmethod
    def _forget(self) -> None:
        """Return the layers to the state before the first frame."""

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._forget()
        self._count = 0

    @property
    def collision(self) -> bool:
        """Whether the frames so far signal a collision."""
        return self._count >= self.params.n_sp

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        potential, spikes = self._detect(luminance)
        self._count = self._count + spikes if spikes else 0
        return Response(looming=potential, looming_spikes=spikes)


class Adaptation:
    """Spike-frequency adaptation: a potential that does not rise decays, and the remainder gives the spikes.

    Let ``h = tau / (tau + dt)`` and dk the change of k. Then ``s = h (s(t-1) + dk)`` where dk is at most ``t_sfa``,
    otherwise ``h k``; it is at least `REST`. There are ``floor(exp(k_sp (s - t_sp)))`` spikes in a frame.
    """

    def __init__(self, tau: float, dt: float, t_sfa: float, k_sp: float, t_sp: float) -> None:
        self._hold, self._t_sfa, self._k_sp, self._t_sp = tau / (tau + dt), t_sfa, k_sp, t_sp
        self.reset()

    def reset(self) -> None:
        """Return to rest."""
        self._k = self._adapted = REST

    def step(self, k: float) -> tuple[float, int]:
        """Return the adapted potential of this frame's k, and its spikes."""
        rise, self._k = k - self._k, k
        held = self._adapted + rise if rise <= self._t_sfa else k
        self._adapted = max(REST, self._hold * held)
        return self._adapted, math.floor(exp(self._k_sp * (self._adapted - self._t_sp)))


class Grouping:
    """Enhance clustered excitation, and compute the potential of the result (Yue and Rind 2006).

    ``Ce`` is the 3x3 mean of S, with 0 outside the field. ``G = S Ce / (delta_c + max Ce / c_w)``, and 0 below ``t_g``.
    ``k = 1 / (1 + exp(-sum G / N))`` for N cells.
    """

    def __init__(self, shape: tuple[int, int], c_w: float, delta_c: float, t_g: float) -> None:
        self._c_w, self._delta_c, self._below = c_w, delta_c, below(t_g)
        self._ce, self._g = np.zeros((2, *shape), np.float32)

    def potential(self, s: Floats) -> float:
        """Compute the membrane potential k, from `REST` up to 1, of the summed cells S, (R, C), none negative."""
        cv2.blur(s, (3, 3), dst=self._ce, borderType=cv2.BORDER_CONSTANT)
        scale = self._delta_c + float(self._ce.max()) / self._c_w
        cv2.multiply(s, self._ce, dst=self._g, scale=1.0 / scale)
        cv2.threshold(self._g, self._below, 0.0, cv2.THRESH_TOZERO, dst=self._g)
        return sigmoid(total(self._g) / s.size)


def below(threshold: float) -> float:
    """Return the number just below a threshold: the papers pass a value equal to it, OpenCV does not."""
    return float(np.nextafter(np.float32(threshold), np.float32(-1.0)))


def sigmoid(drive: float) -> float:
    """Compute the membrane potential of a drive of 0 or more: `REST` at 0, 1 at infinity."""
    return 1.0 / (1.0 + exp(-drive))


def ring(side: float, corner: float, centre: float = 0.0) -> Floats:
    """Make a 3x3 kernel with the given weights of centre, sides and corners."""
    return np.array([[corner, side, corner], [side, centre, side], [corner, side, corner]], np.float32)


def convolve(image: Floats, kernel: Floats, out: Floats) -> Floats:
    """Convolve (R, C) with a symmetric 3x3 ``kernel`` into ``out``, with 0 outside the field."""
    cv2.filter2D(image, -1, kernel, dst=out, borderType=cv2.BORDER_CONSTANT)
    return out


def by_quadrant(
    x: Sequence[Floats], y: Sequence[Floats], rows: npt.NDArray[np.float64], columns: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Sum over the four quadrants, in a fixed order of additions.

    Parameters
    ----------
    x, y
        Outward motion to the left and to the right, and upward and downward: two arrays (R, C) each.
    rows, columns
        The share of each row in the upper and lower half, (2, R), and of each column in the left and right half, (2,
        C).

    Returns
    -------
    numpy.ndarray
        (2, 2): upper and lower, left and right.
    """
    along_x = [((rows[:, :, np.newaxis] * factor).sum(axis=1) * half).sum(axis=1)
               for factor, half in zip(x, columns, strict=True)]  # fmt: skip
    along_y = [((half[:, np.newaxis] * factor).sum(axis=0) * columns).sum(axis=1)
               for factor, half in zip(y, rows, strict=True)]  # fmt: skip
    return np.asarray(np.stack(along_x, axis=1) + np.stack(along_y))
