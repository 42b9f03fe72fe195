"""LPLC2 cells and the giant fibre: EMDs, an array of LPLC2 cells, and an integrate-and-fire neuron."""

from __future__ import annotations

import dataclasses
from typing import Annotated, Any

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.exponential import exp
from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.filters import FACTOR, Floats, Retina, States, alpha
from dsnn.looming.layers import REST, Detector

PAPER_FOCAL_PX, ROBOT_FOCAL_PX = 60.0, 70.7
"""Focal lengths in px: the paper's 200x150 frames (240 on a screen of 800x600), and the robot's camera."""
FITTING_SIDE = 60
"""Largest side of the paper's receptive fields (40 to 100 px of its frames) that fits into the robot's 72 rows."""


@parameters
class LPLC2GFParams:
    """Parameters of the LPLC2 with giant fibre. The defaults are the literature's, for frames of 200x150 px."""

    tau_hp: Milliseconds = 250.0
    """Time constant of the luminance's temporal high-pass."""
    tau_lp: Milliseconds = 50.0
    """Delay of a detector's arm."""
    t_off: float = Field(default=0.05, ge=0.0, le=1.0)
    """Threshold of the OFF signal, for a luminance of 0..1."""
    side: Annotated[int, unit("px")] = Field(default=100, ge=2, le=1000)
    """Side of a receptive field, an even number; two arms long."""
    width: Annotated[int, unit("px")] = Field(default=40, ge=2, le=1000)
    """Width of a receptive field's arms, an even number."""
    t_arm: float = Field(default=2.0, ge=0.0, le=1e6)
    """Summed outward motion that each arm of a receptive field needs."""
    rate: Annotated[float, unit("1/s")] = Field(default=57.6, gt=0.0, le=1e9)
    """Rise of the share of active cells that counts as 1 (the authors' program)."""
    gain: float = Field(default=250.0, ge=0.0, le=1e9)
    """Current for a share of active cells of 1 that rises at a rate of 1."""
    tau_m: Milliseconds = 300.0
    """Time constant of the membrane."""
    r_m: Annotated[float, unit("mV for a current of 1")] = Field(default=10.0, gt=0.0, le=1e6)
    """Resistance of the membrane."""
    v_rest: Annotated[float, unit("mV")] = Field(default=-60.0, ge=-200.0, le=200.0)
    """Resting potential."""
    v_th: Annotated[float, unit("mV")] = Field(default=-50.0, ge=-200.0, le=200.0)
    """Spike threshold of the membrane potential."""
    v_reset: Annotated[float, unit("mV")] = Field(default=-70.0, ge=-200.0, le=200.0)
    """Potential after a spike."""
    v_spike: Annotated[float, unit("mV")] = Field(default=20.0, ge=-200.0, le=200.0)
    """Potential of a spike."""
    substeps: int = Field(default=20, ge=1, le=10_000)
    """Steps of the membrane's equation in 10 ms."""
    n_sp: int = Field(default=1, ge=1, le=1000)
    """Number of spikes that signal a collision."""
    fps: Annotated[float, unit("frames/s")] = Field(default=100.0, gt=0.0, le=10_000.0)
    """Frame rate."""

    def __post_init__(self) -> None:
        if not self.v_rest < self.v_th < self.v_spike:
            between = f"v_rest, {self.v_rest:g}, and v_spike, {self.v_spike:g}"
            raise ValueError(f"v_th must be between {between}, got {self.v_th:g}")

    @classmethod
    def robot(cls, **changes: Any) -> LPLC2GFParams:
        """Make the parameters for the robot's camera (99x72 px, 70 degrees, 30 frames/s) with equal angles.

        Lengths in px scale with the focal length. The receptive field is the largest of the paper's that fits into the
        camera's view, 53 degrees.

        Parameters
        ----------
        **changes
            Other values of parameters, by name.

        Returns
        -------
        LPLC2GFParams
            The parameters.

        Raises
        ------
        pydantic.ValidationError
            A value is out of range, or the parameter is unknown.
        """
        across = ROBOT_FOCAL_PX / PAPER_FOCAL_PX
        side, width = (2 * round(px * across / 2) for px in (FITTING_SIDE, cls().width))
        params = cls(side=side, width=width, t_arm=2.0 * across, fps=30.0)
        return dataclasses.replace(params, **changes)

    @property
    def n_max(self) -> float:
        """Number of active cells with a share of 1: the most that a centred square activates, 2500 for 50 px arms."""
        return (self.side / 2) ** 2

    @property
    def t_sp(self) -> float:
        """The spike threshold on the potential of the response, which corresponds to ``v_th``."""
        return REST + 0.5 * (self.v_th - self.v_rest) / (self.v_spike - self.v_rest)


class LPLC2GF(Detector[LPLC2GFParams]):
    """Cells that multiply outward motion on four arms, and a giant fibre driven by the active cells' number and rise.

    Luminance from 0 to 1 is high-passed by ``tau_hp``: ``ON = max(h, 0)``, ``OFF = max(-h - t_off, 0)``. Let x and y be
    neighbours one px apart, and D the low-pass by ``tau_lp``. Motion from x to y is ``D(x) X(y)``, and from y to x
    ``X(x) D(y)``, with ON and OFF added. A cell at each corner between four pixels sums opponent motion, outward minus
    inward, over four arms. The arms are ``side / 2`` px long and ``width`` px wide. The cell is active if all four
    exceed ``t_arm`` (the product of the arms is above 0). Let n be the number of active cells as a share of the most
    that a centred square can activate, ``(side / 2)^2`` (2500 in the paper). The giant fibre receives ``I = gain n
    (dn/dt) / rate``, and 0 where the last n was 0. ``tau_m dV/dt = v_rest - V + r_m I``, with a spike at ``v_th``, then
    ``v_reset``. Channel: ``looming``, V mapped linearly from 0.5 at ``v_rest`` and below to 1 at ``v_spike``, and the
    number of spikes. The potential is 1 in a frame with spikes. ``collision`` is true if there were ``n_sp`` spikes
    since the last frame without one.

    The defaults are the published form for 100 frames/s. The preset ``robot`` has the same angles for the robot's
    camera at 30 frames/s, with the same constants in ms. The rise of n is then measured over a longer step.

    Reproduced: the authors show a black square of l / v = 5 ms at 100 frames/s. They count 676 and 2116 active cells,
    squares of 26 and 46, in the last two frames. From these numbers their public program computes the divisor of dn/dt,
    ``rate``: (2116 - 676) / 2500 in 10 ms, the rise at the end of the approach. Here the counts are 625 and 2025,
    squares of 25 and 45, as a row has one corner less than pixels (tests/dsnn/test_looming_models.py).

    Assumed where the source leaves it open: Cells lie at the corners between pixels, so that a mirrored picture gives
    the mirrored response. ``t_off`` is subtracted; one of the authors' programs adds it, which turns their 676 into
    417. Nothing moves beyond the border. For another focal length the threshold of an arm scales with the length of an
    edge. A negative current acts, as in the source. The membrane is integrated exactly over each substep.

    Costs about 7 DSNN steps at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``LPLC2GFParams()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Zhao, Xi, Li, Guo and Wu 2023, iScience 26:106337 (PMC10073940).

    Examples
    --------
    >>> from dsnn import LPLC2GF, LPLC2GFParams
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("looming")
    >>> series = LPLC2GF(clip.shape, LPLC2GFParams.robot()).run(frame.luma for frame in clip)
    >>> series.accumulated_spikes("looming") > 0
    True
    """

    def __init__(self, shape: tuple[int, int], params: LPLC2GFParams | None = None) -> None:
        super().__init__(shape, params, LPLC2GFParams)
        q = self.params
        self._dt = 1000.0 / q.fps
        self._passed, self._delay = np.float32(1.0 - alpha(q.tau_hp, self._dt)), alpha(q.tau_lp, self._dt)
        self._substeps = max(1, round(q.substeps * self._dt / 10.0))
        self._decay = exp(-self._dt / self._substeps / q.tau_m) if q.tau_m else 0.0
        self._retina = Retina(self.shape)
        self._h = np.zeros(self.shape, np.float32)
        self._delayed = np.zeros((2, *self.shape), np.float32)
        self._states = States(self._h, self._delayed, every=16, floor=FACTOR)
        self._forget()

    def _forget(self) -> None:
        self._retina.reset()
        self._states.reset()
        self._share_before = 0.0
        self._v = self.params.v_rest

    def _detect(self, luminance: npt.NDArray[Any]) -> tuple[float, int]:
        q = self.params
        share = self.active_cells(luminance) / q.n_max
        rise = (share - self._share_before) / self._dt * 1000.0 / q.rate
        current = q.gain * share * rise if self._share_before > 0.0 else 0.0
        self._share_before = share
        spikes = self._integrate(current)
        v = q.v_spike if spikes else self._v
        return REST + 0.5 * max(v - q.v_rest, 0.0) / (q.v_spike - q.v_rest), spikes

    def active_cells(self, luminance: npt.NDArray[Any]) -> int:
        """Process the next frame and count the active cells.

        Parameters
        ----------
        luminance
            The frame, (R, C), grey levels.

        Returns
        -------
        int
            The number of active cells.
        """
        self._h += self._retina.step(luminance) * np.float32(1.0 / 255.0)
        self._h *= self._passed
        horizontal = np.zeros((self.shape[0], self.shape[1] - 1), np.float32)
        vertical = np.zeros((self.shape[0] - 1, self.shape[1]), np.float32)
        off = -self._h - np.float32(self.params.t_off)
        for signal, d in zip((self._h, off), self._delayed, strict=True):
            x = np.maximum(signal, np.float32(0.0))
            cv2.accumulateWeighted(x, d, self._delay)
            horizontal += d[:, :-1] * x[:, 1:] - x[:, :-1] * d[:, 1:]
            vertical += d[:-1] * x[1:] - x[:-1] * d[1:]
        self._states.count()
        return int(np.count_nonzero(self._arms(horizontal) & self._arms(vertical.T).T))

    def _arms(self, motion: Floats) -> npt.NDArray[np.bool_]:
        """Find cells, (R - 1, C - 1), whose two arms along opponent motion, (R, C - 1), exceed the threshold."""
        q = self.params
        length, width = q.side // 2, q.width // 2
        rows, columns = motion.shape
        sums = np.zeros((rows + 1, columns + 1), np.float64)
        np.cumsum(np.cumsum(motion, axis=0, dtype=np.float64), axis=1, out=sums[1:, 1:])
        top, bottom = _clipped(np.arange(1, rows), -width, width, rows)
        band = sums[bottom] - sums[top]
        # Detector c lies at column c + 1/2, as the cell of column c does: it belongs to neither arm.
        (near, far), (back, ahead) = (
            _clipped(np.arange(columns), *ends, columns) for ends in ((1, length + 1), (-length, 0))
        )
        outward = band[:, far] - band[:, near], -(band[:, ahead] - band[:, back])
        return np.asarray((outward[0] > q.t_arm) & (outward[1] > q.t_arm))

    def _integrate(self, current: float) -> int:
        """Integrate the giant fibre over one frame; return the number of its spikes."""
        q, spikes = self.params, 0
        aim = q.v_rest + q.r_m * current
        for _ in range(self._substeps):
            self._v = aim + (self._v - aim) * self._decay
            if self._v > q.v_th:
                self._v = q.v_reset
                spikes += 1
        return spikes


def _clipped(
    places: npt.NDArray[np.int_], before: int, after: int, most: int
) -> tuple[npt.NDArray[np.int_], npt.NDArray[np.int_]]:
    """Return both ends of an interval about each place, clipped to 0 .. most."""
    return np.clip(places + before, 0, most), np.clip(places + after, 0, most)
