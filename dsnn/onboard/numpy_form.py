"""The specification of the on-board network: its stages in whole numbers with NumPy.

`dsnn/native/onboard.c` computes the same, bit for bit. Labels are those of the paper's equations. ``Qn`` is a number
with n fractional bits. Rounding works on magnitudes, whatever the sign, so that a mirrored clip gives mirrored
responses.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn.model import LayerMaps, Response
from dsnn.onboard.codes import coded, decoded
from dsnn.onboard.fixed import LARGEST_G, LARGEST_P, FixedPoint

Ints = npt.NDArray[np.int64]


class NumpyOnboard:
    """The robot's stages in NumPy; `dsnn.onboard.model.OnboardDSNN` checks the input."""

    def __init__(self, fixed: FixedPoint) -> None:
        self._c = fixed
        self.reset()

    def reset(self) -> None:
        """Return to the state before the first frame."""
        c = self._c
        shape = c.rows, c.columns
        self._luma: Ints | None = None
        self._changes = [np.zeros(shape, np.int64) for _ in range(c.n_p)]
        self._la, self._h = np.zeros((2, 2, *shape), np.int64)
        self._codes = np.zeros((2, c.spacings, *shape), np.int64)
        self._sums = [[0, 0], [0, 0]]

    def step(self, luma: npt.NDArray[np.uint8], maps: bool = False) -> Response:
        """Respond to the next frame, (R, C) uint8."""
        c = self._c
        p = self._retina(luma.astype(np.int64))
        la = self._lamina(p)
        for pathway, sign in enumerate((1, -1)):
            self._adapt(pathway, np.maximum(sign * la, 0))
        fields = [self._correlate(pathway) for pathway in range(2)]
        hs, vs = (self._plate(system, (fields[0][system], fields[1][system])) for system in range(2))
        layers = None
        if maps:
            f = [np.maximum(h, 0) / 2.0**c.f_frac for h in self._h]
            layers = LayerMaps(p / 2.0**c.p_frac, la / 2.0**c.la_frac, f[0], f[1])
        return Response(hs / 32768.0, vs / 32768.0, self._spikes(hs), self._spikes(vs), layers)

    def rounded(self, x: Any, bits: int) -> Any:
        """Divide ``x`` by 2 to the power ``bits``, truncated or to the nearest; ties go to the smaller magnitude."""
        return rounded(x, bits, bool(self._c.truncate))

    def _retina(self, luma: Ints) -> Ints:
        """Compute P in Q p_frac (`high-pass`)."""
        c = self._c
        change = luma - (luma if self._luma is None else self._luma)
        self._luma = luma
        if c.halved:
            change = 2 * np.clip(np.sign(change) * (np.abs(change) >> 1), -127, 127)
        left = sum((a * p for a, p in zip(c.residues, self._changes, strict=True)), np.zeros_like(change))
        p: Ints = np.clip((change << c.p_frac) + self.rounded(left, 15), -LARGEST_P, LARGEST_P)
        self._changes = [p, *self._changes][: c.n_p]
        return p

    def _lamina(self, p: Ints) -> Ints:
        """Compute LA in Q la_frac, positive for ON and negative for OFF (`two-gauss`, `polar-dogs`)."""
        c = self._c
        if not c.dog:
            whole: Ints = self.rounded(p, c.p_frac - c.la_frac)
            return whole
        p_e, p_i = (blurred(self.rounded(blurred(p, k, 0), 15), k, 1) for k in (c.kernel_e, c.kernel_i))
        la: Ints = self.rounded(np.abs(p_e - p_i), 15 + c.p_frac - c.la_frac)
        return np.where((p_e >= 0) & (p_i >= 0), la, np.where((p_e < 0) & (p_i < 0), -la, 0))

    def _adapt(self, pathway: int, la: Ints) -> None:
        """Update LA with its residue, and h: F in Q f_frac where it is positive, otherwise LA - A in Q g_frac.

        F is ``left`` times ``LA(t) - A(t - 1)``, which equals LA(t) minus A(t).
        """
        c, before, h = self._c, self._la[pathway].copy(), self._h[pathway]
        la = np.minimum(la + self.rounded(c.sigma_l * before, 15), c.la_max)  # halfwave
        self._la[pathway] = la
        if not c.fdsr:
            self._h[pathway] = np.minimum(rescaled(la, c.la_frac, c.f_frac, bool(c.truncate)), c.f_max)
            return
        g = np.where(h >= 0, h << (c.work_frac - c.f_frac), h * (1 << (c.work_frac - c.g_frac)))
        gap = g + (la - before) * (1 << (c.work_frac - c.la_frac))
        left = gap * np.where(la >= before, c.left_fast, c.left_slow)  # fdsr-lowpass, fdsr-subtraction
        f = np.minimum(self.rounded(np.maximum(left, 0), 31 + c.work_frac - c.f_frac), c.f_max)
        below = self.rounded(np.minimum(left, 0), 31 + c.work_frac - c.g_frac)
        self._h[pathway] = np.where(left >= 0, f, np.maximum(below, -LARGEST_G))

    def _correlate(self, pathway: int) -> tuple[int, int]:
        """Compute the field sums of HS and VS: excitation minus weighted inhibition over all spacings."""
        c, f = self._c, np.maximum(self._h[pathway], 0)
        sums = [[0, 0], [0, 0]]
        for j, a in enumerate(c.alphas):
            delayed = self._decoded(self._codes[pathway, j])
            codes = self._coded((delayed << 15) + a * (f - delayed))  # dynamic-lowpass
            self._codes[pathway, j] = codes
            delayed, s = self._decoded(codes), (j + 1) * c.d
            if s < c.columns:
                sums[0][0] += int((delayed[:, :-s] * f[:, s:]).sum())  # medulla-HS-EI
                sums[0][1] += int((delayed[:, s:] * f[:, :-s]).sum())
            if s < c.rows:
                sums[1][0] += int((delayed[:-s] * f[s:]).sum())  # medulla-VS-EI
                sums[1][1] += int((delayed[s:] * f[:-s]).sum())
        e_hs, i_hs, e_vs, i_vs = (value >> c.field_shift for pair in sums for value in pair)
        weighted = (e * 32768 - c.w_i * i for e, i in ((e_hs, i_hs), (e_vs, i_vs)))
        hs, vs = (int(self.rounded(value, 15)) for value in weighted)
        return hs, vs

    def _decoded(self, codes: Ints) -> Ints:
        """Decode D in Q f_frac."""
        return codes if self._c.state_bits == 16 else decoded(codes, bool(self._c.companding))

    def _coded(self, value: Ints) -> Ints:
        """Find the code of D, given with 15 more fractional bits than F."""
        if self._c.state_bits == 16:
            codes: Ints = self.rounded(value, 15)
            return codes
        return coded(value, bool(self._c.companding), bool(self._c.truncate))

    def _plate(self, system: int, fields: tuple[int, int]) -> int:
        """Compute HS or VS in Q15 (`LPTCs`, `sigmoid`, `HS-VS`)."""
        c, potential = self._c, 0
        for pathway, intact in enumerate((c.on, c.off)):
            before = self._sums[system][pathway]
            now = int(self.rounded(before * 32768 + c.alpha_mp * (fields[pathway] - before), 15))
            self._sums[system][pathway] = now
            if intact:
                potential += self._sigmoid(abs(now)) * (1 if now >= 0 else -1)
        return potential

    def _sigmoid(self, size: int) -> int:
        """Interpolate the sigmoid's table for a low-passed field sum, 0 or more, in Q15 up to 1/2."""
        c = self._c
        if size >= c.plate_limit:
            return c.sigmoid[-1]
        at = min(((size >> c.plate_shift) * c.plate_gain) >> c.plate_right, (len(c.sigmoid) - 1) * 2048 - 1)
        low, high = c.sigmoid[at >> 11], c.sigmoid[(at >> 11) + 1]
        return low + (((high - low) * (at & 2047) + 1024) >> 11)

    def _spikes(self, potential: int) -> int:
        """Count the spikes of one frame, with the potential's sign: one for each threshold reached (`spiking`)."""
        count = sum(abs(potential) >= threshold for threshold in self._c.thresholds)
        return count if potential >= 0 else -count


def rounded(x: Any, bits: int, truncate: bool) -> Any:
    """Divide ``x`` by 2 to the power ``bits``, truncating or rounding its magnitude; 0 bits change nothing."""
    if bits == 0:
        return x
    bias = 0 if truncate else (1 << (bits - 1)) - 1
    return np.sign(x) * ((abs(x) + bias) >> bits)


def rescaled(x: Ints, from_frac: int, to_frac: int, truncate: bool) -> Ints:
    """Convert a number from Q``from_frac`` to Q``to_frac``."""
    if to_frac >= from_frac:
        return x << (to_frac - from_frac)
    scaled: Ints = rounded(x, from_frac - to_frac, truncate)
    return scaled


def blurred(image: Ints, half: tuple[int, ...], axis: int) -> Ints:
    """Convolve with a symmetric kernel along ``axis``, replicating the border; ``half`` has the centre first."""
    radius, length = len(half) - 1, image.shape[axis]
    places = np.clip(np.arange(-radius, length + radius), 0, length - 1)
    wide = np.take(image, places, axis)

    def shifted(by: int) -> Ints:
        chosen = [slice(None)] * 2
        chosen[axis] = slice(radius + by, radius + by + length)
        return wide[tuple(chosen)]

    total: Ints = half[0] * shifted(0)
    for i, weight in enumerate(half[1:], start=1):
        total = total + weight * (shifted(-i) + shifted(i))
    return total
