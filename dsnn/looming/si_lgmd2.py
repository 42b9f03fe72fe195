"""SI-LGMD2: the LGMD2 with self-inhibition against translating motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.filters import Floats, Retina, alpha
from dsnn.looming.layers import Adaptation, Detector, convolve, ring, sigmoid
from dsnn.looming.self_inhibition import Blocks, exact, halved, truncated


@parameters
class SILGMD2Params:
    """Parameters of the SI-LGMD2. The defaults are its firmware's, and changes of luminance are halved."""

    tau_on: Milliseconds = 15.0
    """Delay of lateral inhibition in the ON pathway; sides twice, corners three times as long."""
    tau_off: Milliseconds = 60.0
    """Delay of lateral inhibition in the OFF pathway; sides twice, corners three times as long."""
    tau_si_on: Milliseconds = 5.0
    """Delay of self-inhibition in the ON pathway."""
    tau_si_off: Milliseconds = 20.0
    """Delay of self-inhibition in the OFF pathway."""
    w_on: float = Field(default=2.0, ge=0.0, le=10.0)
    """Weight of the inhibition by a cell itself in the ON pathway; sides 1/4, corners 1/8 of it."""
    w_off: float = Field(default=1.0, ge=0.0, le=10.0)
    """Weight of the inhibition by a cell itself in the OFF pathway; sides 1/4, corners 1/8 of it."""
    tau_pm: Milliseconds = 90.0
    """Delay of the mean change PM."""
    t_pm: Annotated[float, unit("grey levels")] = Field(default=20.0, gt=0.0, le=255.0)
    """Mean change PM above which it increases inhibition."""
    least_on: float = Field(default=1.0, ge=0.0, le=10.0)
    """Least weight of lateral inhibition in the ON pathway."""
    least_off: float = Field(default=0.5, ge=0.0, le=10.0)
    """Least weight of lateral inhibition in the OFF pathway."""
    o_on: float = Field(default=0.5, ge=0.0, le=10.0)
    """Weight of the ON pathway in the sum."""
    o_off: float = Field(default=1.0, ge=0.0, le=10.0)
    """Weight of the OFF pathway in the sum."""
    beta_1: float = Field(default=0.3, ge=0.0, le=10.0)
    """Share of self-inhibition that is left in a moving block, ON pathway."""
    beta_2: float = Field(default=0.1, ge=0.0, le=10.0)
    """Share of self-inhibition that is left in a moving block, OFF pathway."""
    beta_3: float = Field(default=3.0, ge=0.0, le=100.0)
    """Weight of self-inhibition in the ON pathway."""
    beta_4: float = Field(default=4.0, ge=0.0, le=100.0)
    """Weight of self-inhibition in the OFF pathway."""
    r_1: Annotated[float, unit("halved grey levels")] = Field(default=3.0, ge=0.0, le=2550.0)
    """Sum of a block's ON signals above which the block moves."""
    r_2: Annotated[float, unit("halved grey levels")] = Field(default=0.005, ge=0.0, le=2550.0)
    """Sum of a block's OFF signals above which the block moves."""
    c_w: float = Field(default=4.0, gt=0.0, le=1e3)
    """Divisor of the largest group in the scale of the grouping."""
    delta_c: float = Field(default=0.01, gt=0.0, le=1e3)
    """Scale of the grouping where nothing is excited."""
    t_g: float = Field(default=35.0, ge=0.0, le=1e6)
    """Threshold of the grouped excitation."""
    k_spi: Annotated[float, unit("halved grey levels a cell")] = Field(default=0.5, gt=0.0, le=1e3)
    """Scale of the sigmoid."""
    tau_sfa: Milliseconds = 500.0
    """Time constant of spike-frequency adaptation."""
    t_sfa: float = Field(default=0.003, ge=0.0, le=1.0)
    """Rise of the potential k in a frame above which nothing adapts."""
    k_sp: float = Field(default=4.0, gt=0.0, le=20.0)
    """Spike gain."""
    t_sp: float = Field(default=0.64, gt=0.5, le=1.0)
    """Spike threshold on the adapted potential."""
    n_sp: int = Field(default=4, ge=1, le=1000)
    """Number of spikes without a silent frame between them that signal a collision."""
    integer: bool = True
    """Whether numbers are bytes, truncated at every step; false: floating point."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, gt=0.0, le=10_000.0)
    """Frame rate."""

    @classmethod
    def presets(cls) -> Mapping[str, SILGMD2Params]:
        """Make the presets: T_spi is ``t_sp``, K_spi ``k_spi``, T_pm ``t_pm``.

        ``firmware`` has the public firmware's constants and arithmetic. ``paper`` has the same constants in floating
        point.

        Returns
        -------
        mapping of str to SILGMD2Params
            Name -> parameters: ``firmware`` and ``paper``.
        """
        return {"firmware": cls(), "paper": cls(integer=False)}


class _Pathway:
    """The ON or OFF pathway: its signal after lateral inhibition, and its self-inhibition."""

    def __init__(self, shape: tuple[int, int], weight: float, tau: float, tau_si: float, q: SILGMD2Params) -> None:
        dt = 1000.0 / q.fps
        # Each kernel weighs this frame by its gain and the last frame by one minus it.
        self._kernels = [
            (alpha(times * tau, dt), kernel)
            for times, kernel in ((1, ring(0, 0, weight)), (2, ring(weight / 4, 0)), (3, ring(0, weight / 8)))
        ]
        self._delay = alpha(tau_si, dt)
        self._kept = truncated if q.integer else exact
        self._blocks = Blocks(shape, 2.0 * weight, weight / 2, weight / 4, integer=q.integer)
        self._now, self._before, self._scratch = np.zeros((3, *shape), np.float32)

    def reset(self) -> None:
        self._now[:] = 0.0
        self._before[:] = 0.0

    def step(self, signal: Floats, weight: float, least: float, left: float) -> tuple[Floats, Floats]:
        """Return the inhibited signal (R, C) and the self-inhibition, times ``left`` in blocks above ``least``."""
        self._now, self._before = self._before, self._now
        self._now[:] = signal
        lateral = np.zeros_like(signal)
        for gain, kernel in self._kernels:
            lateral += convolve(self._mixed(gain), kernel, self._scratch)
        delayed = self._kept(self._mixed(self._delay))
        inhibition = self._blocks.inhibition(self._blocks.of(delayed))
        inhibition[self._blocks.of(self._now).sum(axis=1) > least] *= np.float32(left)
        return exact(signal - np.float32(weight) * self._kept(lateral)), self._blocks.back(inhibition)

    def _mixed(self, gain: float) -> Floats:
        """Mix this frame's signal, weighted by ``gain``, with the last one, weighted by one minus it."""
        return np.asarray(cv2.addWeighted(self._now, gain, self._before, 1.0 - gain, 0.0), np.float32)


class SILGMD2(Detector[SILGMD2Params]):
    """ON and OFF with lateral and self-inhibition, stronger in ON, then grouping and adaptation.

    The model follows the public firmware for Colias; the paper itself was not available. X is one polarity of the
    change of luminance, halved. Lateral inhibition of this frame and the last: ``L = sum over K of K * (a X + (1 - a)
    X(t-1))``. K runs over the cell itself, its sides and its corners (1, 1/4, 1/8 of ``w``), with a from ``tau``, twice
    and three times ``tau``. ``Y = max(X - max(least, PM / t_pm) L, 0)``, where PM is the mean change mixed with the
    last one. Self-inhibition works within blocks of 3x3 cells on X mixed likewise, with weights 2, 1/2, 1/4 of ``w``.
    It is multiplied by ``beta_1`` (ON) or ``beta_2`` (OFF) where X summed over the block exceeds ``r_1`` or ``r_2``.
    ``S = max(o_on Y_on + o_off Y_off - o_on beta_3 SI_on - o_off beta_4 SI_off, 0)``. Grouping is as in the LGMD2, with
    0 below ``t_g``. ``k = 1 / (1 + exp(-sum G / (k_spi N)))``. Spike-frequency adaptation and spikes are as in the
    LGMD2. Channel: ``looming``, the adapted potential from 0.5 up to 1. ``collision`` is true if there were ``n_sp``
    spikes since the last silent frame.

    Presets: ``firmware``, the default, truncates every state to a byte, as the robot does. There ``beta_1`` and
    ``beta_2`` are cast to whole numbers before they multiply, so that both become 0. Self-inhibition then acts only
    where almost nothing moves. ``paper`` computes the equations in floating point with the same constants. They then
    silence looming too, as they belong to the firmware's arithmetic.

    Assumed: The paper's constants are its firmware's. Cells outside the field are 0. A value too large for a byte stays
    at 255, and a negative one at 0, where the firmware wraps.

    Blocks are counted from the upper left corner. So a mirrored clip gives the mirrored response if rows and columns
    are multiples of 3, as in 72x99. P is computed frame by frame, so thresholds depend on the frame rate. No published
    number was found that could be reproduced without the authors' clips.

    Costs about 10 DSNN steps at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``SILGMD2Params()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Fu and others: Modeling self-inhibition in neural networks for collision perception against translating motion, by
    its public firmware for Colias.

    Examples
    --------
    >>> from dsnn import SILGMD2
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("looming")
    >>> series = SILGMD2(clip.shape).run(frame.luma for frame in clip)
    >>> series.accumulated_spikes("looming") > 0
    True
    """

    def __init__(self, shape: tuple[int, int], params: SILGMD2Params | None = None) -> None:
        super().__init__(shape, params, SILGMD2Params)
        q = self.params
        dt = 1000.0 / q.fps
        self._kept = truncated if q.integer else exact
        self._left = [float(int(b)) if q.integer else b for b in (q.beta_1, q.beta_2)]
        self._retina = Retina(self.shape)
        self._on = _Pathway(self.shape, q.w_on, q.tau_on, q.tau_si_on, q)
        self._off = _Pathway(self.shape, q.w_off, q.tau_off, q.tau_si_off, q)
        self._adaptation = Adaptation(q.tau_sfa, dt, q.t_sfa, q.k_sp, q.t_sp)
        self._follow = alpha(q.tau_pm, dt)
        self._forget()

    def _forget(self) -> None:
        for part in (self._retina, self._on, self._off, self._adaptation):
            part.reset()
        self._mean_before = 0.0

    def _detect(self, luminance: npt.NDArray[Any]) -> tuple[float, int]:
        q = self.params
        p = halved(self._retina.step(luminance))
        on, off = self._kept(p), self._kept(-p)
        mean = float((on + off).mean(dtype=np.float64))
        pm = self._follow * mean + (1.0 - self._follow) * self._mean_before
        self._mean_before = mean
        y_on, si_on = self._on.step(on, max(q.least_on, pm / q.t_pm), q.r_1, self._left[0])
        y_off, si_off = self._off.step(off, max(q.least_off, pm / q.t_pm), q.r_2, self._left[1])
        s = self._kept(np.float32(q.o_on) * y_on + np.float32(q.o_off) * y_off)
        s -= np.float32(q.o_on * q.beta_3) * si_on + np.float32(q.o_off * q.beta_4) * si_off
        return self._adaptation.step(self._grouped(self._kept(s)))

    def _grouped(self, s: Floats) -> float:
        """Compute the potential of clustered excitation."""
        q = self.params
        ce = self._kept(np.asarray(cv2.blur(s, (3, 3), borderType=cv2.BORDER_CONSTANT), np.float32))
        grouped = self._kept(s * ce / np.float32(q.delta_c + float(ce.max()) / q.c_w))
        grouped[grouped < np.float32(q.t_g)] = 0.0
        return sigmoid(float(grouped.sum(dtype=np.float64)) / (q.k_spi * s.size))
