"""Endless backgrounds that shift horizontally by any fraction of a pixel.

``photograph`` is ``photograph.png`` in this folder: palm leaves and the feet of a raccoon. It shows rows 427 to 768 of
``raccoon-procyon-lotor.jpg`` from www.public-domain-image.com, a photograph in the public domain. SciPy shipped it as
``scipy.misc.face`` up to version 1.9. Its luma was blurred (Gaussian, sigma half a pixel of the result) and reduced to
540x180 px. The other backgrounds are the scenes of `dsnn.stimuli.scenes`, each made from a seed, and your own pictures.
"""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.pictures import read_picture
from dsnn.stimuli.scenes import SCENES, scene
from dsnn.stimuli.stimulus import Luma

PHOTOGRAPH = "photograph"
Floats = npt.NDArray[np.float32]

PHASES = 8
"""Number of precomputed fractional shifts. Shifts between two of them are interpolated.

The interpolation then loses at most 2 % of the finest detail of a pixel grid. Interpolation between whole pixels would
lose all of it, and a slowly shifting texture would flicker from sharp to blurred.
"""


class Panorama:
    """An image (R, period) that repeats along x, viewed through windows of (R, ``columns``)."""

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


def known_background(name: str) -> str:
    """Check the name of a background, or the path of a picture, and return it; otherwise raise ``ValueError``."""
    if name != PHOTOGRAPH and name not in SCENES and not Path(name).is_file():
        raise ValueError(f"must be {PHOTOGRAPH}, {', '.join(SCENES)}, or the path of a picture")
    return name


def panorama(image: str, shape: tuple[int, int], seed: int) -> Panorama:
    """Make a background for frames of ``shape`` (R, C): `PHOTOGRAPH`, one of `SCENES` or the path of a picture.

    A scene is made from the seed, twice as wide as the frame. A picture that cannot be read raises ``ValueError``.
    """
    generated = image in SCENES
    changed_ns = 0 if generated or image == PHOTOGRAPH else Path(image).stat().st_mtime_ns
    return _panorama(image, shape, seed if generated else 0, changed_ns)


@lru_cache(maxsize=4)
def _panorama(image: str, shape: tuple[int, int], seed: int, changed_ns: int) -> Panorama:
    rows, columns = shape
    if image in SCENES:
        return Panorama(scene(image, (rows, 2 * columns), seed).astype(np.float32), columns)
    return Panorama(_photograph(rows) if image == PHOTOGRAPH else _beside_mirror(read_picture(image), rows), columns)


def _photograph(rows: int) -> Floats:
    """Join the photograph to its mirror image, so that it repeats without a seam; mirrored downward as needed."""
    data = np.frombuffer(Path(__file__).with_name("photograph.png").read_bytes(), np.uint8)
    picture = np.asarray(cv2.imdecode(data, cv2.IMREAD_GRAYSCALE), np.float32)
    height, width = picture.shape
    whole = np.pad(picture, ((0, max(rows - height, 0)), (0, width)), mode="symmetric")
    return np.asarray(whole[:rows], np.float32)


def _beside_mirror(picture: Luma, rows: int) -> Floats:
    """Scale a picture to a height of ``rows``, with its proportions, and join it to its mirror image."""
    height, width = picture.shape
    size = max(round(width * rows / height), 1), rows
    scaled = cv2.resize(picture, size, interpolation=cv2.INTER_AREA if rows < height else cv2.INTER_LINEAR)
    return np.pad(np.asarray(scaled, np.float32), ((0, 0), (0, size[0])), mode="symmetric")
