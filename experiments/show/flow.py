"""Optical flow between two frames of a film."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

TICK_S = 0.0015
"""More than the clock of 1 ms that many containers have rounds an interval by."""


def mean_flow(before: npt.NDArray[np.uint8], now: npt.NDArray[np.uint8]) -> float:
    """Mean horizontal flow between two luma images (R, C), px per frame, rightward positive (Farneback 2003)."""
    flow = cv2.calcOpticalFlowFarneback(
        before, now, np.empty((*now.shape, 2), np.float32),
        pyr_scale=0.5, levels=3, winsize=15, iterations=3, poly_n=5, poly_sigma=1.2, flags=0,
    )  # fmt: skip
    return float(flow[..., 0].mean())
