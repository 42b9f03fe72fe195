"""The on-board network in C, where the extension module is built: ``onboard.h`` documents the C side."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dsnn.model import LayerMaps, Response
from dsnn.native import NativeModel, kernel
from dsnn.onboard.fixed import Fixed
from dsnn.onboard.header import TABLES


class NativeOnboard(NativeModel):
    """The stages on the robot in C; see `dsnn.onboard.model.OnboardDSNN`, which checks what goes in."""

    def __init__(self, fixed: Fixed) -> None:
        ffi, self._fixed = kernel().ffi, fixed
        self._tables = {name: ffi.new(f"{kind}[]", getattr(fixed, name) or (0,)) for name, kind in TABLES.items()}
        numbers = {name: getattr(fixed, name) for name in Fixed.__slots__ if name not in TABLES}
        self._config = ffi.new("onboard_config *", numbers | self._tables)
        super().__init__("onboard", self._config)
        self._step = self._lib.onboard_step

    def step(self, luma: npt.NDArray[np.uint8], maps: bool = False) -> Response:
        """Answer the next frame, (R, C) uint8."""
        frame = self._ffi.from_buffer("uint8_t[]", np.ascontiguousarray(luma))
        self._step(self._model, frame, self._answer)
        a = self._answer
        return Response(a.hs / 32768.0, a.vs / 32768.0, a.hs_spikes, a.vs_spikes, self._maps() if maps else None)

    def _maps(self) -> LayerMaps:
        c = self._fixed
        layers = np.empty((4, c.rows, c.columns), np.int32)
        self._lib.onboard_maps(self._model, *(self._ffi.from_buffer("int32_t[]", layer) for layer in layers))
        fractions = (c.p_frac, c.la_frac, c.f_frac, c.f_frac)
        return LayerMaps(*(layer / 2.0**bits for layer, bits in zip(layers, fractions, strict=True)))
