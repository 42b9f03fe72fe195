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
import numpy.typing as npt
from numpy.lib.stride_tricks import as_strided

from dsnn.filters import FLUSH_EVERY, alpha, flush
from dsnn.params import DSNNParams

Floats = npt.NDArray[np.float32]


def padded_planes(count: int, shape: tuple[int, int], params: DSNNParams) -> Floats:
    """``count`` zero planes (count, R, C + n_con d) for the signals F, which go into the first C columns."""
    rows, columns = shape
    return np.zeros((count, rows, columns + params.n_con * params.d), np.float32)


class Correlator:
    """One pathway's ensemble: delays the signal in ``plane`` at every spacing and sums over the field."""

    def __init__(self, plane: Floats, params: DSNNParams) -> None:
        n, d, width = params.n_con, params.d, plane.shape[1]
        span, reach = plane.size, n * d * width  # cells of one plane; the longest shift, downward
        self._w_i = params.w_i
        self._plane = plane.reshape(span)
        self._row = plane.reshape(1, span)
        self._memory: Floats = np.zeros(reach + n * (span + reach), np.float32)
        starts = range(reach, self._memory.size, span + reach)
        self._states = [self._memory[start : start + span].reshape(1, span) for start in starts]
        self._alphas = [alpha(tau, params.dt) for tau in params.delays()]
        # D_j is read at x - s under F(x) for excitation and at x + s for inhibition; HS first, then VS.
        self._shifted = [self._view(reach, span, sign * step * d) for step in (1, width) for sign in (-1, 1)]
        self._sums: Floats = np.zeros((4, n), np.float32)
        self._steps = 0

    def _view(self, reach: int, span: int, shift: int) -> Floats:
        """The states as an (n_con, span) matrix whose row j starts ``(j + 1) shift`` cells into, or before, state j."""
        size = self._memory.itemsize
        return as_strided(
            self._memory[reach + shift :], (len(self._states), span), ((span + reach + shift) * size, size)
        )

    def reset(self) -> None:
        """Forget every delayed signal."""
        self._memory[:] = 0.0
        self._steps = 0

    def step(self) -> tuple[float, float]:
        """Delay the plane's signal; return the field sums (HS, VS) of excitation less weighted inhibition."""
        for state, a in zip(self._states, self._alphas, strict=True):
            cv2.accumulateWeighted(self._row, state, a)  # dynamic-lowpass
        for view, sums in zip(self._shifted, self._sums, strict=True):
            np.matmul(view, self._plane, out=sums)  # not np.dot, which copies a strided view first
        self._steps += 1
        if self._steps % FLUSH_EVERY == 0:
            flush(self._memory)
        e_hs, i_hs, e_vs, i_vs = self._sums.sum(axis=1).tolist()
        return e_hs - self._w_i * i_hs, e_vs - self._w_i * i_vs  # medulla-HS-EI .. lobula-VS-EI, LPTCs
