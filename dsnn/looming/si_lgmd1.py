"""SI-LGMD1: the LGMD1 with self-inhibition against translating motion."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.filters import Floats, Retina, alpha
from dsnn.looming.layers import Detector, convolve, ring, sigmoid
from dsnn.looming.self_inhibition import Blocks, exact, halved, truncated


@parameters
class SILGMD1Params:
    """Parameters of the SI-LGMD1, all taken from its firmware. Changes of luminance are halved."""

    tau_e: Milliseconds = 6.0
    """Delay of the excitation that inhibits laterally."""
    tau_p: Milliseconds = 4.0
    """Delay of the signal that inhibits itself."""
    beta_1: float = Field(default=0.3, ge=0.0, le=10.0)
    """Weight of lateral inhibition."""
    beta_2: float = Field(default=0.04, ge=0.0, le=10.0)
    """Share of self-inhibition that is left in a block that moves."""
    beta_3: float = Field(default=5.0, ge=0.0, le=100.0)
    """Weight of self-inhibition; 0 removes it."""
    t_az: Annotated[float, unit("halved grey levels")] = Field(default=3.0, ge=0.0, le=2550.0)
    """Sum of the changes above which a block of 3x3 cells moves."""
    t_s: Annotated[float, unit("halved grey levels")] = Field(default=3.0, ge=0.0, le=255.0)
    """Threshold of a summed cell."""
    t_ffi: Annotated[float, unit("halved grey levels")] = Field(default=10.0, ge=0.0, le=255.0)
    """Mean change of the last frame above which the model is silenced."""
    k_spi: Annotated[float, unit("halved grey levels a cell")] = Field(default=1.0, gt=0.0, le=1e3)
    """Scale of the sigmoid."""
    t_sp: float = Field(default=0.72, gt=0.5, le=1.0)
    """Spike threshold on the potential (arena: 0.65)."""
    n_sp: int = Field(default=4, ge=1, le=1000)
    """Number of consecutive spikes that signal a collision."""
    integer: bool = False
    """Whether numbers are bytes, truncated at every step; false: floating point."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, gt=0.0, le=10_000.0)
    """Frame rate."""

    @classmethod
    def presets(cls) -> Mapping[str, SILGMD1Params]:
        """Make the presets.

        ``paper`` computes the equations in floating point. ``firmware`` has the same constants in the public firmware's
        arithmetic. ``arena`` also has the firmware's T_s for the arena, 0.65.

        Returns
        -------
        mapping of str to SILGMD1Params
            Name -> parameters: ``paper``, ``firmware`` and ``arena``.
        """
        return {"paper": cls(), "firmware": cls(integer=True), "arena": cls(integer=True, t_sp=0.65)}


class SILGMD1(Detector[SILGMD1Params]):
    """Lateral inhibition, then inhibition of each cell by itself and its block, which spares blocks with much motion.

    The model follows the public firmware for Colias; the paper itself was not available. P is the change of luminance,
    halved and without its sign. E and Q are its low-passes by ``tau_e`` and ``tau_p``, and W is the ring of eight
    neighbours (1/4, 1/8). ``S' = max(P - beta_1 W * E, 0)``. ``SI`` is Q plus 1/4 of its sides and 1/8 of its corners
    within a block of 3x3 cells. It is multiplied by ``beta_2`` where P summed over the block exceeds ``t_az``. ``S = S'
    - beta_3 SI``, and 0 below ``t_s``. ``k = 1 / (1 + exp(-sum S / (k_spi N)))`` for N cells, and 0.5 where the mean P
    of the last frame exceeds ``t_ffi``. Channel: ``looming``, k from 0.5 up to 1, with one spike in a frame whose k
    reaches ``t_sp``. ``collision`` is true if the last ``n_sp`` frames all had a spike.

    Presets: ``paper``, the default, computes the equations in floating point. ``firmware`` truncates every state to a
    byte, as the robot does. There the factor ``beta_2`` is cast to a whole number before it multiplies, so that 0.04
    becomes 0. Self-inhibition then acts only where almost nothing moves, which makes this preset effectively a
    different model.

    Assumed: The paper's constants are its firmware's. Cells of the border are not summed, as in the firmware. A sum too
    large for a byte stays at 255, where the firmware wraps. Two corners that the firmware weighs 1/4 weigh 1/8 like the
    others.

    Blocks are counted from the upper left corner. So a mirrored clip gives the mirrored response if rows and columns
    are multiples of 3, as in 72x99. P is computed frame by frame, so thresholds depend on the frame rate. No published
    number was found that could be reproduced without the authors' clips.

    Costs about 5 DSNN steps at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``SILGMD1Params()``.

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
    >>> from dsnn import SILGMD1
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("looming")
    >>> series = SILGMD1(clip.shape).run(frame.luma for frame in clip)
    >>> series.accumulated_spikes("looming") > 0
    True
    """

    def __init__(self, shape: tuple[int, int], params: SILGMD1Params | None = None) -> None:
        super().__init__(shape, params, SILGMD1Params)
        q = self.params
        dt = 1000.0 / q.fps
        self._gains = [np.float32(alpha(tau, dt)) for tau in (q.tau_e, q.tau_p)]
        self._kept = truncated if q.integer else exact
        self._spared = np.float32(int(q.beta_2) if q.integer else q.beta_2)
        self._retina = Retina(self.shape)
        self._blocks = Blocks(self.shape, 1.0, 0.25, 0.125, integer=q.integer)
        self._lateral: Floats = np.zeros(self.shape, np.float32)
        self._delayed = np.zeros((2, *self.shape), np.float32)
        self._forget()

    def _forget(self) -> None:
        self._retina.reset()
        self._delayed[:] = 0.0
        self._mean_before = 0.0

    def _detect(self, luminance: npt.NDArray[Any]) -> tuple[float, int]:
        q = self.params
        p = self._kept(np.abs(halved(self._retina.step(luminance))))
        for state, gain in zip(self._delayed, self._gains, strict=True):
            state[:] = self._kept(gain * p + (np.float32(1.0) - gain) * state)
        s = self._kept(p - np.float32(q.beta_1) * self._laterally(self._delayed[0]))
        s -= np.float32(q.beta_3) * self._by_itself(p, self._delayed[1])
        s[s < np.float32(q.t_s)] = 0.0
        total = float(self._kept(s[1:-1, 1:-1]).sum(dtype=np.float64))
        silenced, self._mean_before = self._mean_before > q.t_ffi, float(p.mean(dtype=np.float64))
        k = sigmoid(0.0 if silenced else total / (q.k_spi * s.size))
        return k, int(k >= q.t_sp)

    def _laterally(self, delayed: Floats) -> Floats:
        """Compute inhibition from the eight neighbours. In the firmware each term is truncated."""
        if not self.params.integer:
            return convolve(delayed, ring(0.25, 0.125), self._lateral)
        sides = convolve(np.floor(delayed * np.float32(0.25)), ring(1.0, 0.0), self._lateral).copy()
        return sides + convolve(np.floor(delayed * np.float32(0.125)), ring(0.0, 1.0), self._lateral)

    def _by_itself(self, p: Floats, delayed: Floats) -> Floats:
        """Compute the self-inhibition of each cell by its block, which is weaker in moving blocks."""
        inhibition = self._kept(self._blocks.inhibition(self._blocks.of(delayed)))
        moves = self._blocks.of(p).sum(axis=1) > self.params.t_az
        inhibition[moves] *= self._spared
        return self._blocks.back(inhibition)
