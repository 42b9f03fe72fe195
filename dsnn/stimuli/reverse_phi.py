"""Phi and reverse-phi motion: a pattern that jumps, with equal or reversed contrast after each step.

A detector that correlates luminance sees reverse-phi move backward (Anstis 1970, Vision Research 10:1411).
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.moving import DIRECTIONS, Direction
from dsnn.stimuli.stimulus import StimulusFrame, TimedParams, TimedStimulus, Truth
from dsnn.stimuli.streams import stream


@parameters
class ReversePhiParams(TimedParams):
    """Parameters of random squares, light or dark about the mean, that jump by whole pixels."""

    contrast_at_a_step: Literal["reversed", "kept"] = "reversed"
    """Contrast after a step. reversed: reverse-phi; kept: phi, for comparison."""
    motion: Direction = "rightward"
    """Direction of the displacement."""
    square_px: Annotated[int, unit("px")] = Field(default=6, ge=1, le=256)
    """Side of a square."""
    step_px: Annotated[int, unit("px")] = Field(default=3, ge=1, le=256)
    """Displacement at a step."""
    step_frames: Annotated[int, unit("frames")] = Field(default=2, ge=1, le=1000)
    """Time from step to step."""
    mean_grey: Annotated[float, unit("grey levels")] = Field(default=120.0, ge=0.0, le=255.0)
    """Mean grey level."""
    amplitude: Annotated[float, unit("grey levels")] = Field(default=80.0, ge=0.0, le=127.5)
    """Difference of light and dark squares from the mean."""


class ReversePhi(TimedStimulus[ReversePhiParams]):
    """Phi or reverse-phi motion. The seed makes the pattern, which repeats beyond the frame's borders.

    The truth's velocity is the displacement averaged over the steps. The perceived motion may be the opposite.
    """

    def __init__(self, params: ReversePhiParams, seed: int = 0) -> None:
        super().__init__(params, seed)
        p = params
        if not p.amplitude <= p.mean_grey <= 255.0 - p.amplitude:
            raise ValueError(
                f"amplitude must be at most {min(p.mean_grey, 255.0 - p.mean_grey):g}"
                f" with mean_grey={p.mean_grey:g}, got {p.amplitude:g}"
            )
        squares = [-(-n // p.square_px) for n in self.shape]
        signs = stream("stimulus", seed).choice([-1.0, 1.0], size=squares)
        grown = np.kron(signs, np.ones((p.square_px, p.square_px)))[: p.rows, : p.columns]
        self._pictures = [np.rint(p.mean_grey + s * p.amplitude * grown).astype(np.uint8) for s in (1.0, -1.0)]
        speed = p.step_px * p.fps / p.step_frames
        x, y = DIRECTIONS[p.motion]
        self._velocity = x * speed, y * speed

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        p = self.params
        elapsed = index - p.rest_frames()
        steps = max(elapsed, 0) // p.step_frames
        x, y = DIRECTIONS[p.motion]
        picture = self._pictures[steps % 2 if p.contrast_at_a_step == "reversed" else 0]
        luma = np.roll(picture, (y * steps * p.step_px, x * steps * p.step_px), axis=(0, 1))
        moving = 0 <= elapsed < p.moving_frames()
        return StimulusFrame(luma, Truth(p.motion, background_velocity=self._velocity) if moving else Truth("still"))
