"""Leaves in the wind: a natural texture that sways about its place, in a band of frequencies."""

from __future__ import annotations

import math
from typing import Annotated

import cv2
import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.stimuli.scenes import pink
from dsnn.stimuli.stimulus import StimulusFrame, TimedParams, TimedStimulus, Truth
from dsnn.stimuli.streams import stream

Amplitude = Annotated[float, Field(ge=0.0, le=50.0), unit("px")]
Floats = npt.NDArray[np.float32]

TONES = 4
"""Number of frequencies in the sway."""


class Sway:
    """Displacements about a place of rest: similar over a patch, independent at a distance, with a mean of zero.

    Parameters
    ----------
    shape
        (R, C) of the frame.
    amplitude_px
        Standard deviation of the displacement within a field, along x and y, px; its rms is some 13 % larger.
    band_hz
        Lowest and highest frequency; `TONES` frequencies are drawn between them.
    patch_px
        Distance over which neighbouring pixels move together, px.
    rng
        Draws the frequencies, then the displacements.
    """

    def __init__(
        self, shape: tuple[int, int], amplitude_px: tuple[float, float], band_hz: tuple[float, float], patch_px: float,
        rng: np.random.Generator,
    ) -> None:  # fmt: skip
        self._tones = rng.uniform(*band_hz, TONES)
        # For the cosine and the sine of each tone: displacement along x and y of every pixel.
        fields = [_smooth(shape, amplitude_px, patch_px, rng) for _ in range(2 * TONES)]
        self._fields = np.stack(fields).reshape(2 * TONES, -1)
        self._home = np.mgrid[: shape[0], : shape[1]][::-1].astype(np.float32)

    def places(self, index: int, fps: float, wind: float = 1.0) -> Floats:
        """Find the texture's column and row at rest that each pixel of frame ``index`` shows, (2, R, C).

        ``wind`` multiplies the displacement.
        """
        turns = 2 * np.pi * self._tones * index / fps
        gains = wind * np.concatenate([np.cos(turns), np.sin(turns)]).astype(np.float32)
        return np.asarray((gains @ self._fields).reshape(self._home.shape) + self._home, np.float32)


def _smooth(
    shape: tuple[int, int], amplitude_px: tuple[float, float], patch_px: float, rng: np.random.Generator
) -> Floats:
    """Draw a field of displacements, (2, R, C), similar over a patch; all fields together have the set amplitude."""
    fields = []
    for amplitude in amplitude_px:
        noise = rng.standard_normal(shape).astype(np.float32)
        field = cv2.GaussianBlur(noise, (0, 0), patch_px / 2, borderType=cv2.BORDER_REFLECT)
        fields.append(field * (amplitude / max(float(field.std()), 1e-6) / math.sqrt(TONES)))
    return np.stack(fields)


def check_band(low_hz: float, high_hz: float) -> None:
    """Raise ``ValueError`` for a band whose lowest frequency is above its highest."""
    if low_hz > high_hz:
        raise ValueError(f"low_hz must be at most high_hz, {high_hz:g}, got {low_hz:g}")


@parameters
class FoliageParams(TimedParams):
    """Parameters of foliage. Neighbouring leaves sway together, distant ones independently, with no mean motion."""

    amplitude_px: tuple[Amplitude, Amplitude] = (2.0, 0.5)
    """Standard deviation of the displacement within a field, along x and y."""
    low_hz: Annotated[float, unit("Hz")] = Field(default=0.5, gt=0.0, le=500.0)
    """Lowest frequency of the sway."""
    high_hz: Annotated[float, unit("Hz")] = Field(default=3.0, gt=0.0, le=500.0)
    """Highest frequency of the sway."""
    patch_px: Annotated[float, unit("px")] = Field(default=30.0, ge=1.0, le=1000.0)
    """Distance over which leaves sway together."""


class Foliage(TimedStimulus[FoliageParams]):
    """Foliage in the wind. The seed makes texture (of 1/f amplitude) and sway. The wind rises over the rest."""

    is_continuous = True

    def __init__(self, params: FoliageParams, seed: int = 0) -> None:
        super().__init__(params, seed)
        p = params
        check_band(p.low_hz, p.high_hz)
        rng = stream("stimulus", seed)
        self._texture = pink(self.shape, rng)
        self._sway = Sway(self.shape, p.amplitude_px, (p.low_hz, p.high_hz), p.patch_px, rng)

    def frame(self, index: int) -> StimulusFrame:
        """Paint frame ``index``."""
        wind = min(index / max(self.params.rest_frames(), 1), 1.0)
        x, y = self._sway.places(index, self.fps, wind)
        luma = cv2.remap(self._texture, x, y, cv2.INTER_CUBIC, borderMode=cv2.BORDER_WRAP)
        motion = "swaying" if index else "still"
        return StimulusFrame(np.clip(np.rint(luma), 0, 255).astype(np.uint8), Truth(motion))
