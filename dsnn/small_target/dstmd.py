"""DSTMD, the directionally selective small-target motion detector."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated, Any, ClassVar

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import Milliseconds, parameters, unit
from dsnn.filters import Floats
from dsnn.model import Response
from dsnn.small_target.layers import SmallTargetModel, SmallTargetParams, strongest

DIRECTIONS = 8
TURNS = np.arange(DIRECTIONS) * 2.0 * math.pi / DIRECTIONS
"""Preferred directions, radians: rightward, then towards downward."""
CENTRE, SURROUND = 1.5, 3.0
"""Standard deviations of the inhibition between directions, in its own unit: it is 0 at a right angle (toolkit)."""


@parameters
class DSTMDParams(SmallTargetParams):
    """Parameters of the DSTMD: those of the shared layers, its distance and its delays."""

    spacing: Annotated[int, unit("px")] = Field(default=3, ge=1, le=64)
    """Distance between the two pixels of a detector (toolkit: 3)."""
    tau_on: Milliseconds = Field(default=15.0, gt=0.0)
    """Time constant of the Gamma filter of order 3 that delays ON of the first pixel (toolkit: 15 frames)."""
    tau_off: Milliseconds = Field(default=25.0, gt=0.0)
    """Time constant of the Gamma filter of order 5 that delays OFF of the second pixel (toolkit: 25 frames)."""
    tau_first: Milliseconds = Field(default=40.0, gt=0.0)
    """Time constant of the Gamma filter of order 8 that delays OFF of the first pixel (toolkit: 40 frames)."""


class DSTMD(SmallTargetModel[DSTMDParams]):
    """ESTMDs in pairs: a dark target passes a first pixel, then a second one at a distance, in one of 8 directions.

    ON and OFF are those of `dsnn.ESTMD` before inhibition. With a the first pixel and b the second, ``spacing`` px from
    a in the preferred direction, the correlation is ``ON(b) [G_5,off * OFF(b) + G_3,on * ON(a)] (G_8,first * OFF(a))``.
    Pixels less than ``spacing`` from the border have none. It loses what surrounds it, as the ESTMD's signals do. The
    directions then inhibit each other by a difference of Gaussians: those within a right angle add to a direction, the
    others subtract. Channels: ``target``, the strongest response of any direction, in cubed grey levels; ``azimuth``
    and ``elevation``, where it is; ``target_direction``, that of the sum over directions of unit vectors times
    responses there, from -180 to 180 degrees: 0 rightward, 90 downward. There are no spikes.

    Assumed: as for `dsnn.ESTMD`.

    Costs about 50 DSNN steps (2.5 ms) at 99x72, most of it for surround inhibition, once for each direction.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    params
        The constants; by default ``DSTMDParams()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.

    References
    ----------
    Wang, Peng and Yue 2018, IEEE Transactions on Cybernetics 50:1541 (arXiv 1801.06687); constants as in the toolkit
    Small-Target-Motion-Detectors.

    Examples
    --------
    >>> from dsnn import DSTMD, DSTMDParams
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("target", background="even", background_speed=0.0, speed=200.0, fps=500.0, duration_s=0.4)
    >>> series = DSTMD(clip.shape, DSTMDParams(fps=500.0)).run(frame.luma for frame in clip)
    >>> bool(abs(series.target_direction[100]) < 22.5)  # rightward, within half a sector
    True
    """

    DELAYS: ClassVar = {"tau_on": 3, "tau_off": 5, "tau_first": 8}

    def __init__(self, shape: tuple[int, int], params: DSTMDParams | None = None) -> None:
        super().__init__(shape, params, DSTMDParams)
        spacing = self.params.spacing
        self._ahead = [(round(spacing * math.sin(turn)), round(spacing * math.cos(turn))) for turn in TURNS]
        self._inside = np.zeros(self.shape, np.float32)
        self._inside[spacing:-spacing, spacing:-spacing] = 1.0
        self._weights = between_directions()

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        on, off = self._polarities(luminance)
        on_a, off_b, off_a = (delay.step(x) for delay, x in zip(self._delays, (on, off, off), strict=True))
        behind = ((np.roll(on_a, shift, (0, 1)), np.roll(off_a, shift, (0, 1))) for shift in self._ahead)
        responses = [self._inhibited(self._inside * on * (off_b + x) * y) for x, y in behind]
        combined = np.tensordot(self._weights, np.stack(responses), axes=1)
        found, (row, column) = strongest(combined.max(axis=0))
        if not found.target:
            return found
        there = np.maximum(combined[:, row, column], 0.0)
        direction = math.degrees(math.atan2(there @ np.sin(TURNS), there @ np.cos(TURNS)))
        return replace(found, target_direction=direction)


def between_directions() -> Floats:
    """Make the weights between directions, (8, 8): by rows, how each direction counts for one.

    The difference of Gaussians is sampled at its zero for a right angle, at half of that for half a right angle, and
    beyond in steps of the distance from the zero to the minimum. The opposite direction counts from both sides.
    """
    zero = math.sqrt(2.0 * math.log(SURROUND / CENTRE) / (CENTRE**-2 - SURROUND**-2))
    places = zero * np.array([0.0, 0.5, 1.0, math.sqrt(3.0), 2.0 * math.sqrt(3.0) - 1.0])
    one, other = (np.exp(-(places**2) / (2.0 * s * s)) / (math.sqrt(2.0 * math.pi) * s) for s in (CENTRE, SURROUND))
    by_angle = (one - other) * [1.0, 1.0, 0.0, 1.0, 2.0]
    apart = np.abs(np.subtract.outer(np.arange(DIRECTIONS), np.arange(DIRECTIONS)))
    return np.asarray(by_angle[np.minimum(apart, DIRECTIONS - apart)], np.float32)
