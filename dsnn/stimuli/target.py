"""A target of a few pixels that moves before a moving background, at a velocity relative to it."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from pydantic import AfterValidator, Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.background import PHOTOGRAPH, Panorama, known_background, panorama
from dsnn.stimuli.moving import paint
from dsnn.stimuli.stimulus import Box, ClipParams, Stimulus, StimulusFrame, Truth
from dsnn.stimuli.streams import stream

EVEN = "even"
Side = Annotated[float, unit("px"), Field(ge=1.0, le=15.0)]


@parameters
class TargetParams(ClipParams):
    """Parameters of a small target, in the frame of the robot's camera."""

    rows: Annotated[int, unit("px")] = Field(default=72, ge=8, le=4096)
    """Rows of a frame."""
    columns: Annotated[int, unit("px")] = Field(default=99, ge=8, le=4096)
    """Columns of a frame."""
    width: Side = 5.0
    """Width of the target."""
    height: Side = 5.0
    """Height of the target."""
    grey: Annotated[float, unit("grey levels")] = Field(default=0.0, ge=0.0, le=255.0)
    """Grey level of the target: 0 is darker than any background, 255 lighter."""
    speed: Annotated[float, unit("px/s")] = Field(default=60.0, ge=0.0, le=10_000.0)
    """Speed of the target relative to the background."""
    direction_deg: Annotated[float, unit("degrees")] = Field(default=0.0, ge=-360.0, le=360.0)
    """Direction of the target relative to the background: 0 rightward, 90 downward."""
    background: Annotated[str, AfterValidator(lambda name: name if name == EVEN else known_background(name))] = (
        PHOTOGRAPH
    )
    """What is behind the target: photograph, dead-leaves, pink, foliage, street, or the path of a picture, as of
    ``cluttered``; or even."""
    background_speed: Annotated[float, unit("px/s")] = Field(default=20.0, ge=-10_000.0, le=10_000.0)
    """Speed of the background, rightward positive."""
    background_grey: Annotated[float, unit("grey levels")] = Field(default=200.0, ge=0.0, le=255.0)
    """Grey level of an even background."""
    object: Literal["present", "absent"] = "present"
    """Whether the target is present; absent: only the background, for the same time."""
    duration_s: Annotated[float, unit("s")] = Field(default=2.0, gt=0.0, le=600.0)
    """Duration of the clip. Everything moves from the first frame to the last."""


class Target(Stimulus[TargetParams]):
    """A small target before clutter. The seed makes the scene, and where in it the clip begins.

    The target is in the middle of the frame in the middle of the clip. Having left the frame, it enters it again on the
    other side.
    """

    def __init__(self, params: TargetParams, seed: int = 0) -> None:
        super().__init__(params, seed)
        turn = math.radians(params.direction_deg)
        self._drift = params.background_speed, 0.0
        self._velocity = (
            params.speed * math.cos(turn) + params.background_speed, round(params.speed * math.sin(turn), 9)
        )  # fmt: skip

    def __len__(self) -> int:
        return max(1, round(self.params.duration_s * self.fps)) + 1

    # A declaration makes its clips only to check them, so random numbers are drawn with the first frame.

    @cached_property
    def _panorama(self) -> Panorama:
        return panorama(self.params.background, self.shape, self.seed)

    @cached_property
    def _start(self) -> float:
        return float(stream("target.start", self.seed).uniform(0, self._panorama.period))

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        p = self.params
        if p.background == EVEN:
            canvas = np.full(self.shape, round(p.background_grey), np.uint8)
        else:
            canvas = self._panorama.view(self._start - p.background_speed * index / self.fps)
        box = self._box(index)
        if p.object == "absent" or not box.touches(self.shape):
            return StimulusFrame(canvas, Truth("still", background_velocity=self._drift))
        paint(canvas, box, p.grey)
        return StimulusFrame(canvas, Truth(self._word(), box, self._velocity, self._drift))

    def _box(self, index: int) -> Box:
        p, (x, y) = self.params, self._velocity
        moved = (index - (len(self) - 1) / 2.0) / self.fps
        left, top = _around(moved * x, p.columns, p.width, x / p.fps), _around(moved * y, p.rows, p.height, y / p.fps)
        return Box(left, top, p.width, p.height)

    def _word(self) -> str:
        """Name the direction in the image, by the larger component."""
        x, y = self._velocity
        if not x and not y:
            return "still"
        across = abs(x) >= abs(y)
        return ("rightward" if x > 0 else "leftward") if across else ("downward" if y > 0 else "upward")


def _around(moved: float, field: int, size: float, step: float) -> float:
    """Return the first edge of what moved from the field's middle, px. Between two sides it is outside for a frame."""
    beyond = size + abs(step)
    return ((field - size) / 2.0 + moved + beyond) % (field + beyond + abs(step)) - beyond
