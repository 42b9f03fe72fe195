"""Elementary motion detectors (EMDs), the classical model that the DSNN is compared with."""

from __future__ import annotations

import math
from typing import Annotated, Any

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.filters import Floats, Retina, States, alpha, total
from dsnn.model import Model, Response

FULL_SCALE = 255.0**2
"""The largest product of two signals, in squared grey levels."""


@parameters
class EMDParams:
    """Parameters of the EMD array. Iida's own constants were not available, so these are assumed."""

    tau_hp: Milliseconds = 250.0
    """Time constant of the luminance's temporal high-pass; 0 switches it off (assumed)."""
    tau_lp: Milliseconds = 50.0
    """Time constant of the low-pass that delays a detector's arm (assumed)."""
    spacing: Annotated[int, unit("px")] = Field(default=1, ge=1, le=64)
    """Distance between a detector's two arms (assumed)."""
    log: bool = True
    """Whether potentials are logarithmic, as the paper plots them; false: linear."""
    gain: float = Field(default=1.0, gt=0.0, le=1e3)
    """Gain of the output, applied after the logarithm if ``log`` is set."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, gt=0.0, le=10_000.0)
    """Frame rate."""


class EMD(Model[EMDParams]):
    """Array of full Hassenstein-Reichardt correlators along x and y, its opponent output averaged over the field.

    The arrangement follows Iida and Lambrinos (a bee's odometer): one pathway serves both polarities, and each
    detector's two arms are subtracted. With H the high-passed luminance and D its delayed copy, ``R = D(x) H(x+s) -
    H(x) D(x+s)``. Pairs that leave the image are dropped. Channels: ``hs`` and ``vs``. Let r be the mean of R in
    squared grey levels, and F = 255^2 the full scale. The potential is ``sgn(r) ln(1 + |r|) / ln(1 + F)`` by default,
    or r / F if ``log`` is false, times ``gain``. Neither channel has spikes, as the paper reads the potential's peak.

    Assumed, because the paper only mentions "the logarithmic output" and Iida's constants were not available: Both time
    constants and the spacing. The high-pass is first order: ``H(t) = (1 - alpha) (H(t-1) + L(t) - L(t-1))``. The 1
    added under the logarithm keeps rest at 0 and preserves the sign. Filters start settled on the first frame.

    Costs about 0.6 of a DSNN step at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``EMDParams()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Hassenstein and Reichardt 1956; Iida and Lambrinos 2000.

    Examples
    --------
    >>> from dsnn import EMD
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", motion="leftward", rows=72, columns=99, width=20, height=40)
    >>> series = EMD(clip.shape).run(frame.luma for frame in clip)
    >>> bool(series.hs.min() < -0.1)
    True
    """

    READOUT = ("log", "gain")
    """Parameters that act on the mean output alone: models that differ only in them need one array (`read`)."""

    def __init__(self, shape: tuple[int, int], params: EMDParams | None = None) -> None:
        super().__init__(shape, params, EMDParams)
        q = self.params
        rows, columns = self.shape
        self._pass = 1.0 - alpha(q.tau_hp, 1000.0 / q.fps)
        self._delay = alpha(q.tau_lp, 1000.0 / q.fps)
        self._retina = Retina(self.shape)
        # Rows end in zeros, so that a pair along x or y is one offset in flat memory.
        width = columns + q.spacing
        self._shifts = q.spacing, q.spacing * width
        self._h: Floats = np.zeros((rows, width), np.float32)
        self._d = np.zeros_like(self._h)
        self._states = States(self._h, self._d)
        self.reset()

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._retina.reset()
        self._states.reset()

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        signal = self._h[:, : self.shape[1]]
        if self.params.tau_hp > 0.0:
            signal += self._retina.step(luminance)
            signal *= np.float32(self._pass)
        else:
            np.copyto(signal, luminance, casting="same_kind")
        if self._states.frames == 0:
            np.copyto(self._d, self._h)
        cv2.accumulateWeighted(self._h, self._d, self._delay)
        self._states.count()
        self._means = [self._opponent(shift) for shift in self._shifts]
        return self.read(self.params)

    def read(self, params: EMDParams) -> Response:
        """Respond to the last frame again, as a model with another readout would.

        Parameters
        ----------
        params
            Parameters that differ from this model's in those of `READOUT` alone.

        Returns
        -------
        Response
            The response.
        """
        hs, vs = (self._potential(r, params) for r in self._means)
        return Response(hs, vs)

    def _opponent(self, shift: int) -> float:
        """Average the difference of both arms over the field, for cells ``shift`` apart in flat memory."""
        h, d = self._h.ravel(), self._d.ravel()
        # No dot products: in which order BLAS adds depends on the processor and on the threads that are free.
        products = d[:-shift] * h[shift:]
        products -= h[:-shift] * d[shift:]
        return total(products) / (self.shape[0] * self.shape[1])

    def _potential(self, r: float, q: EMDParams) -> float:
        share = math.log1p(abs(r)) / math.log1p(FULL_SCALE) if q.log else abs(r) / FULL_SCALE
        return math.copysign(q.gain * share, r)
