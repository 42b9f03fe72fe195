"""The DSNN and the LGMD1 on one retina's input: which way, how near, and where."""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any

import numpy.typing as npt
from pydantic import Field

from dsnn.direction.network import DSNN
from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.looming.lgmd1 import LGMD1, LGMD1Params
from dsnn.model import Model, Response
from dsnn.params import DSNNParams


@parameters
class HybridParams(DSNNParams):
    """The DSNN's parameters, those of `dsnn.LGMD1Params` that matter under ``lgmd_``, and the gate's."""

    lgmd_w_i: float = Field(default=0.6, ge=0.0, le=10.0)
    """Weight of inhibition in the LGMD1."""
    lgmd_t_g: float = Field(default=30.0, ge=0.0, le=1e6)
    """Threshold of the LGMD1's grouped excitation."""
    lgmd_t_ffi: Annotated[float, unit("grey levels")] = Field(default=10.0, ge=0.0, le=255.0)
    """Mean change of the last frame that vetoes the LGMD1's spikes."""
    lgmd_t_sp: float = Field(default=0.78, gt=0.5, le=1.0)
    """Spike threshold on the LGMD1's potential k."""
    gate: Milliseconds = 200.0
    """Time after a looming spike for which the spikes of HS and VS are held back."""

    @property
    def lgmd(self) -> LGMD1Params:
        """The parameters of its LGMD1."""
        return LGMD1Params(w_i=self.lgmd_w_i, t_g=self.lgmd_t_g, t_ffi=self.lgmd_t_ffi, t_sp=self.lgmd_t_sp)


class Hybrid(Model[HybridParams]):
    """DSNN and LGMD1 see the same frames, and looming gates direction: the paper's proposal for further work.

    Assumed, as the paper only proposes it: how the two are joined.

    - ``looming`` and its spikes are the LGMD1's, ``hs`` and ``vs`` the DSNN's potentials.
    - The spikes of HS and VS mean translation. In a frame with a looming spike, and for ``gate`` ms after it, there
      are none: what moves then comes nearer, and the sign of ``hs`` tells which way it drifts across the view.
    - ``azimuth`` tells where the motion is: the mean column of the squared ON and OFF activity after FDSR, -1 at the
      left edge, 1 at the right; 0 where nothing moves. Flies fixate by such a dependence on position (Reichardt and
      Poggio 1976).

    Costs about 1.4 steps of the DSNN at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; those of ``HybridParams()`` if left out.
    form
        ``native`` (in C) or ``reference``, as of `dsnn.DSNN`.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.
    dsnn.forms.FormError
        The form is unknown, or is ``native`` where that is not built.

    References
    ----------
    Fu, Bellotto and Yue 2018, arXiv 1808.07692: their discussion. Yue and Rind 2006, IEEE Transactions on Neural
    Networks 17. Reichardt and Poggio 1976.
    """

    def __init__(self, shape: tuple[int, int], params: HybridParams | None = None, *, form: str | None = None) -> None:
        super().__init__(shape, params, HybridParams)
        q = self.params
        values = {field.name: getattr(q, field.name) for field in dataclasses.fields(DSNNParams)}
        self._dsnn = DSNN(self.shape, DSNNParams(**values), form=form)
        self._lgmd = LGMD1(self.shape, q.lgmd, form=form)
        self._dsnn._scale_known = self._lgmd._scale_known = True  # this model looks at the frames itself
        self._frames_held = round(q.gate / q.dt)
        self.reset()

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._dsnn.reset()
        self._lgmd.reset()
        self._held = 0

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        way, near = self._dsnn.step(luminance, maps=maps), self._lgmd.step(luminance)
        self._held = self._frames_held + 1 if near.looming_spikes else max(self._held - 1, 0)
        return dataclasses.replace(
            way,
            hs_spikes=0 if self._held else way.hs_spikes,
            vs_spikes=0 if self._held else way.vs_spikes,
            looming=near.looming,
            looming_spikes=near.looming_spikes,
            azimuth=self._dsnn.azimuth(),
        )
