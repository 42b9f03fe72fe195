"""The DSNN's layers in NumPy and OpenCV: float32, ON and OFF stacked, every buffer made once.

This form runs where the C kernel is not built. It computes what `dsnn.direction.reference.ReferenceDSNN` computes. The
masks of the lamina and of FDSR are the sign bits of float32 values, spread over the word by an arithmetic shift and
applied with AND: several times cheaper than `np.where`. (A sign bit also marks -0.0, but equal numbers differ by +0.0
and a sum of such differences is +0.0, so a still pixel is never taken for a darkening one.) Scratch is reused, because
at 99x72 the whole state only just fits a small core's second-level cache.
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.direction import layers
from dsnn.direction.correlator import Correlators
from dsnn.filters import blur, gaussian_kernel, residue
from dsnn.model import LayerMaps, Response
from dsnn.params import DSNNParams
from dsnn.retina import Floats, Retina

_SIGN_SHIFT = 31
LEAST_ENERGY = 1.0
"""Least energy of the azimuth, as ``DSNN_LEAST_ENERGY`` of the C form: noise alone, of less energy, points nowhere."""


class Lamina:
    """Signed difference of Gaussians, split into ON and OFF (`two-gauss`, `polar-dogs`, `halfwave`)."""

    def __init__(self, shape: tuple[int, int], params: DSNNParams) -> None:
        self._sigma_l, self._dog, self._common = params.sigma_l, params.dog, params.polarity == "common"
        self._kernel_e = gaussian_kernel(params.d).astype(np.float32)
        self._kernel_i = gaussian_kernel(2 * params.d).astype(np.float32)
        self._p_e, self._p_i, self._low = np.zeros((3, *shape), np.float32)
        self.now, self.before = np.zeros((2, 2, *shape), np.float32)

    def reset(self) -> None:
        """Forget the residue."""
        self.now[:] = 0.0

    def step(self, p: Floats) -> None:
        """Take P; leave the ON and OFF signals, stacked (2, R, C), in ``now`` and the last ones in ``before``."""
        self.now, self.before = self.before, self.now
        if not self._dog:
            np.maximum(p, np.float32(0.0), out=self.now[0])
            np.maximum(np.negative(p, out=self._low), np.float32(0.0), out=self.now[1])
            return
        p_e, p_i = blur(p, self._kernel_e, self._p_e), blur(p, self._kernel_i, self._p_i)
        if self._common:
            low, high = np.minimum(p_e, p_i, out=self._low), np.maximum(p_e, p_i, out=p_e)
            difference = np.subtract(high, low, out=p_i)
        else:
            low = high = p_e
            difference = np.abs(np.subtract(p_e, p_i, out=p_i), out=p_i)
        contrast = difference.view(np.int32)  # |P_e - P_i|
        on, off = self.now.view(np.int32)
        np.right_shift(low.view(np.int32), _SIGN_SHIFT, out=on)  # -1 where either is negative
        np.invert(on, out=on)
        np.bitwise_and(on, contrast, out=on)
        np.right_shift(high.view(np.int32), _SIGN_SHIFT, out=off)  # -1 where both are negative
        np.bitwise_and(off, contrast, out=off)

    def add_residue(self) -> None:
        """Add what stays of the last ON and OFF signals; apart from `step` so that LA can be read first."""
        cv2.scaleAdd(_tall(self.before), self._sigma_l, _tall(self.now), _tall(self.now))  # halfwave


class Adaptation:
    """Fast depolarising, slow repolarising adaptation of both pathways (`fdsr-lowpass`, `fdsr-subtraction`).

    Kept in the form of the high-pass that the subtraction makes of the low-pass: with
    ``g = LA - A`` unrectified, ``g(t) = (1 - alpha) (g(t-1) + LA(t) - LA(t-1))``.
    """

    def __init__(self, shape: tuple[int, int], params: DSNNParams) -> None:
        self._left_fast = 1.0 - params.alpha(params.tau_fast)
        self._left_more = np.float32(1.0 - params.alpha(params.tau_slow) - self._left_fast)
        self._rectified = params.rectified
        self._g, self._gap = np.zeros((2, 2, *shape), np.float32)
        self._zeros = np.zeros(shape[1], np.float32)  # np.maximum is slower against a scalar

    def reset(self) -> None:
        """Forget the adaptation."""
        self._g[:] = 0.0

    def step(self, la: Floats, la_before: Floats, out: Floats) -> None:
        """Take the stacked signals now and before (used up); write F into ``out``. All are (2, R, C)."""
        g = self._g
        change = np.subtract(la, la_before, out=la_before)
        gap = np.add(g, change, out=self._gap)
        falls = np.right_shift(change.view(np.int32), _SIGN_SHIFT, out=change.view(np.int32))  # -1 where it falls
        more = np.multiply(gap, self._left_more, out=g).view(np.int32)
        np.bitwise_and(more, falls, out=more)
        cv2.scaleAdd(_tall(gap), self._left_fast, _tall(g), _tall(g))
        if self._rectified:
            np.maximum(g, self._zeros, out=out)
        else:
            np.copyto(out, g)


def _tall(stack: Floats) -> Floats:
    """Return a (2, R, C) stack as one (2 R, C) image, the only rank OpenCV takes."""
    return stack.reshape(-1, stack.shape[-1])


class LobulaPlate:
    """Low-passed, squashed field sums of one system: HS or VS (`LPTCs`, `sigmoid`, `HS-VS`)."""

    def __init__(self, shape: tuple[int, int], params: DSNNParams) -> None:
        self._alpha = params.alpha(params.tau_mp)
        self._scale = shape[0] * shape[1] * params.k_sig
        self._intact = [pathway for pathway, intact in enumerate((params.on, params.off)) if intact]
        self._sums = [0.0, 0.0]

    def reset(self) -> None:
        """Forget the potentials."""
        self._sums = [0.0, 0.0]

    def step(self, field: tuple[float, float]) -> float:
        """Take the field sums of ON and OFF; return the system's potential, of the pathways left intact."""
        potential = 0.0
        for pathway in self._intact:
            self._sums[pathway] += self._alpha * (field[pathway] - self._sums[pathway])
            potential += layers.sigmoid(self._sums[pathway], self._scale)
        return potential


class NumpyNetwork:
    """The DSNN's layers in NumPy; see `dsnn.direction.network.DSNN`, which checks what goes in."""

    def __init__(self, shape: tuple[int, int], params: DSNNParams) -> None:
        self._params = params
        gains = [residue(params.u, i) for i in range(1, params.n_p + 1)]
        self._retina = Retina(shape, gains)
        self._lamina = Lamina(shape, params)
        self._fdsr = Adaptation(shape, params)
        self._correlators = Correlators(shape, params)
        self._hs, self._vs = LobulaPlate(shape, params), LobulaPlate(shape, params)
        self._columns = np.linspace(-1.0, 1.0, shape[1], dtype=np.float32)

    def reset(self) -> None:
        """Return to the state before the first frame."""
        for part in (self._retina, self._lamina, self._fdsr, self._correlators, self._hs, self._vs):
            part.reset()

    def step(self, luma: npt.NDArray[Any], maps: bool) -> Response:
        """Answer the next frame, (R, C) uint8 or floating."""
        q, lamina = self._params, self._lamina
        p = self._retina.step(luma)
        lamina.step(p)
        la = lamina.now[0] - lamina.now[1] if maps else None
        lamina.add_residue()
        if q.fdsr:
            self._fdsr.step(lamina.now, lamina.before, self._correlators.f)
        else:
            self._correlators.f[:] = lamina.now
        field_hs, field_vs = self._correlators.step()
        hs, vs = self._hs.step(field_hs), self._vs.step(field_vs)
        return Response(
            hs,
            vs,
            layers.spikes(hs, q.k_sp, q.t_sp),
            layers.spikes(vs, q.k_sp, q.t_sp),
            None if la is None else LayerMaps(p.copy(), la, *self._correlators.f.copy()),
        )

    def azimuth(self) -> float:
        """See `dsnn.direction.network.DSNN.azimuth`."""
        on, off = self._correlators.f
        energy = np.einsum("rc,rc->c", on, on) + np.einsum("rc,rc->c", off, off)
        return float(energy @ self._columns) / (float(energy.sum()) + LEAST_ENERGY)
