"""Backgrounds that shift sidewise without end, by any fraction of a pixel.

``photograph`` is ``photograph.png`` beside this file: palm leaves and the feet of a raccoon, rows 427 to 768 of
``raccoon-procyon-lotor.jpg`` from www.public-domain-image.com, a photograph in the public domain that SciPy
shipped as ``scipy.misc.face`` up to its version 1.9. Its luma was blurred (Gaussian, sigma half a pixel of the
result) and reduced to 540x180 px. ``pink`` is noise whose amplitude falls as one over spatial frequency, as
it does in natural images (Field 1987, J. Opt. Soc. Am. A 4:2379).
"""

from __future__ import annotations

import math
from functools import lru_cache
from importlib import resources
from typing import Literal

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.stimuli.stimulus import Luma
from dsnn.stimuli.streams import stream

Image = Literal["photograph", "pink"]
Floats = npt.NDArray[np.float32]

PHASES = 8
"""Shifts of a fraction of a pixel that are kept; what lies between two of them is interpolated.

The interpolation then takes at most 2 % off the finest detail a pixel grid holds, where interpolating between
whole pixels would take all of it, and make a slowly shifting texture flicker from sharp to blurred.
"""

PINK_MEAN, PINK_SD = 110.0, 45.0
"""Grey levels: near the photograph's own, 103 and 57, with room for the tails."""


class Panorama:
    """An image (R, period) that repeats along x, seen through windows of (R, ``columns``)."""

    def __init__(self, image: Floats, columns: int) -> None:
        self.period = image.shape[1]
        self._columns = columns
        spectrum = np.fft.rfft(image, axis=1)
        turns = 2j * np.pi * np.fft.rfftfreq(self.period)
        # One column more than a window needs, for the upper of two neighbouring shifts.
        columns_kept = np.arange(self.period + columns + 1) % self.period
        shifted = (np.fft.irfft(spectrum * np.exp(turns * (k / PHASES)), self.period, axis=1) for k in range(PHASES))
        self._shifted: list[Floats] = [image[:, columns_kept].astype(np.float32) for image in shifted]

    def view(self, position: float) -> Luma:
        """Return the window, (R, columns) uint8, whose left border is ``position`` px into the image."""
        fine = (position % self.period) * PHASES
        below = math.floor(fine)
        share = fine - below
        return np.asarray(
            cv2.addWeighted(self._at(below), 1.0 - share, self._at(below + 1), share, 0.0, dtype=cv2.CV_8U), np.uint8
        )

    def _at(self, fine: int) -> Floats:
        column, phase = divmod(fine, PHASES)
        return self._shifted[phase][:, column : column + self._columns]


def panorama(image: Image, shape: tuple[int, int], seed: int) -> Panorama:
    """Make background ``image`` for frames of ``shape`` (R, C). The seed makes the noise; the photograph has none."""
    return _panorama(image, shape, seed if image == "pink" else 0)


@lru_cache(maxsize=4)
def _panorama(image: Image, shape: tuple[int, int], seed: int) -> Panorama:
    rows, columns = shape
    noise = stream("background.pink", seed)
    whole = _photograph(rows) if image == "photograph" else pink((rows, 2 * columns), noise)
    return Panorama(whole, columns)


def _photograph(rows: int) -> Floats:
    """Return the photograph beside its mirror image, so that it repeats without a seam; mirrored downward as needed."""
    data = np.frombuffer(resources.files("dsnn.stimuli").joinpath("photograph.png").read_bytes(), np.uint8)
    picture = np.asarray(cv2.imdecode(data, cv2.IMREAD_GRAYSCALE), np.float32)
    height, width = picture.shape
    whole = np.pad(picture, ((0, max(rows - height, 0)), (0, width)), mode="symmetric")
    return np.asarray(whole[:rows], np.float32)


def pink(shape: tuple[int, int], rng: np.random.Generator) -> Floats:
    """Noise of 1/f amplitude in 0..255, (R, C) float32, that repeats along x and y without a seam."""
    rows, columns = shape
    frequency = np.hypot(np.fft.fftfreq(rows)[:, np.newaxis], np.fft.rfftfreq(columns))
    frequency[0, 0] = np.inf  # no constant part
    noise = np.fft.irfft2(np.fft.rfft2(rng.standard_normal(shape)) / frequency, shape)
    return np.asarray(np.clip(PINK_MEAN + PINK_SD * noise / noise.std(), 0.0, 255.0), np.float32)
