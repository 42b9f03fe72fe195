"""Apparent motion in two steps: a bar brightens or darkens, then its neighbour does.

Eichner, Joesch, Schnell, Reiff and Borst 2011 (Neuron 70:1155) used the four pairs of steps ON-ON, OFF-OFF, ON-OFF and
OFF-ON. They distinguish detectors that correlate steps of one sign from detectors that correlate all steps.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.moving import DIRECTIONS, Direction
from dsnn.stimuli.stimulus import ClipParams, Luma, Stimulus, StimulusFrame, Truth

Pair = Literal["on-on", "off-off", "on-off", "off-on"]


@parameters
class ApparentParams(ClipParams):
    """Parameters of apparent motion: pairs of adjacent bars on an even ground, as long as the field is wide.

    The first bars of all pairs step at the same time, the second ones ``delay_frames`` later. Both then keep their
    grey. The pairs are ``period_px`` apart, so that they fill the field and do not overlap.
    """

    motion: Direction = "rightward"
    """Direction from the first bar to the second."""
    polarity: Pair = "on-on"
    """Polarity of the first step and of the second; on: brightening."""
    width_px: Annotated[int, unit("px")] = Field(default=2, ge=1, le=4096)
    """Width of a bar along the motion."""
    spacing_px: Annotated[int, unit("px")] = Field(default=4, ge=1, le=4096)
    """Distance from bar to bar, centre to centre."""
    delay_frames: Annotated[int, unit("frames")] = Field(default=1, ge=1, le=1000)
    """Time from the first step to the second."""
    period_px: Annotated[int, unit("px")] = Field(default=40, ge=2, le=4096)
    """Distance from pair to pair."""
    ground_grey: Annotated[float, unit("grey levels")] = Field(default=120.0, ge=0.0, le=255.0)
    """Grey level before the steps."""
    amplitude: Annotated[float, unit("grey levels")] = Field(default=80.0, ge=0.0, le=127.5)
    """Height of a step."""
    rest_s: Annotated[float, unit("s")] = Field(default=0.3, ge=0.0, le=60.0)
    """Stillness before the first step."""
    after_s: Annotated[float, unit("s")] = Field(default=0.7, gt=0.0, le=60.0)
    """Stillness from the second step on."""


class Apparent(Stimulus[ApparentParams]):
    """Apparent motion of bars. It has nothing random: every seed gives the same frames.

    The truth names the motion from the first step to the frame before the second. ``background_velocity`` is the
    spacing over the delay. After the second step everything is still.
    """

    def __init__(self, params: ApparentParams, seed: int = 0) -> None:
        super().__init__(params, seed)
        p = params
        if p.width_px > p.spacing_px:
            raise ValueError(f"width_px must be at most spacing_px, {p.spacing_px}, got {p.width_px}")
        if not p.amplitude <= p.ground_grey <= 255.0 - p.amplitude:
            most = min(p.ground_grey, 255.0 - p.ground_grey)
            raise ValueError(
                f"amplitude must be at most {most:g} with ground_grey={p.ground_grey:g}, got {p.amplitude:g}"
            )
        x, y = DIRECTIONS[p.motion]
        field = p.columns if x else p.rows
        if not p.spacing_px + p.width_px <= p.period_px <= field:
            least = p.spacing_px + p.width_px
            raise ValueError(f"period_px must be between {least} and the frame's {field}, got {p.period_px}")
        self._first = round(p.rest_s * p.fps)
        self._second = self._first + p.delay_frames
        self._frames = self._second + max(1, round(p.after_s * p.fps))
        self._greys = [
            round(p.ground_grey + (p.amplitude if s == "on" else -p.amplitude)) for s in p.polarity.split("-")
        ]
        bars = _bars(field, p)[:, :: x + y]  # the opposite motion is the mirror image
        self._bars = [np.broadcast_to(bar if x else bar[:, np.newaxis], self.shape) for bar in bars]
        speed = p.spacing_px * p.fps / p.delay_frames
        self._velocity = x * speed, y * speed

    def __len__(self) -> int:
        return self._frames

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        luma: Luma = np.full(self.shape, round(self.params.ground_grey), np.uint8)
        for step, bar, grey in zip((self._first, self._second), self._bars, self._greys, strict=True):
            if index >= step:
                luma[bar] = grey
        if self._first <= index < self._second:
            return StimulusFrame(luma, Truth(self.params.motion, background_velocity=self._velocity))
        return StimulusFrame(luma, Truth("still"))


def _bars(field: int, p: ApparentParams) -> npt.NDArray[np.bool_]:
    """Locate the first and the second bars along the motion, (2, ``field``): whole pairs, centred."""
    pairs = field // p.period_px
    margin = (field - pairs * p.period_px) // 2 + (p.period_px - p.spacing_px - p.width_px) // 2
    along = np.arange(field)
    place = (along - margin) % p.period_px
    inside = (along >= margin) & (along < margin + pairs * p.period_px)
    first = inside & (place < p.width_px)
    second = inside & (place >= p.spacing_px) & (place < p.spacing_px + p.width_px)
    return np.stack([first, second])
