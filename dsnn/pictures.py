"""Picture files as grey levels: the one reader of every picture that a user names."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

_NETPBM = re.compile(rb"P[56]" + 3 * rb"(?:\s|#[^\n]*\n)+(\d+)")
"""A binary PGM or PPM file: its width, its height and the number that stands for white."""


def read_picture(path: str | Path, *, raw: bool = False) -> npt.NDArray[np.uint8]:
    """Read a picture as grey levels from 0 to 255.

    Parameters
    ----------
    path
        A file that OpenCV decodes: PNG, JPEG, TIFF, BMP, PGM, ... of 8 or 16 bits, turned as its EXIF data say.
    raw
        Whether to take nothing but grey levels of 8 bits, as a camera measured them.

    Returns
    -------
    numpy.ndarray
        (R, C): the luma of Rec. 601 where it has colours, and of 16 bits the upper 8.

    Raises
    ------
    ValueError
        There is no such file, it is no picture, it is transparent, its file does not say what white is, or ``raw`` is
        wanted of another picture. In one line that begins with the path.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror})") from None
    stored = _decoded(data, cv2.IMREAD_UNCHANGED)
    if stored is None:
        raise ValueError(f"{path}: no picture that can be read")
    if raw and (stored.ndim != 2 or stored.dtype != np.uint8):
        raise ValueError(f"{path}: expected grey levels of 8 bits, got {stored.dtype} of shape {stored.shape}")
    if stored.dtype not in (np.uint8, np.uint16):
        raise ValueError(
            f"{path}: its values are {stored.dtype}, of which no file says what is white; save it with 8 bits"
        )
    white = np.iinfo(stored.dtype).max
    # OpenCV leaves out the one transparent level of a grey PNG.
    key = stored.ndim == 2 and b"tRNS" in data[: data.find(b"IDAT")]
    if key or (stored.ndim == 3 and stored.shape[2] == 4 and stored[:, :, 3].min() < white):
        raise ValueError(f"{path}: parts of it are transparent, and nothing says what is behind; save it without")
    if header := _NETPBM.match(data):
        levels = cv2.cvtColor(stored, cv2.COLOR_BGR2GRAY) if stored.ndim == 3 else stored
        return np.rint(levels * (255 / int(header[3]))).astype(np.uint8)
    picture = _decoded(data, cv2.IMREAD_GRAYSCALE)
    if stored.dtype == np.uint16 and (picture is None or picture.max() < 64) and stored.any():
        problem = f"its brightest level is {stored.max()} of {white}, as of a picture of fewer bits"
        raise ValueError(f"{path}: {problem}; save it with 8 bits, or spread over all 16")
    return np.asarray(picture, np.uint8)


def _decoded(data: bytes, flags: int) -> npt.NDArray[Any] | None:
    try:
        return cv2.imdecode(np.frombuffer(data, np.uint8), flags) if data else None
    except cv2.error:  # a header that tells of more pixels than OpenCV takes
        return None
