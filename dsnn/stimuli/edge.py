"""A single edge, and a bar, that cross the whole field."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.moving import DIRECTIONS, Direction, paint
from dsnn.stimuli.stimulus import STILL, Box, ClipParams, Stimulus, StimulusFrame, Truth


@parameters
class EdgeParams(ClipParams):
    """Parameters of an edge that sweeps over the whole field.

    ``on`` brightens every pixel that it passes, and ``off`` darkens it.
    """

    motion: Direction = "rightward"
    """Direction in which the edge moves."""
    polarity: Literal["on", "off"] = "on"
    """Change that the edge brings; on: brightening, off: darkening."""
    speed: Annotated[float, unit("px/s")] = Field(default=120.0, gt=0.0, le=10_000.0)
    """Speed of the edge."""
    dark_grey: Annotated[float, unit("grey levels")] = Field(default=40.0, ge=0.0, le=255.0)
    """Grey level of the dark side."""
    light_grey: Annotated[float, unit("grey levels")] = Field(default=200.0, ge=0.0, le=255.0)
    """Grey level of the light side."""
    rest_s: Annotated[float, unit("s")] = Field(default=0.3, ge=0.0, le=60.0)
    """Stillness before and after the motion."""


@parameters
class BarParams(EdgeParams):
    """Parameters of a bar across the field. Its edges have opposite polarities; ``polarity`` is the leading edge's."""

    thickness: Annotated[float, unit("px")] = Field(default=20.0, gt=0.0, le=4096.0)
    """Thickness of the bar along its motion."""


class _Sweep(Stimulus[EdgeParams]):
    """Base class of edge and bar: a band of ``thickness`` px that enters the frame and moves by ``way`` px."""

    is_continuous = True

    def __init__(self, params: EdgeParams, seed: int, thickness: float, way: float) -> None:
        super().__init__(params, seed)
        if params.dark_grey >= params.light_grey:
            raise ValueError(f"dark_grey must be below light_grey, {params.light_grey:g}, got {params.dark_grey:g}")
        self._thickness, self._way = thickness, way
        self._rest = round(params.rest_s * params.fps)
        self._steps = int(np.ceil(way / params.speed * params.fps))

    def __len__(self) -> int:
        return 2 * self._rest + self._steps + 1

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        p = self.params
        step = index - self._rest
        band = self._band(min(max(step, 0) * p.speed / p.fps, self._way))
        ground, grey = (p.dark_grey, p.light_grey) if p.polarity == "on" else (p.light_grey, p.dark_grey)
        canvas = np.full(self.shape, round(ground), np.uint8)
        if not band.touches(self.shape):
            return StimulusFrame(canvas, Truth("still"))
        paint(canvas, band, grey)
        if not 0 <= step < self._steps:
            return StimulusFrame(canvas, Truth("still", band, STILL))
        x, y = DIRECTIONS[p.motion]
        return StimulusFrame(canvas, Truth(p.motion, band, (x * p.speed, y * p.speed)))

    def _band(self, entered: float) -> Box:
        """Locate the band whose leading edge is ``entered`` px inside the frame."""
        (rows, columns), thick = self.shape, self._thickness
        x, y = DIRECTIONS[self.params.motion]
        start = entered - thick if x + y > 0 else _field(self.params) - entered
        return Box(start, 0.0, thick, rows) if x else Box(0.0, start, columns, thick)


def _field(params: EdgeParams) -> int:
    """Return the frame's extent along the motion, px."""
    return params.columns if DIRECTIONS[params.motion][0] else params.rows


class Edge(_Sweep):
    """One edge, with nothing random. The truth's box is the ground that it has covered, as wide as the field."""

    def __init__(self, params: EdgeParams, seed: int = 0) -> None:
        super().__init__(params, seed, thickness=_field(params), way=_field(params))


class Bar(_Sweep):
    """One bar: two edges, one behind the other, with nothing random."""

    def __init__(self, params: BarParams, seed: int = 0) -> None:
        super().__init__(params, seed, thickness=params.thickness, way=_field(params) + params.thickness)
