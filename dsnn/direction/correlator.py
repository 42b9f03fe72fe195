"""The ensembles of Reichardt detectors, summed over the field by matrix-vector products.

Every pair of cells ``s = j d`` apart contributes ``D_j(x) F(x+s) - w_i D_j(x+s) F(x)``, and the lobula
plate only needs the sum over the field. Rows are padded on the right with ``n_con d`` zeros, so that a
shift along x or y is one offset in flat memory and a pair that leaves the image meets a zero. The
delayed signals ``D_j`` stand one behind the other; a view of them whose row stride is the distance
between two states plus (or minus) one spacing lines each ``D_j`` up with ``F`` at its own shift, so one
product of that (n_con, R x padded C) view with ``F`` gives the field sums of all spacings at once.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.lib.stride_tricks import as_strided

from dsnn.filters import FLUSH_EVERY, flush
from dsnn.params import DSNNParams
from dsnn.retina import Floats


class Correlators:
    """Ensembles of correlators in both pathways: delay the signals in `f` at every spacing and sum over the field.

    ``f`` is the (2, R, C) float32 window to write the ON and OFF signals into before `step`.
    """

    def __init__(self, shape: tuple[int, int], params: DSNNParams) -> None:
        rows, columns = shape
        n, d = params.n_con, params.d
        width = columns + n * d
        span, reach = rows * width, n * d * width  # cells of one plane; the longest shift, downward
        self._w_i = params.w_i
        self._alphas = [params.alpha(tau) for tau in params.delays()]
        # A plane is followed by as many zeros as the longest shift reaches; ON and OFF make a pair of planes.
        plane = span + reach
        planes: Floats = np.zeros((2, plane), np.float32)
        self.f: Floats = planes[:, :span].reshape(2, rows, width)[..., :columns]
        self._signals = planes[:, :span, np.newaxis]
        self._pair = planes.reshape(1, 2 * plane)
        self._memory: Floats = np.zeros(reach + 2 * n * plane, np.float32)
        self._states = self._memory[reach:].reshape(n, 1, 2 * plane)
        # D_j is read at x - s under F(x) for excitation and at x + s for inhibition; HS first, then VS.
        shifts = [sign * step * d for step in (1, width) for sign in (-1, 1)]
        self._shifted = [self._view(reach, span, plane, shift) for shift in shifts]
        self._sums: Floats = np.zeros((4, 2, n, 1), np.float32)
        self._steps = 0

    def _view(self, reach: int, span: int, plane: int, shift: int) -> Floats:
        """Return the states as (2, n_con, span), row j ``(j + 1) shift`` cells into, or before, state j."""
        size = self._memory.itemsize
        strides = (plane * size, (2 * plane + shift) * size, size)
        return as_strided(self._memory[reach + shift :], (2, len(self._alphas), span), strides)

    def reset(self) -> None:
        """Forget every delayed signal."""
        self._memory[:] = 0.0
        self._steps = 0

    def step(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the field sums of excitation less weighted inhibition: HS of (ON, OFF), then VS of (ON, OFF)."""
        for state, a in zip(self._states, self._alphas, strict=True):
            cv2.accumulateWeighted(self._pair, state, a)  # dynamic-lowpass
        for view, sums in zip(self._shifted, self._sums, strict=True):
            np.matmul(view, self._signals, out=sums)  # not np.dot, which copies a strided view first
        self._steps += 1
        if self._steps % FLUSH_EVERY == 0:
            flush(self._memory)
        (e_hs, i_hs, e_vs, i_vs), w_i = self._sums.sum(axis=(2, 3)).tolist(), self._w_i
        # medulla-HS-EI .. lobula-VS-EI, LPTCs
        return (e_hs[0] - w_i * i_hs[0], e_hs[1] - w_i * i_hs[1]), (e_vs[0] - w_i * i_vs[0], e_vs[1] - w_i * i_vs[1])
