"""ESTMD, the elementary small-target motion detector."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import Milliseconds, parameters
from dsnn.model import Response
from dsnn.small_target.layers import SmallTargetModel, SmallTargetParams, strongest


@parameters
class ESTMDParams(SmallTargetParams):
    """Parameters of the ESTMD: those of the shared layers, and its delay."""

    tau_off: Milliseconds = Field(default=25.0, gt=0.0)
    """Time constant of the Gamma filter of order 12 that delays OFF (toolkit: 25 frames)."""


class ESTMD(SmallTargetModel[ESTMDParams]):
    """A pixel that darkens and soon brightens again, as when a small dark target passes: ON times delayed OFF.

    The blurred luminance L passes two Gamma filters: ``Y = G_2,fast * L - G_3,slow * L``. ``ON = max(Y, 0)`` and ``OFF
    = max(-Y, 0)`` each lose what surrounds them: ``X = max(W * X, 0)``, where W is a difference of two Gaussians whose
    negative part counts ``inhibition`` times. So long edges inhibit themselves. The response of a pixel is ``ON
    (G_12,off * OFF)``. Channels: ``target``, the strongest response in the field, in squared grey levels; ``azimuth``
    and ``elevation``, where it is, from -1 to 1, right and down positive. There are no spikes.

    Assumed: A Gamma filter of order n is n + 1 recursive low-passes of tau / n. So it holds at 30 frames/s too, where a
    sampled kernel of a few ms does not. A signal below a thousandth of a grey level is 0. The lamina's inhibition in
    space and time, which the public programs compute in different ways, is left out, and so are the original's adapting
    photoreceptors.

    The published clips have 1000 frames/s. At 30 a target that moves by more than its width in a frame leaves gaps
    between its places.

    Costs about 14 DSNN steps (0.7 ms) at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``ESTMDParams()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Wiederman, Shoemaker and O'Carroll 2008, PLoS ONE 3:e2784; constants as in the toolkit
    Small-Target-Motion-Detectors.

    Examples
    --------
    >>> from dsnn import ESTMD
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("target", background="even", background_speed=0.0, speed=150.0)
    >>> series = ESTMD(clip.shape).run(frame.luma for frame in clip)
    >>> at = int(series.target.argmax())
    >>> box = clip[at].truth.box
    >>> bool(abs(series.azimuth[at] - (2 * (box.left + box.width / 2) / 99 - 1)) < 0.15)
    True
    """

    DELAYS: ClassVar = {"tau_off": 12}

    def __init__(self, shape: tuple[int, int], params: ESTMDParams | None = None) -> None:
        super().__init__(shape, params, ESTMDParams)

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        on, off = map(self._inhibited, self._polarities(luminance))
        return strongest(on * self._delays[0].step(off))[0]
