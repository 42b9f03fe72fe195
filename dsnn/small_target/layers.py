"""The layers that ESTMD and DSTMD share: Gamma filters, lamina, surround inhibition, and where the response is."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, TypeVar

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.filters import FACTOR, Floats, States, alpha, blur, gaussian_kernel
from dsnn.model import Model, Response

LAMINA: dict[str, int] = {"tau_fast": 2, "tau_slow": 3}
"""Parameter of each of the lamina's two Gamma filters -> its order."""
FAINT = 1e-3
"""Grey levels below which a signal is 0: more than rounding leaves of a still scene."""
SURROUND_PX = 15
"""Side of the kernel of surround inhibition, px."""


@parameters
class SmallTargetParams:
    """Parameters of retina, lamina and surround inhibition.

    The toolkit of the DSTMD's authors, Small-Target-Motion-Detectors, counts time constants in frames. The papers'
    clips have 1000 frames/s, so one frame there is 1 ms here.
    """

    sigma: Annotated[float, unit("px")] = Field(default=1.0, gt=0.0, le=10.0)
    """Standard deviation of the retina's blur (toolkit: 1)."""
    tau_fast: Milliseconds = Field(default=3.0, gt=0.0)
    """Time constant of the lamina's fast Gamma filter, of order 2 (toolkit: 3 frames)."""
    tau_slow: Milliseconds = Field(default=6.0, gt=0.0)
    """Time constant of its slow one, of order 3 (toolkit: 6 frames)."""
    sigma_centre: Annotated[float, unit("px")] = Field(default=1.5, gt=0.0, le=10.0)
    """Standard deviation of the centre of surround inhibition (toolkit: 1.5)."""
    sigma_surround: Annotated[float, unit("px")] = Field(default=3.0, gt=0.0, le=10.0)
    """Standard deviation of its surround (toolkit: 3)."""
    inhibition: float = Field(default=3.0, ge=0.0, le=100.0)
    """Weight B of what inhibits; that of what excites, A, is 1 (toolkit: 3)."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, gt=0.0, le=10_000.0)
    """Frame rate (papers: 1000)."""


class Gamma:
    """A Gamma filter of order n: n + 1 low-passes in a row, each with the time constant tau / n.

    The mean delay is tau (n + 1) / n at any frame rate. A sampled Gamma kernel is 0 at once and, at 30 frames/s, one
    frame late for any tau of a few ms.
    """

    def __init__(self, shape: tuple[int, int], order: int, tau: float, fps: float) -> None:
        self.gain = alpha(tau / order, 1000.0 / fps)
        self.stages: Floats = np.zeros((order + 1, *shape), np.float32)

    def step(self, signal: Floats) -> Floats:
        """Return the delayed signal. The buffer is valid until the next step."""
        for stage in self.stages:
            cv2.accumulateWeighted(signal, stage, self.gain)
            signal = stage
        return signal


Q = TypeVar("Q", bound=SmallTargetParams)


class SmallTargetModel(Model[Q]):
    """Base class of both: retina, lamina and delays. A subclass names its delays, and responds to ON and OFF."""

    DELAYS: ClassVar[dict[str, int]]
    """Parameter of a delay -> the order of its Gamma filter."""

    def __init__(self, shape: tuple[int, int], params: Q | None, kind: type[Q]) -> None:
        super().__init__(shape, params, kind)
        q = self.params
        self._blur = gaussian_kernel(q.sigma).astype(np.float32)
        self._fast, self._slow, *self._delays = (
            Gamma(self.shape, order, getattr(q, name), q.fps) for name, order in (LAMINA | self.DELAYS).items()
        )
        self._kernel = surround_kernel(q.sigma_centre, q.sigma_surround, q.inhibition)
        self._states = States(*(delay.stages for delay in self._delays), every=16, floor=FACTOR)

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._states.reset()

    def _polarities(self, luminance: npt.NDArray[Any]) -> tuple[Floats, Floats]:
        """Return the lamina's ON and OFF signals of the next frame, each (R, C), none negative."""
        light = blur(luminance.astype(np.float32), self._blur)
        if not self._states.frames:
            self._fast.stages[:] = self._slow.stages[:] = light
        self._states.count()
        band = self._fast.step(light) - self._slow.step(light)
        return rectified(band), rectified(-band)

    def _inhibited(self, signal: Floats) -> Floats:
        """Return a signal after surround inhibition, with 0 beyond the border."""
        return rectified(cv2.filter2D(signal, -1, self._kernel, borderType=cv2.BORDER_CONSTANT))


def rectified(signal: Any) -> Floats:
    """Return a signal where it is `FAINT` or more, and 0 elsewhere."""
    return np.asarray(cv2.threshold(signal, FAINT, 0.0, cv2.THRESH_TOZERO)[1], np.float32)


def surround_kernel(centre: float, surround: float, inhibition: float) -> Floats:
    """Make the kernel of surround inhibition: a difference of two Gaussians, its negative part multiplied."""
    squares = (np.arange(SURROUND_PX) - SURROUND_PX // 2) ** 2
    distance = squares[:, np.newaxis] + squares
    one, other = (np.exp(-distance / (2.0 * s * s)) / (2.0 * math.pi * s * s) for s in (centre, surround))
    difference = one - other
    return np.where(difference > 0.0, difference, inhibition * difference).astype(np.float32)


def strongest(responses: Floats) -> tuple[Response, tuple[int, int]]:
    """Return the strength and the place of the strongest response of a map (R, C), and its row and column.

    Below `FAINT` squared there is none.
    """
    rows, columns = responses.shape
    _, strength, _, (column, row) = cv2.minMaxLoc(responses)
    if strength < FAINT * FAINT:
        return Response(), (row, column)
    azimuth, elevation = (2.0 * (at + 0.5) / size - 1.0 for at, size in ((column, columns), (row, rows)))
    return Response(target=strength, azimuth=azimuth, elevation=elevation), (row, column)
