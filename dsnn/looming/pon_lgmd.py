"""The P-ON/OFF LGMD: looming detection with motion normalised by contrast."""

from __future__ import annotations

from typing import Annotated, Any

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.filters import Floats, Retina, total
from dsnn.looming.layers import REST, Detector, below, ring, sigmoid


@parameters
class PONLGMDParams:
    """Parameters of the P-ON/OFF LGMD. The defaults are the literature's, except for the spike thresholds."""

    alpha_1: Annotated[float, unit("grey levels")] = Field(default=3.0, gt=0.0, le=255.0)
    """Baseline of the normalisation."""
    gauss_size: Annotated[int, unit("px")] = Field(default=9, ge=3, le=63)
    """Side of the normalisation's surround; even: the next odd number."""
    gauss_div: Annotated[float, unit("px")] = Field(default=5.0, gt=0.0, le=100.0)
    """Sigma of the normalisation's surround."""
    beta: float = Field(default=0.4, ge=0.0, le=10.0)
    """Weight of lateral inhibition."""
    w_side: float = Field(default=0.25, ge=0.0, le=10.0)
    """Weight of the inhibition from each of a cell's four sides."""
    w_corner: float = Field(default=0.125, ge=0.0, le=10.0)
    """Weight of the inhibition from each of a cell's four corners."""
    alpha_c: float = Field(default=1.0, ge=0.0, le=10.0)
    """Weight of contrast, which is subtracted from motion."""
    theta_3: float = Field(default=1.0, ge=0.0, le=10.0)
    """Weight of the product of ON and OFF."""
    c_w: float = Field(default=4.0, gt=0.0, le=1e3)
    """Divisor of the largest group in the scale of the grouping."""
    delta_c: float = Field(default=0.01, gt=0.0, le=1e3)
    """Scale of the grouping where nothing is excited."""
    c_de: float = Field(default=0.5, gt=0.0, le=10.0)
    """Decay of the grouped excitation."""
    t_de: float = Field(default=0.7, ge=0.0, le=1e3)
    """Threshold of the decayed excitation."""
    k_sig: float = Field(default=0.1, gt=0.0, le=1e3)
    """Scale of the sigmoid, as a share of the number of cells."""
    t_sp: float = Field(default=0.55, gt=0.5, le=1.0)
    """Spike threshold on the potential (assumed)."""
    n_sp: int = Field(default=5, ge=1, le=1000)
    """Number of consecutive spikes that signal a collision (assumed: LGMD1's)."""


class PONLGMD(Detector[PONLGMDParams]):
    """Normalised changes of luminance, minus delayed lateral inhibition and local contrast, then grouping.

    For each polarity X of the change of luminance, with G a Gaussian, ``M = tanh(X / (G * X + alpha_1))``. The contrast
    is ``C = |M - mean of its 8 neighbours|``. ``S_x = max(M - beta K * M(t-1) - alpha_c C, 0)``, where K is the ring of
    the eight neighbours. ``S = S_on + S_off + theta_3 S_on S_off``. With Ce the 3x3 mean of S, ``G = S Ce / (delta_c +
    max Ce / c_w)``, and 0 where ``c_de G`` is below ``t_de``. ``k = 1 / (1 + exp(-sum G / (k_sig N)))`` for N cells.
    Channel: ``looming``, k from 0.5 up to 1, with one spike in a frame whose k reaches ``t_sp``. ``collision`` is true
    if the last ``n_sp`` frames all had a spike.

    Each polarity is divided by its own Gaussian, as in the authors' public program. A secondary account of their text
    uses the Gaussian of the whole change, ``|P|``; the text itself was not available. The two differ where ON and OFF
    are within ``gauss_size / 2`` px of each other, and agree for an object on an even ground.

    Assumed where the source leaves it open: The picture is mirrored at the border, which is the default of the authors'
    filters. The source gives no threshold, so a spike occurs where the potential has risen by a tenth of its range.

    There is no time constant: the model works frame by frame. P, and so every threshold, depends on the frame rate. No
    published number was found that could be reproduced without the authors' clips.

    Costs about 2.6 DSNN steps at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``PONLGMDParams()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Fu and Li 2022: Harmonizing motion and contrast vision for robust looming detection.

    Examples
    --------
    >>> from dsnn import PONLGMD
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("looming")
    >>> series = PONLGMD(clip.shape).run(frame.luma for frame in clip)
    >>> series.accumulated_spikes("looming") > 0
    True
    """

    def __init__(self, shape: tuple[int, int], params: PONLGMDParams | None = None) -> None:
        super().__init__(shape, params, PONLGMDParams)
        q = self.params
        self._retina = Retina(self.shape)
        self._surround = cv2.getGaussianKernel(q.gauss_size | 1, q.gauss_div, cv2.CV_32F)
        self._neighbours = ring(-0.125, -0.125, 1.0)
        self._inhibiting = ring(q.w_side, q.w_corner)
        self._below = below(q.t_de / q.c_de)
        self._motion_before = np.zeros((2, *self.shape), np.float32)
        self._forget()

    def _forget(self) -> None:
        self._retina.reset()
        self._motion_before[:] = 0.0

    def _detect(self, luminance: npt.NDArray[Any]) -> tuple[float, int]:
        q = self.params
        p = self._retina.step(luminance)
        on, off = (self._pathway(np.maximum(x, np.float32(0.0)), self._motion_before[i]) for i, x in enumerate((p, -p)))
        k = self._grouped(on + off + np.float32(q.theta_3) * on * off)
        return k, int(k >= q.t_sp)

    def _pathway(self, change: Floats, before: Floats) -> Floats:
        """Compute one polarity's signal S_x; ``before`` is its last motion signal, and is updated in place."""
        q = self.params
        motion = np.tanh(change / (cv2.sepFilter2D(change, -1, self._surround, self._surround) + np.float32(q.alpha_1)))
        contrast = np.abs(cv2.filter2D(motion, -1, self._neighbours))
        s = motion - np.float32(q.beta) * cv2.filter2D(before, -1, self._inhibiting) - np.float32(q.alpha_c) * contrast
        before[:] = motion
        return np.asarray(np.maximum(s, np.float32(0.0)), np.float32)

    def _grouped(self, s: Floats) -> float:
        q = self.params
        ce = cv2.blur(s, (3, 3))
        most = float(ce.max())
        if most == 0.0:
            return REST
        grouped = cv2.multiply(s, ce, scale=1.0 / (q.delta_c + most / q.c_w))
        cv2.threshold(grouped, self._below, 0.0, cv2.THRESH_TOZERO, dst=grouped)
        return sigmoid(total(grouped) / (q.k_sig * s.size))
