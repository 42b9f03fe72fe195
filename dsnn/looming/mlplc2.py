"""The attention LPLC2: outward motion in four quadrants about the centroid of motion."""

from __future__ import annotations

from collections import deque
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.direction.local_motion import DOWN, LEFT, RIGHT, UP, LocalMotion, LocalMotionParams
from dsnn.field_docs import parameters, unit
from dsnn.filters import Floats, total
from dsnn.looming.layers import Detector, by_quadrant, sigmoid


@parameters
class MLPLC2Params(LocalMotionParams):
    """Parameters of the T4 and T5 cells, and of the quadrants."""

    leak: float = Field(default=0.01, ge=0.0, le=1.0)
    """Share of inward motion that counts (assumed)."""
    t_lplc2: float = Field(default=50.0, ge=0.0, le=1e6)
    """Summed outward motion that each quadrant needs."""
    length: Annotated[int, unit("frames")] = Field(default=5, ge=1, le=1000)
    """Number of frames that the output is summed over."""
    t_collision: float = Field(default=1000.0, gt=0.0, le=1e9)
    """Summed output that signals a collision."""
    n_sp: int = Field(default=1, ge=1, le=1000)
    """Number of consecutive spikes that signal a collision."""

    @property
    def t_sp(self) -> float:
        """The spike threshold on the potential, at a summed output of ``t_collision``."""
        return sigmoid(1.0)


class MLPLC2(Detector[MLPLC2Params]):
    """Outward motion in all four quadrants about the centroid of motion, on T4 and T5 cells.

    This is the attention LPLC2 (mLPLC2). Local motion is as in `dsnn.T4T5`. Attention: the centre is the centroid of
    ``sqrt((right + left)^2 + (down + up)^2)``. Each of the four quadrants about it sums ``LeakyReLU(outward - inward)``
    of its two axes. If all four reach ``t_lplc2`` the output is their sum, otherwise 0, summed over the last ``length``
    frames. Channel: ``looming``, ``1 / (1 + exp(-output / t_collision))`` from 0.5 up to 1, with one spike in a frame
    whose output reaches ``t_collision``. ``collision`` is true if the last ``n_sp`` frames all had a spike.

    Assumed where the source leaves it open: There is one attention field, and its quadrants are as large as the field.
    A column or row that contains the centre counts to both sides by its share. The slope ``leak`` and the sigmoid are
    our choice. The output is the sum of the quadrants: four quadrants at 50 in five frames make exactly the published
    1000. Sums scale with the size of the image, and the source has larger images.

    The normalisation amplifies anything that stands out by a few tenths of a grey level to its full height. With the
    robot's camera noise, of 1.3 grey levels standard deviation, the model spikes in every frame; the source's videos
    have no noise. No published number was found that could be reproduced without the authors' clips.

    Costs about 16 DSNN steps (0.6 ms) at 99x72.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``MLPLC2Params()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Liu and Fu 2025, arXiv 2504.04477.

    Examples
    --------
    >>> from dsnn import MLPLC2
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("looming")
    >>> series = MLPLC2(clip.shape).run(frame.luma for frame in clip)
    >>> series.accumulated_spikes("looming") > 0
    True
    """

    def __init__(self, shape: tuple[int, int], params: MLPLC2Params | None = None) -> None:
        super().__init__(shape, params, MLPLC2Params)
        q = self.params
        self._local = LocalMotion(self.shape, q)
        self._rows, self._columns = (np.arange(n, dtype=np.float64) for n in self.shape)
        self._outputs: deque[float] = deque(maxlen=q.length)
        self._forget()

    def _forget(self) -> None:
        self._local.reset()
        self._outputs.clear()

    @property
    def local_motion(self) -> Floats:
        """What T4 and T5 cells respond to the last frame, (R, C, 2), right and down positive, in no unit of length."""
        return self._local.field()

    def _detect(self, luminance: npt.NDArray[Any]) -> tuple[float, int]:
        q = self.params
        quadrants = self._quadrants(self._local.step(luminance))
        self._outputs.append(float(quadrants.sum()) if quadrants.min() >= q.t_lplc2 else 0.0)
        summed = sum(self._outputs)
        return sigmoid(summed / q.t_collision), int(summed >= q.t_collision)

    def _quadrants(self, motion: Floats) -> npt.NDArray[np.float64]:
        """Sum outward motion in the quadrants about the centroid of motion, (2, 2): upper and lower, left and right."""
        across, down = motion[RIGHT] + motion[LEFT], motion[DOWN] + motion[UP]
        size = np.sqrt(across * across + down * down)  # OpenCV's magnitude differs in its last bits from call to call
        weight = total(size)
        if weight <= 0.0:
            return np.zeros((2, 2))
        by_row, by_column = size.sum(axis=1, dtype=np.float64), size.sum(axis=0, dtype=np.float64)
        above, right = (
            np.clip(sign * (places - (places * weights).sum() / weight) + 0.5, 0.0, 1.0)
            for places, weights, sign in ((self._rows, by_row, -1.0), (self._columns, by_column, 1.0))
        )
        rows, columns = np.stack([above, 1.0 - above]), np.stack([1.0 - right, right])
        x, y = motion[RIGHT] - motion[LEFT], motion[DOWN] - motion[UP]
        leak = np.float32(self.params.leak)
        leaky = [np.maximum(component, leak * component) for component in (-x, x, -y, y)]
        return by_quadrant(leaky[:2], leaky[2:], rows, columns)
