"""Random dots of which a given share moves coherently."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.moving import DIRECTIONS, Direction
from dsnn.stimuli.stimulus import Luma, StimulusFrame, TimedParams, TimedStimulus, Truth
from dsnn.stimuli.streams import stream

Floats = npt.NDArray[np.float64]


@parameters
class DotsParams(TimedParams):
    """Parameters of random dots. In every frame a new random share moves, and the others get new random places."""

    count: int = Field(default=60, ge=1, le=20_000)
    """Number of dots in the frame."""
    size: Annotated[float, unit("px")] = Field(default=4.0, gt=0.0, le=64.0)
    """Side of a dot."""
    coherence: float = Field(default=1.0, ge=0.0, le=1.0)
    """Share of the dots that move together."""
    motion: Direction = "rightward"
    """Direction of the dots that move together."""
    speed: Annotated[float, unit("px/s")] = Field(default=120.0, ge=0.0, le=10_000.0)
    """Speed of the dots."""
    grey: Annotated[float, unit("grey levels")] = Field(default=40.0, ge=0.0, le=255.0)
    """Grey level of the dots."""
    background_grey: Annotated[float, unit("grey levels")] = Field(default=200.0, ge=0.0, le=255.0)
    """Grey level of the background."""


class Dots(TimedStimulus[DotsParams]):
    """Square dots on an even ground. Dots that leave the frame re-enter on its other side; all are still in the
    rest."""

    def __init__(self, params: DotsParams, seed: int = 0) -> None:
        super().__init__(params, seed)
        x, y = DIRECTIONS[params.motion]
        self._velocity = x * params.speed, y * params.speed
        self._places = self._walk(stream("stimulus", seed))

    def _walk(self, rng: np.random.Generator) -> Floats:
        """Compute the top left corner (x, y) of each dot after each displacement: (displacements + 1, count, 2), px."""
        p = self.params
        field = np.array([p.columns, p.rows], float)
        places = np.empty((p.moving_frames() + 1, p.count, 2))
        places[0] = rng.uniform(size=(p.count, 2)) * field
        together = round(p.coherence * p.count)
        for before, after in pairwise(places):
            after[:] = rng.uniform(size=(p.count, 2)) * field
            chosen = rng.permutation(p.count)[:together]
            after[chosen] = (before[chosen] + np.array(self._velocity) / p.fps) % field
        return places

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        p = self.params
        step = index - p.rest_frames()
        luma = self._painted(self._places[max(step, 0)])
        if not 0 <= step < p.moving_frames():
            return StimulusFrame(luma, Truth("still"))
        return StimulusFrame(luma, Truth(p.motion, background_velocity=self._velocity))

    def _painted(self, places: Floats) -> Luma:
        """Paint each dot's share of each pixel that it touches; where dots overlap a pixel is covered once."""
        p = self.params
        reach = np.arange(int(np.ceil(p.size)) + 1)
        whole = np.floor(places).astype(np.int64)
        offset = places - whole
        # (count, 2, reach): along x and along y.
        cover = np.clip(np.minimum(reach + 1, offset[..., None] + p.size) - np.maximum(reach, offset[..., None]), 0, 1)
        at = whole[..., None] + reach
        cells = (at[:, 1, :, None] % p.rows) * p.columns + at[:, 0, None, :] % p.columns
        shares = cover[:, 1, :, None] * cover[:, 0, None, :]
        covered = np.minimum(np.bincount(cells.ravel(), shares.ravel(), p.rows * p.columns), 1.0).reshape(self.shape)
        return np.rint(p.background_grey + (p.grey - p.background_grey) * covered).astype(np.uint8)
