"""The DSNN in its plain form: float64, one array a state, the layers called one after another."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn.direction import layers
from dsnn.filters import gaussian_kernel
from dsnn.model import LayerMaps, Response
from dsnn.params import DSNNParams

LEAST_ENERGY = 1.0
"""Least energy of the azimuth, as ``DSNN_LEAST_ENERGY`` of the C form: noise alone, of less energy, points nowhere."""


class Pathway:
    """ON or OFF: adaptation, delayed signals and the two low-passed tangential sums."""

    def __init__(self, shape: tuple[int, int], params: DSNNParams) -> None:
        self._params = params
        self._alphas = [params.alpha(tau) for tau in params.delays()]
        self.la = np.zeros(shape)
        self.f = np.zeros(shape)
        self._adaptation = np.zeros(shape)
        self._delays = [np.zeros(shape) for _ in self._alphas]
        self.lp_hs = self.lp_vs = 0.0

    def step(self, la: npt.NDArray[np.float64]) -> None:
        """Take this pathway's signal of one frame."""
        p = self._params
        before, self.la = self.la, la
        if p.fdsr:
            fast, slow = p.alpha(p.tau_fast), p.alpha(p.tau_slow)
            self.f, self._adaptation = layers.fdsr(la, before, self._adaptation, fast, slow, p.rectified)
        else:
            self.f = la
        self._delays = layers.delayed(self.f, self._delays, self._alphas)
        gain = p.alpha(p.tau_mp)
        self.lp_hs += gain * (layers.correlate(self.f, self._delays, p.d, p.w_i, axis=1) - self.lp_hs)
        self.lp_vs += gain * (layers.correlate(self.f, self._delays, p.d, p.w_i, axis=0) - self.lp_vs)


class ReferenceNetwork:
    """The DSNN's layers as its equations read; see `dsnn.DSNN`, which checks what goes in."""

    def __init__(self, shape: tuple[int, int], params: DSNNParams) -> None:
        self._shape, self._params = shape, params
        self._kernels = gaussian_kernel(params.d), gaussian_kernel(2 * params.d)
        self.reset()

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._luminance: npt.NDArray[np.float64] | None = None
        self._residues = [np.zeros(self._shape) for _ in range(self._params.n_p)]
        self._on, self._off = Pathway(self._shape, self._params), Pathway(self._shape, self._params)

    def step(self, luma: npt.NDArray[Any], *, maps: bool) -> Response:
        """Answer the next frame, (R, C) uint8 or floating."""
        q = self._params
        luminance = luma.astype(np.float64)
        before = luminance if self._luminance is None else self._luminance
        self._luminance = luminance
        p = layers.retina(luminance, before, self._residues, q.u)
        self._residues = [p, *self._residues][: q.n_p]
        la = layers.lamina(p, *self._kernels, q.polarity) if q.dog else p
        la_on, la_off = layers.on_off(la, self._on.la, self._off.la, q.sigma_l)
        self._on.step(la_on)
        self._off.step(la_off)
        hs, vs = self._lobula_plate()
        return Response(
            hs,
            vs,
            layers.spikes(hs, q.k_sp, q.t_sp),
            layers.spikes(vs, q.k_sp, q.t_sp),
            LayerMaps(p.copy(), la.copy(), self._on.f.copy(), self._off.f.copy()) if maps else None,
        )

    def azimuth(self) -> float:
        """Return where in the view the motion of the last frame was, as `dsnn.DSNN.azimuth` does."""
        energy = np.sum(self._on.f**2 + self._off.f**2, axis=0)
        place = np.linspace(-1.0, 1.0, self._shape[1])
        return float(np.sum(energy * place) / (np.sum(energy) + LEAST_ENERGY))

    def _lobula_plate(self) -> tuple[float, float]:
        """HS and VS: each intact pathway's sigmoid potential, added."""
        scale = self._shape[0] * self._shape[1] * self._params.k_sig
        intact = [p for p, on in ((self._on, self._params.on), (self._off, self._params.off)) if on]
        hs = sum((layers.sigmoid(p.lp_hs, scale) for p in intact), 0.0)  # HS-VS
        vs = sum((layers.sigmoid(p.lp_vs, scale) for p in intact), 0.0)
        return hs, vs
