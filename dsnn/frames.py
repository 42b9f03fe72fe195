"""Frames that may enter a model: the one gate every frame passes."""

from __future__ import annotations

from typing import Any, Literal, TypeVar

import cv2
import numpy as np
import numpy.typing as npt

Channels = Literal["grey", "bgr", "rgb"]
Params = TypeVar("Params")

_TO_GREY = {"bgr": cv2.COLOR_BGR2GRAY, "rgb": cv2.COLOR_RGB2GRAY}


class FrameError(ValueError):
    """A frame the model cannot take; the message names what is wrong and what is legal."""


def frozen(luma: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """Return a copy of a frame (R, C) that nobody can write to; of a frame that is read-only already, another view.

    Several models, a recording and an agent are shown one frame. The copy lies in an immutable object, so that no
    model can make it writable again; with a view of its own for each, none can give the others' another shape or type.
    """
    if not luma.flags.writeable:
        return luma.view()
    return np.frombuffer(luma.tobytes(), luma.dtype).reshape(luma.shape)


def checked_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return ``shape`` as two ints (R, C), or raise `FrameError` if it is no image shape."""
    try:
        rows, columns = (int(n) for n in shape)
    except (TypeError, ValueError):
        raise FrameError(f"shape is {shape!r}: expected two whole numbers (rows, columns)") from None
    if rows < 2 or columns < 2:
        raise FrameError(f"shape is {shape!r}: expected at least 2 rows and 2 columns")
    return rows, columns


def checked_params(params: Params | None, kind: type[Params]) -> Params:
    """Return a model's ``params``; for ``None`` the defaults of ``kind``. Raises ``ValueError`` for another kind."""
    if not isinstance(params, kind | None):
        raise ValueError(f"params must be a {kind.__name__}, got a {type(params).__name__}")
    return params or kind()


def luma(frame: npt.NDArray[Any], shape: tuple[int, int], channels: Channels = "grey") -> npt.NDArray[Any]:
    """Check one frame, and return its grey levels. Every model that ships passes its frames through this.

    Parameters
    ----------
    frame
        Grey levels from 0 to 255, uint8 or floating point, (R, C); or a colour image, uint8 of (R, C, 3).
    shape
        (R, C) that it is to have.
    channels
        What the frame has: grey levels, or the order of its colours.

    Returns
    -------
    ndarray
        (R, C), uint8 or floating point: the frame itself, or the luma of its colours (the Y of YUV, ITU-R BT.601).

    Raises
    ------
    dsnn.FrameError
        The frame has another shape or type, or values that are not finite or outside 0 to 255.
    """
    if not isinstance(frame, np.ndarray):
        raise FrameError(f"frame is a {type(frame).__name__}: expected a numpy array of shape {shape}")
    if channels != "grey":
        return _from_colour(frame, shape, channels)
    if frame.shape != shape:
        raise FrameError(f"frame has shape {frame.shape}: this model was made for {shape}{_colour_hint(frame)}")
    if frame.dtype == np.uint8:
        return frame
    if not np.issubdtype(frame.dtype, np.floating):
        raise FrameError(f"frame has type {frame.dtype}: expected uint8, or floating point in 0..255")
    # min and max propagate NaN, and a comparison with NaN is false, so one test covers both.
    if not (frame.min() >= 0.0 and frame.max() <= 255.0):
        raise FrameError(
            f"frame holds values from {frame.min():g} to {frame.max():g}: expected finite values in 0..255"
        )
    # OpenCV knows two floating types, in this machine's byte order; anything else it misreads.
    return frame if frame.dtype in (np.float32, np.float64) else frame.astype(np.float64)


def _from_colour(frame: npt.NDArray[Any], shape: tuple[int, int], channels: Channels) -> npt.NDArray[Any]:
    if not isinstance(channels, str) or channels not in _TO_GREY:
        raise FrameError(f"channels is {channels!r}: expected 'grey', 'bgr' or 'rgb'")
    if frame.shape != (*shape, 3) or frame.dtype != np.uint8:
        raise FrameError(f"frame has shape {frame.shape} and type {frame.dtype}: expected uint8 {(*shape, 3)}")
    return cv2.cvtColor(frame, _TO_GREY[channels])


def _colour_hint(frame: npt.NDArray[Any]) -> str:
    return "; name a colour frame with channels='bgr' or 'rgb'" if frame.ndim == 3 else ""
