"""The on-board network in C, if the extension module is built; ``onboard.h`` documents the C side."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from dsnn.model import LayerMaps, Response
from dsnn.native import NativeModel, kernel
from dsnn.onboard.fixed import FixedPoint
from dsnn.onboard.header import TABLES


class NativeOnboard(NativeModel):
    """The robot's stages in C; `dsnn.onboard.model.OnboardDSNN` checks the input."""

    def __init__(self, fixed: FixedPoint) -> None:
        ffi, self._fixed = kernel().ffi, fixed
        self._tables = {name: ffi.new(f"{kind}[]", getattr(fixed, name) or (0,)) for name, kind in TABLES.items()}
        numbers = {name: getattr(fixed, name) for name in FixedPoint.__slots__ if name not in TABLES}
        self._config = ffi.new("onboard_config *", numbers | self._tables)
        super().__init__("onboard", self._config)
        self._step = self._lib.onboard_step

    def step(self, luma: npt.NDArray[np.uint8], maps: bool = False) -> Response:
        """Respond to the next frame, (R, C) uint8."""
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
