"""The layer that every model of this library begins with."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]


class Retina:
    """Change of luminance, with ``gains`` times what is left of the last changes, newest first (`high-pass`)."""

    def __init__(self, shape: tuple[int, int], gains: Sequence[float] = ()) -> None:
        self._gains = tuple(gains)
        self._before: npt.NDArray[Any] = np.zeros(shape, np.uint8)
        self._changes: list[Floats] = [np.zeros(shape, np.float32) for _ in range(len(self._gains) + 1)]
        self._first = True

    def reset(self) -> None:
        """Forget every frame."""
        self._first = True
        for change in self._changes:
            change[:] = 0.0

    def step(self, luminance: npt.NDArray[Any]) -> Floats:
        """Return P of this frame, 0 on the first: a buffer that stays valid until the next step."""
        self._changes.insert(0, self._changes.pop())
        p = self._changes[0]
        before = luminance if self._first else self._before
        cv2.subtract(luminance, before, p, None, cv2.CV_32F)
        if luminance.dtype == self._before.dtype:
            np.copyto(self._before, luminance)
        else:
            self._before = luminance.copy()
        self._first = False
        for gain, change in zip(self._gains, self._changes[1:], strict=True):
            cv2.scaleAdd(change, gain, p, p)
        return p
