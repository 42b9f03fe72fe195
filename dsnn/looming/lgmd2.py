"""LGMD2, the locust's detector of dark looming objects in the form of Fu, Hu and Yue (2018)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.filters import Floats, Retina, States, alpha, total
from dsnn.looming.layers import Adaptation, Detector, Grouping, convolve, ring

Ring = tuple[float, float, float]
Delays = tuple[Milliseconds, Milliseconds, Milliseconds]


@parameters
class LGMD2Params:
    """Parameters of the LGMD2. The defaults are the literature's, and thresholds are in 8-bit grey levels.

    Triples hold the values of a cell itself, of each of its four sides and of each of its four corners.
    """

    sigma: float = Field(default=0.1, ge=0.0, lt=1.0)
    """Residue of the ON and OFF signals."""
    w_on: Ring = (2.0, 0.5, 0.25)
    """Weights of inhibition in the ON pathway: centre, side, corner."""
    w_off: Ring = (1.0, 0.25, 0.125)
    """Weights of inhibition in the OFF pathway: centre, side, corner."""
    tau_on: Delays = (15.0, 30.0, 45.0)
    """Delays of inhibition in the ON pathway: centre, side, corner."""
    tau_off: Delays = (60.0, 120.0, 180.0)
    """Delays of inhibition in the OFF pathway: centre, side, corner."""
    tau_pm: Milliseconds = 90.0
    """Time constant of the low-pass of the mean change PM."""
    t_pm: Annotated[float, unit("grey levels")] = Field(default=8.0, gt=0.0, le=255.0)
    """Mean change PM above which it increases inhibition."""
    least_on: float = Field(default=1.0, ge=0.0, le=10.0)
    """Least weight of inhibition in the ON pathway."""
    least_off: float = Field(default=0.5, ge=0.0, le=10.0)
    """Least weight of inhibition in the OFF pathway."""
    c_w: float = Field(default=4.0, gt=0.0, le=1e3)
    """Divisor of the largest group in the scale of the grouping."""
    delta_c: float = Field(default=0.01, gt=0.0, le=1e3)
    """Scale of the grouping where nothing is excited."""
    c_g: float = Field(default=0.5, gt=0.0, le=10.0)
    """Decay of the grouped excitation before its threshold."""
    t_g: float = Field(default=15.0, ge=0.0, le=1e6)
    """Threshold of the grouped excitation after its decay."""
    tau_sfa: Milliseconds = 800.0
    """Time constant of spike-frequency adaptation."""
    t_sfa: float = Field(default=0.003, ge=0.0, le=1.0)
    """Rise of the potential k in a frame above which nothing adapts."""
    k_sp: float = Field(default=4.0, gt=0.0, le=20.0)
    """Spike gain."""
    t_sp: float = Field(default=0.78, gt=0.5, le=1.0)
    """Spike threshold on the adapted potential."""
    n_sp: int = Field(default=8, ge=1, le=1000)
    """Number of spikes without a silent frame between them that signal a collision."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, gt=0.0, le=10_000.0)
    """Frame rate."""

    @classmethod
    def presets(cls) -> Mapping[str, LGMD2Params]:
        """Make the presets.

        ``paper`` has the literature's constants. ``firmware`` has the two published constants of the ON/OFF-competing
        LGMD2 on Colias: its spike threshold 0.63 is ``t_sp``, and its T_pm 8, also the paper's, is ``t_pm``.

        Returns
        -------
        mapping of str to LGMD2Params
            Name -> parameters: ``paper`` and ``firmware``.
        """
        return {"paper": cls(), "firmware": cls(t_sp=0.63, t_pm=8.0)}


class Pathway:
    """The ON or OFF pathway: its signal, and the inhibition by centre, sides and corners, each with its own delay."""

    def __init__(self, shape: tuple[int, int], weights: Ring, taus: Ring, sigma: float, dt: float) -> None:
        self._sigma, self._centre = sigma, weights[0]
        self._kernels = ring(weights[1], 0.0), ring(0.0, weights[2])
        self._alphas = [alpha(tau, dt) for tau in taus]
        states = np.zeros((4, *shape), np.float32)
        self.signal, *self._delayed = states
        self._states = States(states)
        self._scratch, self._zeros, self._s = np.zeros((3, *shape), np.float32)

    def reset(self) -> None:
        """Forget the signal and its delayed copies."""
        self._states.reset()

    def step(self, rectified: Floats, weight: float) -> Floats:
        """Return max(P, 0) or max(-P, 0) minus ``weight`` times its inhibition; valid until the next step."""
        cv2.scaleAdd(self.signal, self._sigma, rectified, self.signal)
        for state, a in zip(self._delayed, self._alphas, strict=True):
            cv2.accumulateWeighted(self.signal, state, a)
        centre, sides, corners = self._delayed
        cv2.scaleAdd(centre, -weight * self._centre, self.signal, self._s)
        for kernel, delayed in zip(self._kernels, (sides, corners), strict=True):
            cv2.scaleAdd(convolve(delayed, kernel, self._scratch), -weight, self._s, self._s)
        self._states.count()
        return np.maximum(self._s, self._zeros, out=self._s)


class LGMD2(Detector[LGMD2Params]):
    """Separate inhibition of ON and OFF, so strong in ON that bright looming is lost, then grouping and adaptation.

    Each pathway takes one sign of the change of luminance P, plus ``sigma`` of its last signal. It loses ``w`` times
    its inhibition: itself and its eight neighbours, low-passed. The weights follow the low-passed mean change PM, ``w =
    max(least, PM / t_pm)``. ``S = S_on + S_off + S_on S_off`` is grouped as in `dsnn.LGMD1`, except that ``c_g G`` must
    reach ``t_g``. This gives k. Spike-frequency adaptation follows, with ``h = tau_sfa / (tau_sfa + dt)`` and dk the
    change of k: ``s = h (s(t-1) + dk)`` where dk is at most ``t_sfa``, otherwise ``h k``; s is at least 0.5. Channel:
    ``looming``, s from 0.5 up to 1, with ``floor(exp(k_sp (s - t_sp)))`` spikes. ``collision`` is true if there were
    ``n_sp`` spikes since the last silent frame.

    Assumed where the source leaves it open: There is no spatial filter before the split, and no residue of older
    changes in P. Cells outside the field are 0. A delayed signal includes this frame. PM includes this frame's P. The
    decay ``c_g`` only affects the threshold; k sums G. A silent frame ends the count of a collision. P is computed
    frame by frame, so thresholds depend on frame rate and image size.

    Costs about 1.7 DSNN steps at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``LGMD2Params()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Fu, Hu and Yue 2018, arXiv 1801.06452.

    Examples
    --------
    >>> from dsnn import LGMD2
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("looming")
    >>> series = LGMD2(clip.shape).run(frame.luma for frame in clip)
    >>> series.accumulated_spikes("looming") > 0
    True
    """

    def __init__(self, shape: tuple[int, int], params: LGMD2Params | None = None) -> None:
        super().__init__(shape, params, LGMD2Params)
        q = self.params
        dt = 1000.0 / q.fps
        self._retina = Retina(self.shape)
        self._on = Pathway(self.shape, q.w_on, q.tau_on, q.sigma, dt)
        self._off = Pathway(self.shape, q.w_off, q.tau_off, q.sigma, dt)
        self._grouping = Grouping(self.shape, q.c_w, q.delta_c, q.t_g / q.c_g)
        self._rises, self._falls, self._s, self._zeros = np.zeros((4, *self.shape), np.float32)
        self._adaptation = Adaptation(q.tau_sfa, dt, q.t_sfa, q.k_sp, q.t_sp)
        self._follow = alpha(q.tau_pm, dt)
        self._forget()

    def _forget(self) -> None:
        for part in (self._retina, self._on, self._off, self._adaptation):
            part.reset()
        self._pm = 0.0

    def _detect(self, luminance: npt.NDArray[Any]) -> tuple[float, int]:
        q = self.params
        p = self._retina.step(luminance)
        rises = np.maximum(p, self._zeros, out=self._rises)
        falls = np.subtract(rises, p, out=self._falls)
        self._pm += self._follow * (total(np.abs(p)) / p.size - self._pm)
        on = self._on.step(rises, max(q.least_on, self._pm / q.t_pm))
        off = self._off.step(falls, max(q.least_off, self._pm / q.t_pm))
        s = np.multiply(on, off, out=self._s)
        s += on
        s += off
        return self._adaptation.step(self._grouping.potential(s))
