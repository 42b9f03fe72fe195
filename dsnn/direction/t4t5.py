"""T4 and T5 cells as a direction model: their opponent outputs, summed over the field."""

from __future__ import annotations

from typing import Any

import numpy.typing as npt
from pydantic import Field

from dsnn.direction.local_motion import LocalMotion, LocalMotionParams
from dsnn.direction.reference import odd_sigmoid
from dsnn.field_docs import parameters
from dsnn.filters import Floats, total
from dsnn.model import Model, Response


@parameters
class T4T5Params(LocalMotionParams):
    """Parameters of the T4 and T5 cells, and the scale of their sum over the field."""

    k_sig: float = Field(default=0.01, gt=0.0, le=1e3)
    """Scale of the sigmoid, as a share of the number of cells (assumed)."""


class T4T5(Model[T4T5Params]):
    """Contrast-normalised motion detectors at five spacings, with one array for each of four directions.

    These are the T4 and T5 cells of the attention LPLC2 (`dsnn.MLPLC2`). P, the change of luminance, passes two small
    Gaussian fields: ``S = G_exc * P - coe_inh G_inh * P``. S is split by the sign that both fields share, as in the
    DSNN. ON and OFF retain ``remain_rec`` of their last values. ``c = tanh(X / (coe_cn + G_cn * X))``, and 0 below
    ``cn_threshold``. Let D_j be the low-pass of c by the delay of spacing j. To motion to the right a cell responds
    with ``sum over j of max(D_j(x) D_j(x+j) [c(x+j) - b c(x)], 0)``, low-passed by ``tau_t``. The three other
    directions are computed likewise. ``M = T4^exp_on + T5^exp_off``. Channels: ``hs`` and ``vs``, right minus left and
    down minus up. Their sum over the field passes the DSNN's odd sigmoid with the scale ``k_sig R C``, which gives
    values in (-0.5, 0.5). There are no spikes.

    Assumed where the source leaves it open: Sign rule and border are the ones of the DSNN's difference of Gaussians,
    but a sum below a thousandth of a grey level has no sign. The low-passes are recursive. The sum over the field and
    its sigmoid are as in the DSNN. Time constants in ms hold at any frame rate; the published form received videos of
    30 frames/s.

    No published number was found that could be reproduced without the authors' clips.

    Costs about 15 DSNN steps (0.5 ms) at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``T4T5Params()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Liu and Fu 2025, arXiv 2504.04477.

    Examples
    --------
    >>> from dsnn import T4T5
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", motion="leftward", rows=72, columns=99, width=20, height=40)
    >>> series = T4T5(clip.shape).run(frame.luma for frame in clip)
    >>> bool(series.hs.min() < -0.1)
    True
    """

    def __init__(self, shape: tuple[int, int], params: T4T5Params | None = None) -> None:
        super().__init__(shape, params, T4T5Params)
        self._local = LocalMotion(self.shape, self.params)

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._local.reset()

    @property
    def local_motion(self) -> Floats:
        """What T4 and T5 cells respond to the last frame, (R, C, 2), right and down positive, in no unit of length."""
        return self._local.field()

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        motion = self._local.step(luminance)
        right, left, down, up = (total(part) for part in motion)
        scale = self.params.k_sig * self.shape[0] * self.shape[1]
        return Response(odd_sigmoid(right - left, scale), odd_sigmoid(down - up, scale))
