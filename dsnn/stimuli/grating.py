"""Drifting gratings, sine or square, in any direction."""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.moving import DIRECTIONS
from dsnn.stimuli.stimulus import StimulusFrame, TimedParams, TimedStimulus, Truth, Velocity
from dsnn.stimuli.streams import stream

STEPS = 4096
"""Samples of one period."""


@parameters
class GratingParams(TimedParams):
    """Parameters of a grating that fills the frame, rests and then drifts."""

    waveform: Literal["sine", "square"] = "sine"
    """Profile of grey along the period."""
    period_px: Annotated[float, unit("px")] = Field(default=20.0, ge=2.0, le=10_000.0)
    """Wavelength; 1 / spatial frequency."""
    temporal_hz: Annotated[float, unit("Hz")] = Field(default=2.0, ge=0.0, le=500.0)
    """Number of periods that pass a pixel in a second."""
    direction_deg: Annotated[float, unit("degrees")] = Field(default=0.0, ge=-360.0, le=360.0)
    """Direction of the drift: 0 rightward, 90 downward."""
    contrast: float = Field(default=0.8, ge=0.0, le=1.0)
    """Michelson contrast, (max - min) / (max + min)."""
    mean_grey: Annotated[float, unit("grey levels")] = Field(default=127.5, ge=0.0, le=127.5)
    """Mean grey level."""


class Grating(TimedStimulus[GratingParams]):
    """A drifting grating. The seed sets its first phase; with seed 0 the phase is 0 in the middle of the frame."""

    is_continuous = True

    def __init__(self, params: GratingParams, seed: int = 0) -> None:
        super().__init__(params, seed)
        turn = math.radians(params.direction_deg)
        across, down = math.cos(turn) / params.period_px, math.sin(turn) / params.period_px  # cycles per px
        speed = params.temporal_hz * params.period_px
        self._velocity = speed * math.cos(turn), speed * math.sin(turn)
        # Distances from the frame's centre, so that a mirrored direction gives a mirrored frame.
        x, y = (np.arange(n) + 0.5 - n / 2 for n in (params.columns, params.rows))
        start = stream("stimulus", seed).uniform() if seed else 0.0
        phase = (across * x + down * y[:, np.newaxis] + start) % 1.0
        self._phase = np.rint(phase * STEPS).astype(np.int32)
        self._profile = _profile(params, across, down)

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        p = self.params
        step = index - p.rest_frames()
        drifted = round(p.temporal_hz * max(step, 0) / p.fps % 1.0 * STEPS)
        luma = np.take(self._profile, (self._phase - drifted) & (STEPS - 1))
        moving = 0 <= step < p.moving_frames() and p.temporal_hz > 0
        return StimulusFrame(luma, Truth(name(self._velocity), background_velocity=self._velocity) if moving else REST)


REST = Truth("still")


def name(velocity: Velocity) -> str:
    """Name a direction: one of four, or ``oblique``."""
    (right, down), speed = velocity, math.hypot(*velocity)
    for word, (x, y) in DIRECTIONS.items():
        if math.isclose(right * x + down * y, speed, rel_tol=1e-9):
            return word
    return "oblique"


def _profile(params: GratingParams, across: float, down: float) -> npt.NDArray[np.uint8]:
    """Compute the grey along one period, `STEPS` long, integrated over a pixel's square to avoid aliasing."""
    phase = np.arange(STEPS) / STEPS
    wave = np.sin(2 * np.pi * phase)
    if params.waveform == "square":
        wave = np.where(phase < 0.5, 1.0, -1.0)
        wave[[0, STEPS // 2]] = 0.0  # both edges equal
    harmonics = np.arange(STEPS // 2 + 1)
    integrated = np.fft.rfft(wave) * np.sinc(harmonics * across) * np.sinc(harmonics * down)
    grey = params.mean_grey * (1.0 + params.contrast * np.fft.irfft(integrated, STEPS))
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)
