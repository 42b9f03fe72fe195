"""The DSNN in its plain form: float64, one array a state, the layers called one after another."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn.direction import layers
from dsnn.filters import gaussian_kernel
from dsnn.frames import Channels, checked_params, checked_shape
from dsnn.model import LayerMaps, Model, Response
from dsnn.params import DSNNParams


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


class ReferenceDSNN(Model):
    """The DSNN as its equations read, 17 times slower than `dsnn.DSNN`, which is tested against it.

    Assumed: what `dsnn.DSNN` assumes.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; those of ``DSNNParams()`` if left out.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Fu, Bellotto and Yue 2018, arXiv 1808.07692.
    """

    def __init__(self, shape: tuple[int, int], params: DSNNParams | None = None) -> None:
        self.shape = checked_shape(shape)
        self.params = checked_params(params, DSNNParams)
        self._kernels = gaussian_kernel(self.params.d), gaussian_kernel(2 * self.params.d)
        self.reset()

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._luminance: npt.NDArray[np.float64] | None = None
        self._residues = [np.zeros(self.shape) for _ in range(self.params.n_p)]
        self._on, self._off = Pathway(self.shape, self.params), Pathway(self.shape, self.params)

    def step(self, frame: npt.NDArray[Any], *, channels: Channels = "grey", maps: bool = False) -> Response:
        """Answer the next frame.

        Parameters, returns and errors are those of `dsnn.VisionModel.step`. Maps are there if they are asked for.
        """
        q = self.params
        luminance = self._luma(frame, channels).astype(np.float64)
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

    def _lobula_plate(self) -> tuple[float, float]:
        """HS and VS: each intact pathway's sigmoid potential, added."""
        scale = self.shape[0] * self.shape[1] * self.params.k_sig
        intact = [p for p, on in ((self._on, self.params.on), (self._off, self.params.off)) if on]
        hs = sum((layers.sigmoid(p.lp_hs, scale) for p in intact), 0.0)  # HS-VS
        vs = sum((layers.sigmoid(p.lp_vs, scale) for p in intact), 0.0)
        return hs, vs
