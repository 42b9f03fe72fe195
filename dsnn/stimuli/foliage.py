"""Wind in the leaves: a natural texture that sways about its place, in a band of frequencies."""

from __future__ import annotations

import math
from typing import Annotated

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field
from pydantic.dataclasses import dataclass as validated

from dsnn.field_docs import with_field_docs
from dsnn.stimuli.background import pink
from dsnn.stimuli.stimulus import CONFIG, Stimulus, StimulusFrame, TimedParams, Truth
from dsnn.stimuli.streams import stream

Amplitude = Annotated[float, Field(ge=0.0, le=50.0)]
Floats = npt.NDArray[np.float32]

TONES = 4
"""Frequencies of which the sway is made."""


@with_field_docs
@validated(frozen=True, config=CONFIG)
class FoliageParams(TimedParams):
    """Neighbouring leaves sway together, distant ones independently; on the average nothing moves anywhere."""

    amplitude_px: tuple[Amplitude, Amplitude] = Field(
        default=(2.0, 0.5), description="rms displacement along x and y, px"
    )
    low_hz: float = Field(default=0.5, gt=0.0, le=500.0, description="lowest frequency of the sway, Hz")
    high_hz: float = Field(default=3.0, gt=0.0, le=500.0, description="highest frequency of the sway, Hz")
    patch_px: float = Field(default=30.0, ge=1.0, le=1000.0, description="how far leaves sway together, px")


class Foliage(Stimulus[FoliageParams]):
    """The seed makes texture (of 1/f amplitude) and sway. Still at first, the wind rises over the rest."""

    def __init__(self, params: FoliageParams, seed: int = 0) -> None:
        super().__init__(params, seed)
        p = params
        if p.low_hz > p.high_hz:
            raise ValueError(f"low_hz={p.low_hz:g}: legal is a number up to high_hz, {p.high_hz:g}")
        rng = stream("stimulus", seed)
        self._texture = pink(self.shape, rng)
        self._tones = rng.uniform(p.low_hz, p.high_hz, TONES)
        # For the cosine and the sine of each tone: displacement along x and y of every pixel.
        self._sway = np.stack([self._smooth(rng) for _ in range(2 * TONES)]).reshape(2 * TONES, -1)
        self._home = np.mgrid[: p.rows, : p.columns][::-1].astype(np.float32)

    def _smooth(self, rng: np.random.Generator) -> Floats:
        """A field of displacements, (2, R, C), alike over a patch, of the amplitude asked for once all are added."""
        fields = []
        for amplitude in self.params.amplitude_px:
            noise = rng.standard_normal(self.shape).astype(np.float32)
            field = cv2.GaussianBlur(noise, (0, 0), self.params.patch_px / 2, borderType=cv2.BORDER_REFLECT)
            fields.append(field * (amplitude / max(float(field.std()), 1e-6) / math.sqrt(TONES)))
        return np.stack(fields)

    def __len__(self) -> int:
        return self.params.rest_frames() + self.params.moving_frames() + 1

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        turns = 2 * np.pi * self._tones * index / self.fps
        wind = min(index / max(self.params.rest_frames(), 1), 1.0)
        gains = wind * np.concatenate([np.cos(turns), np.sin(turns)]).astype(np.float32)
        x, y = (gains @ self._sway).reshape(self._home.shape) + self._home
        luma = cv2.remap(self._texture, x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_WRAP)
        motion = "swaying" if index else "still"
        return StimulusFrame(np.clip(np.rint(luma), 0, 255).astype(np.uint8), Truth(motion))
