"""The network's layers as plain functions, in the order light takes them.

Each function is one layer, each line that carries an equation names it by its
label in the paper (Fu, Bellotto and Yue 2018, arXiv 1808.07692). Arrays are
(R, C); x is the column and grows rightward, y the row and grows downward. This
form is for reading and for testing against; `dsnn.native` is the fast one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

import numpy as np
import numpy.typing as npt

from dsnn.exponential import exp
from dsnn.filters import blur, residue

Map = npt.NDArray[np.float64]
Polarity = Literal["common", "centre"]
"""Whose sign LA takes."""


def retina(luminance: Map, previous: Map, residues: Sequence[Map], u: float) -> Map:
    """Change of luminance, with what is left of the last ``len(residues)`` changes, newest first."""
    p = luminance - previous  # high-pass
    for i, change in enumerate(residues, start=1):
        p = p + residue(u, i) * change
    return p


def lamina(p: Map, kernel_e: Map, kernel_i: Map, polarity: Polarity = "common") -> Map:
    """Difference of Gaussians, signed by the common polarity of centre and surround, or by that of the centre."""
    p_e, p_i = blur(p, kernel_e), blur(p, kernel_i)  # two-gauss
    la = np.abs(p_e - p_i)  # polar-dogs
    if polarity == "centre":
        return np.where(p_e >= 0, la, -la)
    return np.where((p_e >= 0) & (p_i >= 0), la, np.where((p_e < 0) & (p_i < 0), -la, 0.0))


def on_off(la: Map, on_before: Map, off_before: Map, sigma_l: float) -> tuple[Map, Map]:
    """Split into the ON and OFF pathways by half-wave rectification."""
    on = np.maximum(la, 0.0) + sigma_l * on_before  # halfwave
    off = np.maximum(-la, 0.0) + sigma_l * off_before
    return on, off


def fdsr(
    la: Map, la_before: Map, adaptation: Map, alpha_fast: float, alpha_slow: float, rectified: bool = True
) -> tuple[Map, Map]:
    """Fast depolarising, slow repolarising: return the signal F and the new adaptation state."""
    gain = np.where(la >= la_before, alpha_fast, alpha_slow)
    adaptation = adaptation + gain * (la - adaptation)  # fdsr-lowpass
    f = la - adaptation  # fdsr-subtraction
    return np.maximum(f, 0.0) if rectified else f, adaptation


def delayed(f: Map, states: Sequence[Map], alphas: Sequence[float]) -> list[Map]:
    """Return the delayed signal of each spacing."""
    return [state + a * (f - state) for state, a in zip(states, alphas, strict=True)]  # dynamic-lowpass


def correlate(f: Map, delays: Sequence[Map], d: int, w_i: float, axis: int) -> float:
    """Excitation less weighted inhibition of every pair along ``axis`` (1: HS, 0: VS), summed over the field."""
    total = 0.0
    for j, delay in enumerate(delays, start=1):
        (near_f, far_f), (near_d, far_d) = _ends(f, j * d, axis), _ends(delay, j * d, axis)
        excitation = float(np.sum(near_d * far_f))  # medulla-HS-EI, medulla-VS-EI,
        inhibition = float(np.sum(far_d * near_f))  # lobula-HS-EI, lobula-VS-EI
        total += excitation - w_i * inhibition  # LPTCs
    return total


def sigmoid(x: float, scale: float) -> float:
    """Odd sigmoid into (-0.5, 0.5); ``scale`` is C R K_sig."""
    return math.copysign(1.0 / (1.0 + exp(-abs(x) / scale)) - 0.5, x)  # sigmoid


def spikes(potential: float, k_sp: float, t_sp: float) -> int:
    """Return spikes of one frame, with the sign of ``potential``; none below the threshold, and none at rest."""
    if potential == 0.0 or abs(potential) < t_sp:
        return 0
    return int(math.copysign(math.floor(exp(k_sp * (abs(potential) - t_sp))), potential))  # spiking


def _ends(image: Map, spacing: int, axis: int) -> tuple[Map, Map]:
    """Take the cells at the near and far end of each pair ``spacing`` px apart; pairs that leave the image drop out."""
    size = max(image.shape[axis] - spacing, 0)
    near, far = [slice(None)] * 2, [slice(None)] * 2
    near[axis], far[axis] = slice(0, size), slice(spacing, spacing + size)
    return image[tuple(near)], image[tuple(far)]
