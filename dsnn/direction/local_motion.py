"""T4 and T5 cells: local motion in four directions from contrast-normalised ON and OFF signals at several spacings.

Both polarities share one flat buffer. Rows end in as many zeros as the widest spacing, and planes in as many rows of
zeros. A pair along x or y is then one offset in flat memory, and a pair that leaves the image meets a zero.
"""

from __future__ import annotations

from typing import Annotated, Any

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.filters import FACTOR, FADED, Floats, Retina, States, alpha, blur

RIGHT, LEFT, DOWN, UP = range(4)
"""The order of directions in arrays of four."""
NO_CHANGE = np.float32(1e-3)
"""A sum of changes below this many grey levels is a rounding error."""


@parameters
class LocalMotionParams:
    """Parameters of T4 and T5 cells. The defaults are the literature's."""

    width_exc: Annotated[int, unit("px")] = Field(default=3, ge=1, le=63)
    """Side of the excitatory field, odd."""
    width_inh: Annotated[int, unit("px")] = Field(default=5, ge=1, le=63)
    """Side of the inhibitory field, odd."""
    width_cn: Annotated[int, unit("px")] = Field(default=5, ge=1, le=63)
    """Side of the field that normalises contrast, odd."""
    std_exc: Annotated[float, unit("px")] = Field(default=10.0, gt=0.0, le=1e3)
    """Sigma of the excitatory field."""
    std_inh: Annotated[float, unit("px")] = Field(default=20.0, gt=0.0, le=1e3)
    """Sigma of the inhibitory field."""
    std_cn: Annotated[float, unit("px")] = Field(default=20.0, gt=0.0, le=1e3)
    """Sigma of the field that normalises contrast."""
    coe_inh: float = Field(default=1.2, ge=0.0, le=10.0)
    """Weight of the inhibitory field."""
    remain_rec: float = Field(default=0.1, ge=0.0, lt=1.0)
    """Residue of the ON and OFF signals."""
    coe_cn: Annotated[float, unit("grey levels")] = Field(default=0.2, gt=0.0, le=255.0)
    """Baseline of the normalisation."""
    cn_threshold: float = Field(default=0.75, ge=0.0, lt=1.0)
    """Threshold below which a normalised signal is 0."""
    sd: Annotated[int, unit("px")] = Field(default=1, ge=1, le=16)
    """Sampling distance."""
    n_con: int = Field(default=5, ge=1, le=32)
    """Connected cells per cell and direction."""
    tau_d: tuple[Milliseconds, Milliseconds] = (80.0, 40.0)
    """Delay at the nearest and the farthest pair of cells."""
    emd_bias: float = Field(default=1.0, ge=0.0, le=10.0)
    """Weight of the null direction (1.5 in one build)."""
    tau_t: Milliseconds = 30.0
    """Time constant of the low-pass of T4 and T5 cells."""
    exp_on: float = Field(default=0.9, gt=0.0, le=4.0)
    """Exponent of T4 cells."""
    exp_off: float = Field(default=0.5, gt=0.0, le=4.0)
    """Exponent of T5 cells."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, gt=0.0, le=10_000.0)
    """Frame rate."""

    def delays(self) -> tuple[float, ...]:
        """Compute the delay of each spacing, linear from the nearest pair to the farthest.

        Returns
        -------
        tuple of float
            ``n_con`` delays in ms.
        """
        near, far = self.tau_d
        return tuple(near + (far - near) * j / max(self.n_con - 1, 1) for j in range(self.n_con))


class LocalMotion:
    """Layers that compute local motion from luminance, for frames of ``shape`` (R, C)."""

    def __init__(self, shape: tuple[int, int], q: LocalMotionParams) -> None:
        rows, columns = shape
        self._q, dt = q, 1000.0 / q.fps
        self._retina = Retina(shape)
        self._excitatory, self._inhibitory, self._local = (
            np.asarray(cv2.getGaussianKernel(width | 1, std, cv2.CV_32F), np.float32)
            for width, std in ((q.width_exc, q.std_exc), (q.width_inh, q.std_inh), (q.width_cn, q.std_cn))
        )
        reach = q.n_con * q.sd
        wide, high = columns + reach, rows + reach
        plane = high * wide
        self._offsets = [(j * q.sd * step, axis) for j in range(1, q.n_con + 1) for axis, step in ((0, 1), (2, wide))]
        self._alphas = [alpha(tau, dt) for tau in q.delays()]
        self._follow = alpha(q.tau_t, dt)
        self._signals = np.zeros((2, *shape), np.float32)
        self._c = np.zeros(2 * plane, np.float32)
        self._delayed = np.zeros((q.n_con, 2 * plane), np.float32)
        self._cells, self._drive = np.zeros((2, 4, 2 * plane), np.float32)
        self._product, self._scratch = np.zeros((2, 2 * plane), np.float32)
        self._window = (slice(None), slice(rows), slice(columns))
        self._planes = (2, high, wide)
        self._motion = np.zeros((4, *shape), np.float32)
        self._states = States(self._signals, self._delayed, self._cells, every=16, floor=FACTOR)

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._retina.reset()
        self._states.reset()
        self._motion[:] = 0.0

    def step(self, luminance: npt.NDArray[Any]) -> Floats:
        """Compute the next frame's local motion, (4, R, C): right, left, down, up. Valid until the next step."""
        self._normalise(self._retina.step(luminance))
        for state, gain in zip(self._delayed, self._alphas, strict=True):
            cv2.accumulateWeighted(self._c, state, gain)
        self._correlate()
        cv2.accumulateWeighted(self._drive, self._cells, self._follow)
        self._states.count()
        cells = self._cells.reshape(4, *self._planes)[(slice(None), *self._window)]
        t4, t5 = cells.swapaxes(0, 1)
        np.add(power(t4, self._q.exp_on), power(t5, self._q.exp_off), out=self._motion)
        return self._motion

    def field(self) -> Floats:
        """Return right less left, and down less up, of the last frame, (R, C, 2), in no unit of length; a copy."""
        right, left, down, up = self._motion
        return np.stack([right - left, down - up], axis=-1)

    def _normalise(self, p: Floats) -> None:
        """Write the signed difference of Gaussians, with its residue, normalised by the neighbourhood, into `_c`."""
        q = self._q
        centre, around = blur(p, self._excitatory), blur(p, self._inhibitory)
        contrast = np.abs(centre - np.float32(q.coe_inh) * around)
        self._signals *= np.float32(q.remain_rec)
        for signal, polarity in zip(self._signals, split(centre, around), strict=True):
            signal += contrast * polarity
        self._signals[self._signals < FADED] = 0.0
        for signal, plane in zip(self._signals, self._c.reshape(self._planes)[self._window], strict=True):
            local = blur(signal, self._local)
            local += np.float32(q.coe_cn)
            c = np.tanh(np.divide(signal, local, out=local), out=local)
            c[c < np.float32(q.cn_threshold)] = 0.0
            plane[:] = c

    def _correlate(self) -> None:
        """Put the sum over spacings of D(x) D(x + j) [c(x + j) - b c(x)], no term negative, into `_drive`."""
        bias = np.float32(self._q.emd_bias)
        self._drive[:] = 0.0
        weighted = bias * self._c
        for number, (offset, axis) in enumerate(self._offsets):
            d = self._delayed[number // 2]
            both = np.multiply(d[:-offset], d[offset:], out=self._product[:-offset])
            term = self._scratch[:-offset]
            for here, there, cells in (
                (self._c[offset:], weighted[:-offset], self._drive[axis, :-offset]),
                (self._c[:-offset], weighted[offset:], self._drive[axis + 1, offset:]),
            ):
                np.subtract(here, there, out=term)
                np.multiply(term, both, out=term)
                np.maximum(term, np.float32(0.0), out=term)
                cells += term


def split(centre: Floats, around: Floats) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """Return where both fields brighten, and where both darken, each (R, C).

    A sum that is zero up to rounding has no sign, since its sign would depend on the order of the additions.
    """
    low, high = np.minimum(centre, around), np.maximum(centre, around)
    return low > NO_CHANGE, high < -NO_CHANGE


def power(values: Floats, exponent: float) -> Floats:
    """Raise values, none negative, to a power. A 0 stays within 1e-13 of 0.

    It uses logarithm and exponential. The libraries' own powers take forty times as long where most values are 0.
    """
    if exponent == 0.5:
        return np.sqrt(values)
    logarithm = np.log(np.maximum(values, np.float32(1e-30)))
    logarithm *= np.float32(exponent)
    return np.asarray(np.exp(logarithm, out=logarithm))
