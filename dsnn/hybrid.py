"""The hybrid model: DSNN and LGMD1 on the same frames, for direction, looming and position."""

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
    """Parameters of the DSNN, of the LGMD1 (``lgmd_...``, see `dsnn.LGMD1Params`) and of the gate."""

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
        """Make the parameters of the LGMD1."""
        return LGMD1Params(w_i=self.lgmd_w_i, t_g=self.lgmd_t_g, t_ffi=self.lgmd_t_ffi, t_sp=self.lgmd_t_sp)


class Hybrid(Model[HybridParams]):
    """DSNN and LGMD1 on the same frames, where looming gates direction, as the paper proposes for further work.

    Assumed, because the paper only proposes it: The way in which the two are joined.

    - ``looming`` and its spikes are the LGMD1's, ``hs`` and ``vs`` the DSNN's potentials.
    - The spikes of HS and VS mean translation. In a frame with a looming spike, and for ``gate`` ms after it, there are
      none. The moving object then approaches, and the sign of ``hs`` gives its drift across the view.
    - ``azimuth`` is the position of the motion: the mean column of the squared ON and OFF activity after FDSR. It runs
      from -1 at the left edge to 1 at the right, and is 0 if nothing moves. Flies fixate by such a dependence on
      position (Reichardt and Poggio 1976).

    Costs about 1.4 steps of the DSNN at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``HybridParams()``.
    form
        ``native`` (in C) or ``reference``, as in `dsnn.DSNN`.

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

    Examples
    --------
    >>> from dsnn import Hybrid
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("looming")
    >>> series = Hybrid(clip.shape).run(frame.luma for frame in clip)
    >>> series.accumulated_spikes("looming") > 0, bool(series.looming.max() > 0.9)
    (True, True)
    """

    def __init__(self, shape: tuple[int, int], params: HybridParams | None = None, *, form: str | None = None) -> None:
        super().__init__(shape, params, HybridParams)
        q = self.params
        values = {field.name: getattr(q, field.name) for field in dataclasses.fields(DSNNParams)}
        self._dsnn = DSNN(self.shape, DSNNParams(**values), form=form)
        self._lgmd = LGMD1(self.shape, q.lgmd, form=form)
        self.form = self._dsnn.form
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
