"""The layer that every model of this library begins with."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]


class Retina:
    """Change of luminance (`high-pass`)."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self._before: npt.NDArray[Any] = np.zeros(shape, np.uint8)
        self._change: Floats = np.zeros(shape, np.float32)
        self._first = True

    def reset(self) -> None:
        """Forget every frame."""
        self._first = True

    def step(self, luminance: npt.NDArray[Any]) -> Floats:
        """Return P of this frame, 0 on the first: a buffer that stays valid until the next step."""
        before = luminance if self._first else self._before
        cv2.subtract(luminance, before, self._change, None, cv2.CV_32F)
        if luminance.dtype == self._before.dtype:
            np.copyto(self._before, luminance)
        else:
            self._before = luminance.copy()
        self._first = False
        return self._change
