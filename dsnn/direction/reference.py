"""The reference DSNN: its layers as plain functions, in the order of processing, and the network made of them.

Each function is one layer. Each line with an equation names its label in the paper (Fu, Bellotto and Yue 2018, arXiv
1808.07692). Arrays are (R, C), float64; x is the column and grows rightward, y is the row and grows downward. Read this
form and test against it; `dsnn.native` is the fast one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from dsnn.exponential import exp
from dsnn.filters import blur, gaussian_kernel, residue
from dsnn.model import LayerMaps, Response
from dsnn.params import DSNNParams

Map = npt.NDArray[np.float64]
LEAST_ENERGY = 1.0
"""Least energy for an azimuth, as ``DSNN_LEAST_ENERGY`` in C. Noise alone has less energy and gives no direction."""


def retina(luminance: Map, previous: Map, residues: Sequence[Map], u: float) -> Map:
    """Compute the change of luminance, plus the residues of the last ``len(residues)`` changes, newest first."""
    p = luminance - previous  # high-pass
    for i, change in enumerate(residues, start=1):
        p = p + residue(u, i) * change
    return p


def lamina(p: Map, kernel_e: Map, kernel_i: Map, polarity: Literal["common", "centre"] = "common") -> Map:
    """Compute the difference of Gaussians, signed by the common polarity of centre and surround, or by the centre's."""
    p_e, p_i = blur(p, kernel_e), blur(p, kernel_i)  # two-gauss
    la = np.abs(p_e - p_i)  # polar-dogs
    if polarity == "centre":
        return np.where(p_e >= 0, la, -la)
    return np.where((p_e >= 0) & (p_i >= 0), la, np.where((p_e < 0) & (p_i < 0), -la, 0.0))


def on_off(la: Map, on_before: Map, off_before: Map, sigma_l: float) -> tuple[Map, Map]:
    """Split LA into the ON and OFF pathways by half-wave rectification."""
    on = np.maximum(la, 0.0) + sigma_l * on_before  # halfwave
    off = np.maximum(-la, 0.0) + sigma_l * off_before
    return on, off


def fdsr(
    la: Map, la_before: Map, adaptation: Map, alpha_fast: float, alpha_slow: float, rectified: bool = True
) -> tuple[Map, Map]:
    """Apply fast-depolarising, slow-repolarising adaptation; return the signal F and the new adaptation state."""
    gain = np.where(la >= la_before, alpha_fast, alpha_slow)
    adaptation = adaptation + gain * (la - adaptation)  # fdsr-lowpass
    f = la - adaptation  # fdsr-subtraction
    return np.maximum(f, 0.0) if rectified else f, adaptation


def delayed(f: Map, states: Sequence[Map], alphas: Sequence[float]) -> list[Map]:
    """Compute the delayed signal of each spacing."""
    return [state + a * (f - state) for state, a in zip(states, alphas, strict=True)]  # dynamic-lowpass


def correlate(f: Map, delays: Sequence[Map], d: int, w_i: float, axis: int) -> float:
    """Sum excitation minus weighted inhibition of all pairs along ``axis`` (1: HS, 0: VS) over the field."""
    total = 0.0
    for j, delay in enumerate(delays, start=1):
        (near_f, far_f), (near_d, far_d) = _ends(f, j * d, axis), _ends(delay, j * d, axis)
        excitation = float(np.sum(near_d * far_f))  # medulla-HS-EI, medulla-VS-EI,
        inhibition = float(np.sum(far_d * near_f))  # lobula-HS-EI, lobula-VS-EI
        total += excitation - w_i * inhibition  # LPTCs
    return total


def odd_sigmoid(x: float, scale: float) -> float:
    """Compute the odd sigmoid, with values in (-0.5, 0.5); ``scale`` is C R K_sig."""
    return math.copysign(1.0 / (1.0 + exp(-abs(x) / scale)) - 0.5, x)  # sigmoid


def spikes(potential: float, k_sp: float, t_sp: float) -> int:
    """Count the spikes of one frame, with the sign of ``potential``; 0 below the threshold and at rest."""
    if potential == 0.0 or abs(potential) < t_sp:
        return 0
    return int(math.copysign(math.floor(exp(k_sp * (abs(potential) - t_sp))), potential))  # spiking


def _ends(image: Map, spacing: int, axis: int) -> tuple[Map, Map]:
    """Return the cells at both ends of each pair ``spacing`` px apart, without pairs that leave the image."""
    size = max(image.shape[axis] - spacing, 0)
    near, far = [slice(None)] * 2, [slice(None)] * 2
    near[axis], far[axis] = slice(0, size), slice(spacing, spacing + size)
    return image[tuple(near)], image[tuple(far)]


class Pathway:
    """The ON or OFF pathway: adaptation, delayed signals and the two low-passed tangential sums."""

    def __init__(self, shape: tuple[int, int], params: DSNNParams) -> None:
        self._params = params
        self._alphas = [params.alpha(tau) for tau in params.delays()]
        self.la = np.zeros(shape)
        self.f = np.zeros(shape)
        self._adaptation = np.zeros(shape)
        self._delays = [np.zeros(shape) for _ in self._alphas]
        self.lp_hs = self.lp_vs = 0.0

    def step(self, la: npt.NDArray[np.float64]) -> None:
        """Process this pathway's signal of one frame."""
        p = self._params
        (before, self.la), f_before = (self.la, la), self.f
        if p.fdsr:
            fast, slow = p.alpha(p.tau_fast), p.alpha(p.tau_slow)
            state = before if p.lowpass in ("two-tap", "two-tap-fdsr") else self._adaptation
            self.f, self._adaptation = fdsr(la, before, state, fast, slow, p.rectified)
        else:
            self.f = la
        # Of two taps the second is the last input: it stands where the recursive filter has its last output.
        states = [f_before] * len(self._alphas) if p.lowpass == "two-tap" else self._delays
        self._delays = delayed(self.f, states, self._alphas)
        gain = p.alpha(p.tau_mp)
        self.lp_hs += gain * (correlate(self.f, self._delays, p.d, p.w_i, axis=1) - self.lp_hs)
        self.lp_vs += gain * (correlate(self.f, self._delays, p.d, p.w_i, axis=0) - self.lp_vs)


class ReferenceNetwork:
    """The DSNN's layers written as its equations; `dsnn.DSNN` checks the input."""

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
        """Respond to the next frame, (R, C) uint8 or floating."""
        q = self._params
        luminance = luma.astype(np.float64)
        before = luminance if self._luminance is None else self._luminance
        self._luminance = luminance
        p = retina(luminance, before, self._residues, q.u)
        self._residues = [p, *self._residues][: q.n_p]
        la = lamina(p, *self._kernels, q.polarity) if q.dog else p
        la_on, la_off = on_off(la, self._on.la, self._off.la, q.sigma_l)
        self._on.step(la_on)
        self._off.step(la_off)
        layers = LayerMaps(p.copy(), la.copy(), self._on.f.copy(), self._off.f.copy()) if maps else None
        return replace(self.read(q), maps=layers)

    def azimuth(self) -> float:
        """Locate the motion of the last frame in the view, as `dsnn.DSNN.azimuth` does."""
        energy = np.sum(self._on.f**2 + self._off.f**2, axis=0)
        place = np.linspace(-1.0, 1.0, self._shape[1])
        return float(np.sum(energy * place) / (np.sum(energy) + LEAST_ENERGY))

    def read(self, q: DSNNParams) -> Response:
        """Compute HS and VS, the sum of the intact pathways' sigmoid potentials, and their spikes."""
        scale = self._shape[0] * self._shape[1] * q.k_sig
        intact = [p for p, on in ((self._on, q.on), (self._off, q.off)) if on]
        hs = sum((odd_sigmoid(p.lp_hs, scale) for p in intact), 0.0)  # HS-VS
        vs = sum((odd_sigmoid(p.lp_vs, scale) for p in intact), 0.0)
        return Response(hs, vs, spikes(hs, q.k_sp, q.t_sp), spikes(vs, q.k_sp, q.t_sp))
