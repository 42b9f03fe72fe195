"""Read picture files as grey levels."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.files import check_single, check_white

Image = npt.NDArray[np.uint8]

_NETPBM = re.compile(rb"P[56]" + 3 * rb"(?:\s|#[^\n]*\n)+(\d+)")
"""A binary PGM or PPM file: its width, its height and the number that stands for white."""
_WHITE_UNREAD = re.compile(
    rb"\AP[237]\s|cICP.[\x08-\x0a\x10\x12]|nclx..\0[\x08-\x0a\x10\x12]|gAMA\0\x01\x86\xa0", re.DOTALL
)
"""Headers whose white OpenCV ignores: PAM and ASCII PGM, and PNG and AVIF of linear, logarithmic, PQ or HLG levels."""
_HEADER_BYTES = 1 << 16


class NotAPicture(ValueError):
    """The file is missing, or OpenCV cannot decode it."""


def read_picture(path: str | Path, *, raw: bool = False) -> Image:
    """Read a picture as grey levels from 0 to 255.

    Parameters
    ----------
    path
        A file that OpenCV decodes: PNG, JPEG, TIFF, BMP, PGM, ... of up to 16 bits. It is rotated by its EXIF data.
    raw
        Whether to accept only grey levels of 8 bits, as a camera measured them.

    Returns
    -------
    numpy.ndarray
        (R, C): the luma of Rec. 601 of a colour picture; the upper 8 bits of 16.

    Raises
    ------
    ValueError
        The file is missing, is not a picture (`NotAPicture`), holds several, is transparent, HDR or linear, or does not
        define white; or ``raw`` is set for another kind of picture. The message is one line that begins with the path.
    """
    picture, share = levels(path, raw=raw)
    check_white(path, [] if share is None else [share])
    return picture


def levels(path: str | Path, *, raw: bool = False) -> tuple[Image, float | None]:
    """Read a picture as `read_picture` does, without `check_white`, and what that needs to know.

    Returns
    -------
    picture
        (R, C), grey levels from 0 to 255.
    share
        Its brightest level as a share of the white of 16 bits; ``None`` if the file defines its white.

    Raises
    ------
    ValueError
        As of `read_picture`.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise NotAPicture(f"{path}: cannot be read ({error.strerror})") from None
    check_single(path)
    if not raw and _WHITE_UNREAD.search(data[:_HEADER_BYTES]):
        from dsnn.video import read_video  # not before: pictures of other kinds do without FFmpeg

        return next(iter(read_video(path)))[1], None
    stored = _decoded(data, cv2.IMREAD_UNCHANGED)
    if stored is None:
        raise NotAPicture(f"{path}: not a picture that OpenCV can read")
    if raw and (stored.ndim != 2 or stored.dtype != np.uint8):
        raise ValueError(f"{path}: grey levels must have 8 bits, got {stored.dtype} of shape {stored.shape}")
    if stored.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"{path}: the white level of {stored.dtype} values is unknown; save it with 8 bits")
    white = np.iinfo(stored.dtype).max
    # OpenCV ignores the one transparent level of a grey PNG.
    key = stored.ndim == 2 and b"tRNS" in data[: data.find(b"IDAT")]
    if key or (stored.ndim == 3 and stored.shape[2] == 4 and stored[:, :, 3].min() < white):
        raise ValueError(f"{path}: the picture is transparent in places; save it without transparency")
    grey = cv2.cvtColor(stored[:, :, :3], cv2.COLOR_BGR2GRAY) if stored.ndim == 3 else stored
    if header := _NETPBM.match(data):
        return np.rint(grey * (255 / int(header[3]))).astype(np.uint8), None
    decoded = _decoded(data, cv2.IMREAD_GRAYSCALE)  # none of a TIFF of 10 to 14 bits
    picture = np.asarray(grey // 256 if decoded is None else decoded, np.uint8)
    return picture, None if stored.dtype == np.uint8 else max(stored.max() / white, picture.max() / 255)


def _decoded(data: bytes, flags: int) -> npt.NDArray[Any] | None:
    try:
        return cv2.imdecode(np.frombuffer(data, np.uint8), flags) if data else None
    except cv2.error:  # a header with more pixels than OpenCV accepts
        return None
