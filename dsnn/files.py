"""What files of pictures and of films have in common: levels without a white, several pictures in one."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import cv2

USUAL_FPS = 30.0
"""Frames per second where nothing says otherwise, and for which the models' constants were chosen."""
BITS_14 = 0.252
"""Share of white that no value of 14 bits or fewer in 16 exceeds, with a margin for rounding."""


def check_white(path: object, shares: Iterable[float]) -> None:
    """Refuse 16-bit levels all of which are so low that fewer bits may be meant.

    Files of 10 to 14 bits in 16 do not say that they are. A single bright picture shows that 16 are meant.

    Parameters
    ----------
    path
        What the message begins with.
    shares
        Brightest level of each picture of a camera, as a share of the white of 16 bits. No more than needed are taken.

    Raises
    ------
    ValueError
        None is above `BITS_14`, and they are not all 0.
    """
    most = 0.0
    for share in shares:
        most = max(most, share)
        if most > BITS_14:
            return
    if most:
        problem = f"its brightest level is {most:.1%} of the white of 16 bits, as of a picture of fewer bits"
        raise ValueError(f"{path}: {problem}; save it with 8 bits, or spread over all 16")


def check_single(path: str | Path) -> None:
    """Refuse a file of several pictures, of which OpenCV and FFmpeg read the first, with ``ValueError``."""
    if cv2.haveImageReader(str(path)) and (pages := cv2.imcount(str(path))) > 1:
        raise ValueError(f"{path}: holds {pages} pictures; save each as a file of its own, in a folder")
