"""Compute all whole numbers of the on-board network once, from its parameters and the frame's shape.

Notation: a number in Qn has n fractional bits, its unit is 2 to the power -n.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from dsnn.exponential import exp
from dsnn.filters import alpha, gaussian_kernel, residue
from dsnn.frames import FrameError, checked_shape
from dsnn.onboard.codes import coded, decoded
from dsnn.onboard.params import OnboardParams, largest_change, most_f_bits

LONGEST_SIDE = 4096
"""Most rows or columns. Up to it field sums stay below 2 to the power 60."""
Q15 = 15
LARGEST_P, LARGEST_G = 32767, 32768
SUM_BITS = 45
"""Bits of a field sum before it is weighted, so that its product with a Q15 number fits 63 bits."""
SIGMOID_END, SIGMOID_STEPS = 12, 32
"""The sigmoid's table ends at an argument of 12, where the sigmoid is 1 - 6e-6 of its limit; its steps are 1/32."""
HALF = 16383
"""The largest output of the sigmoid in Q15, so that HS and VS stay within (-1, 1)."""
MOST_SPIKES = 256
"""Most spikes in one frame, where the table of thresholds ends."""
_CODES = np.arange(256)


@dataclass(frozen=True, slots=True)
class FixedPoint:
    """The constants of the on-board network, all whole numbers, under the names of `dsnn/native/onboard.h`.

    Tables are tuples. Lengths are in px, gains of low-passes in Q15.
    """

    rows: int
    columns: int
    n_p: int
    d: int
    spacings: int
    """Number of spacings with pairs inside the image, n_con or fewer."""
    on: int
    off: int
    dog: int
    fdsr: int
    halved: int
    truncate: int
    state_bits: int
    companding: int
    lamina_bits: int
    p_frac: int
    la_frac: int
    f_frac: int
    g_frac: int
    """Fractional bits of negative LA - A, which shares a word with F."""
    work_frac: int
    f_max: int
    sigma_l: int
    left_fast: int
    """1 - alpha(tau_fast) in Q31."""
    left_slow: int
    w_i: int
    field_shift: int
    alpha_mp: int
    plate_limit: int
    """The low-passed field sum at which the sigmoid's table ends."""
    plate_shift: int
    plate_gain: int
    plate_right: int
    thresholds_count: int
    residues: tuple[int, ...]
    kernel_e: tuple[int, ...]
    kernel_i: tuple[int, ...]
    alphas: tuple[int, ...]
    decode: tuple[int, ...]
    """Code of an 8-bit D -> its value, in units of F."""
    decay: tuple[int, ...]
    """Spacing by code: the code of an 8-bit D after a frame in which F is 0."""
    sigmoid: tuple[int, ...]
    thresholds: tuple[int, ...]

    @property
    def la_max(self) -> int:
        """The value at which LA saturates."""
        return (1 << self.lamina_bits) - 1

    @property
    def state_bytes(self) -> int:
        """Compute the bytes of a model on the robot, as ``onboard_size`` does in C."""
        cells, radius = self.rows * self.columns, 8 * self.d
        parts = (
            cells, 2 * cells * max(self.n_p, 1), self.lamina_bits // 4 * cells, 4 * cells,
            self.state_bits // 4 * cells * self.spacings, 2 * (self.columns + 2 * radius),
            2 * (self.columns + 2 * radius), 4 * self.columns, 2 * (self.columns + 2 * self.spacings * self.d),
            2 * self.columns * (self.spacings + 1), self.rows,
        )  # fmt: skip
        return 48 + sum(-(-part // 8) * 8 for part in parts) + 8


@lru_cache(maxsize=8)
def constants(shape: tuple[int, int], params: OnboardParams) -> FixedPoint:
    """Compute the whole numbers of a network.

    Parameters
    ----------
    shape
        (R, C) of the frames, at most `LONGEST_SIDE` each.
    params
        The parameters of the on-board network.

    Raises
    ------
    dsnn.frames.FrameError
        The shape is invalid or too large.
    """
    rows, columns = checked_shape(shape)
    if max(rows, columns) > LONGEST_SIDE:
        raise FrameError(
            f"shape must be at most {LONGEST_SIDE} rows and columns for dsnn-onboard, got {(rows, columns)}"
        )
    q = params
    largest_p = largest_change(q)
    largest_la = largest_p / (1.0 - q.sigma_l)
    left_fast, left_slow = (1.0 - alpha(tau, q.dt) for tau in (q.tau_fast, q.tau_slow))
    p_frac = _room(largest_p, LARGEST_P)
    la_frac = min(_room(largest_la, 2**q.lamina_bits - 1), p_frac)
    f_max = _largest_f(q)
    f_frac = _f_frac(q, largest_la, left_fast, f_max)
    g_frac = min(_room(largest_la, LARGEST_G), f_frac)
    spacings = min(q.n_con, (max(rows, columns) - 1) // q.d)
    cells = rows * columns
    field_shift = max(math.ceil(math.log2(cells * max(spacings, 1) * f_max**2)) - SUM_BITS, 0)
    limit, shift, gain, right = _plate(cells * q.k_sig, 2 * f_frac - field_shift)
    thresholds = _thresholds(q)
    alphas = tuple(_q(alpha(tau, q.dt)) for tau in q.delays()[:spacings])
    return FixedPoint(
        rows=rows, columns=columns, n_p=q.n_p, d=q.d, spacings=spacings, on=int(q.on), off=int(q.off), dog=int(q.dog),
        fdsr=int(q.fdsr), halved=int(q.halved), truncate=int(q.rounding == "truncate"), state_bits=q.state_bits,
        companding=int(q.companding and q.state_bits == 8), lamina_bits=q.lamina_bits, p_frac=p_frac,
        la_frac=la_frac, f_frac=f_frac, g_frac=g_frac, work_frac=max(f_frac, la_frac) + 1, f_max=f_max,
        sigma_l=_q(q.sigma_l), left_fast=_q(left_fast, 31), left_slow=_q(left_slow, 31), w_i=_q(q.w_i),
        field_shift=field_shift, alpha_mp=_q(alpha(q.tau_mp, q.dt)), plate_limit=limit, plate_shift=shift,
        plate_gain=gain, plate_right=right, thresholds_count=len(thresholds), kernel_e=_kernel(q.d),
        kernel_i=_kernel(2 * q.d), residues=tuple(_q(residue(q.u, i)) for i in range(1, q.n_p + 1)), alphas=alphas,
        decode=tuple(decoded(_CODES, q.companding).tolist()), decay=_decay(q, alphas),
        sigmoid=tuple(
            min(round(32768.0 * (1.0 / (1.0 + exp(-i / SIGMOID_STEPS)) - 0.5)), HALF)
            for i in range(SIGMOID_END * SIGMOID_STEPS + 1)
        ),
        thresholds=thresholds,
    )  # fmt: skip


def _f_frac(q: OnboardParams, largest_la: float, left_fast: float, f_max: int) -> int:
    """Choose the fractional bits of F: as requested, or as many as an edge of full contrast allows.

    LA is largest where one side of an edge changes by all 255 grey levels and the other stays constant. It is then P
    times the positive part of the difference of Gaussians. If neighbours brighten and darken at once LA can be up to
    twice as large, and F saturates.
    """
    if q.f_bits is not None:
        return q.f_bits
    share = 1.0
    if q.dog:
        e, i = (np.outer(k, k) for k in (gaussian_kernel(q.d)[:, 0], gaussian_kernel(2 * q.d)[:, 0]))
        share = float(np.maximum(np.pad(e, 4 * q.d) - i, 0.0).sum())
    largest_f = largest_la * share * (max(left_fast, 0.0) if q.fdsr else 1.0)
    return min(_room(largest_f, f_max), most_f_bits(largest_la))


def _q(value: float, bits: int = Q15) -> int:
    """Convert ``value``, 0..1, to Q``bits``. It must fit 32 bits, so 1 in Q31 is one unit less."""
    return min(math.floor(value * 2.0**bits + 0.5), 2**31 - 1)


def _room(largest: float, steps: int) -> int:
    """Count the fractional bits that ``largest`` leaves in a word that ends at ``steps``; 15 at most."""
    return 15 if largest * 2.0**15 <= steps else max(math.floor(math.log2(steps / largest)), 0)


def _kernel(sigma: int) -> tuple[int, ...]:
    """Make one half of the Gaussian in Q15, its centre first. The whole sums to exactly 1."""
    half = [_q(float(value)) for value in gaussian_kernel(sigma)[4 * sigma :, 0]]
    return 32768 - 2 * sum(half[1:]), *half[1:]


def _largest_f(q: OnboardParams) -> int:
    """Return the largest F. It equals the largest D, so that no low-pass can leave its format."""
    return 32767 if q.state_bits == 16 else int(decoded(_CODES, q.companding)[-1])


def _decay(q: OnboardParams, alphas: tuple[int, ...]) -> tuple[int, ...]:
    values = decoded(_CODES, q.companding)
    after = [coded(values * (32768 - a), q.companding, q.rounding == "truncate").tolist() for a in alphas]
    return tuple(code for codes in after for code in codes)


def _plate(scale: float, frac: int) -> tuple[int, int, int, int]:
    """Scale a field sum S in Q``frac`` to the sigmoid's argument in Q16: ``(S >> shift) * gain >> right``."""
    factor = 2.0 ** (16 - frac) / scale
    limit = max(min(math.ceil(SIGMOID_END * 2.0**16 / factor), 2**46), 1)
    shift = max(limit.bit_length() - 31, 0)
    right = min(max(31 - math.frexp(factor * 2.0**shift)[1], 0), 62)
    gain = min(math.floor(factor * 2.0 ** (shift + right) + 0.5), 2**31 - 1)
    return limit, shift, gain, right


def _thresholds(q: OnboardParams) -> tuple[int, ...]:
    """List the |HS| in Q15 from which on there are 1, 2, ... spikes: ``t_sp + ln(n) / k_sp``, up to the largest HS."""
    thresholds: list[int] = []
    while len(thresholds) < MOST_SPIKES:
        more = math.log(len(thresholds) + 1)
        if more > 0.0 and more >= q.k_sp * 1.0:
            break
        at = max(math.ceil(32768.0 * (abs(q.t_sp) + (more / q.k_sp if more else 0.0))), 1)
        if at > 2 * HALF:
            break
        thresholds.append(at)
    return tuple(thresholds)
