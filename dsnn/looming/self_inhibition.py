"""Layers that both self-inhibited LGMDs share: byte arithmetic, and inhibition inside blocks of 3x3 cells.

They follow the public firmware of the Colias robot for these detectors, in which every state is an unsigned byte.
"""

from __future__ import annotations

import numpy as np

from dsnn.filters import FADED, Floats

MOST_CHANGE, MOST_STATE = 127.0, 255.0
"""The largest halved change of luminance, and the largest state, in the firmware."""
_BARELY = np.float32(1e-3)
"""Added before truncation, so that a whole number with a rounding error stays the same whole number."""


def halved(change: Floats) -> Floats:
    """Halve a change of luminance, (R, C), and clip it to -127 .. 127, as the firmware's network receives it."""
    half = change * np.float32(0.5)
    return np.asarray(np.clip(half, np.float32(-MOST_CHANGE), np.float32(MOST_CHANGE)), np.float32)


def truncated(values: Floats) -> Floats:
    """Round down to whole numbers from 0 to 255, as in an unsigned byte. The firmware wraps larger values."""
    whole: Floats = np.floor(np.clip(values, np.float32(0.0), np.float32(MOST_STATE)) + _BARELY)
    return whole


def exact(values: Floats) -> Floats:
    """Rectify a floating-point signal without truncation, and clear faded values."""
    kept: Floats = values * (values > FADED)
    return kept


class Blocks:
    """Weighted sums over a cell's neighbours within its own block of 3x3 cells; the blocks tile the field from 0, 0.

    Parameters
    ----------
    shape : tuple of int
        (R, C) of the field. Cells beyond it, in the last blocks, are 0.
    centre, side, corner : float
        Weights of the cell itself, of its sides and of its corners.
    integer : bool
        Whether each weighted term is truncated to a whole number, as shifts of bytes do.
    """

    def __init__(
        self, shape: tuple[int, int], centre: float, side: float, corner: float, *, integer: bool = False
    ) -> None:
        rows, columns = shape
        self._down, self._across = -(-rows // 3), -(-columns // 3)
        self._padded = np.zeros((3 * self._down, 3 * self._across), np.float32)
        self._shape = shape
        self._integer = integer
        self._centre, self._side, self._corner = centre, side, corner
        place = np.indices((3, 3)).reshape(2, 9)
        apart = np.abs(place[:, :, np.newaxis] - place[:, np.newaxis])
        self._sides = (apart.sum(axis=0) == 1).astype(np.float32)
        self._corners = ((apart[0] == 1) & (apart[1] == 1)).astype(np.float32)

    def of(self, image: Floats) -> Floats:
        """Arrange the cells of (R, C) by block: (blocks, 9)."""
        rows, columns = self._shape
        self._padded[:rows, :columns] = image
        cells = self._padded.reshape(self._down, 3, self._across, 3).swapaxes(1, 2)
        return np.ascontiguousarray(cells).reshape(-1, 9)

    def inhibition(self, cells: Floats) -> Floats:
        """Compute each cell's weighted sum over its own block, (blocks, 9), from cells by block."""
        centre, side, corner = (np.float32(w) * cells for w in (self._centre, self._side, self._corner))
        if self._integer:
            centre, side, corner = (np.floor(part + _BARELY) for part in (centre, side, corner))
        return np.asarray(centre + side @ self._sides + corner @ self._corners, np.float32)

    def back(self, cells: Floats) -> Floats:
        """Arrange cells by block, (blocks, 9), as the field again, (R, C)."""
        rows, columns = self._shape
        field = cells.reshape(self._down, self._across, 3, 3).swapaxes(1, 2).reshape(self._padded.shape)
        return np.asarray(field[:rows, :columns])
