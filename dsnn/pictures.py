"""Read picture files as grey levels."""

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
        A file that OpenCV decodes: PNG, JPEG, TIFF, BMP, PGM, ... of 8 or 16 bits. It is rotated by its EXIF data.
    raw
        Whether to accept only grey levels of 8 bits, as a camera measured them.

    Returns
    -------
    numpy.ndarray
        (R, C): the luma of Rec. 601 of a colour picture; the upper 8 bits of 16.

    Raises
    ------
    ValueError
        The file is missing, is not a picture, is transparent, or does not define white; or ``raw`` is set for another
        kind of picture. The message is one line that begins with the path.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror})") from None
    stored = _decoded(data, cv2.IMREAD_UNCHANGED)
    if stored is None:
        raise ValueError(f"{path}: not a picture that OpenCV can read")
    if raw and (stored.ndim != 2 or stored.dtype != np.uint8):
        raise ValueError(f"{path}: grey levels must have 8 bits, got {stored.dtype} of shape {stored.shape}")
    if stored.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"{path}: the white level of {stored.dtype} values is unknown; save it with 8 bits")
    white = np.iinfo(stored.dtype).max
    # OpenCV ignores the one transparent level of a grey PNG.
    key = stored.ndim == 2 and b"tRNS" in data[: data.find(b"IDAT")]
    if key or (stored.ndim == 3 and stored.shape[2] == 4 and stored[:, :, 3].min() < white):
        raise ValueError(f"{path}: the picture is transparent in places; save it without transparency")
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
    except cv2.error:  # a header with more pixels than OpenCV accepts
        return None
