"""Check the frames, shapes and parameters that models receive."""

from __future__ import annotations

from typing import Any, Literal, TypeVar

import cv2
import numpy as np
import numpy.typing as npt

Channels = Literal["grey", "bgr", "rgb"]
Params = TypeVar("Params")
Scalar = TypeVar("Scalar", bound=np.generic)

_TO_GREY = {"bgr": cv2.COLOR_BGR2GRAY, "rgb": cv2.COLOR_RGB2GRAY}


class FrameError(ValueError):
    """The model cannot process this frame or shape. The message names the value and its bound."""


def frozen(luma: npt.NDArray[Scalar]) -> npt.NDArray[Scalar]:
    """Return a read-only copy of a frame (R, C), or a view of one that is already read-only.

    Several models, a recording and an agent receive the same frame. The copy lies in an immutable object, so that no
    model can make it writable again. Each gets its own view, so that none can change the others' shape or type.
    """
    if not luma.flags.writeable:
        return luma.view()
    return np.frombuffer(luma.tobytes(), luma.dtype).reshape(luma.shape)


def checked_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return ``shape`` as two ints (R, C); `FrameError` if it is not an image shape."""
    try:
        rows, columns = (int(n) for n in shape)
    except (TypeError, ValueError):
        raise FrameError(f"shape must be two whole numbers (rows, columns), got {shape!r}") from None
    if rows < 2 or columns < 2:
        raise FrameError(f"shape must be at least 2 rows and 2 columns, got {shape!r}")
    return rows, columns


def checked_params(params: Params | None, kind: type[Params]) -> Params:
    """Return a model's ``params``, or the defaults of ``kind`` for ``None``; ``ValueError`` for another class."""
    if not isinstance(params, kind | None):
        raise ValueError(f"params must be a {kind.__name__}, got a {type(params).__name__}")
    return params or kind()


def luma(frame: npt.NDArray[Any], shape: tuple[int, int], channels: Channels = "grey") -> npt.NDArray[Any]:
    """Check a frame and return its grey levels, as every built-in model does.

    Parameters
    ----------
    frame
        Grey levels from 0 to 255, uint8 or floating point, (R, C); or a colour image, uint8 of (R, C, 3).
    shape
        (R, C) that the frame must have.
    channels
        ``grey``, or the order of its colours: ``bgr`` or ``rgb``.

    Returns
    -------
    ndarray
        (R, C), uint8 or floating point: the frame itself, or the luma of its colours (the Y of YUV, ITU-R BT.601).

    Raises
    ------
    dsnn.FrameError
        The frame has another shape or type, or values that are not finite or outside 0 to 255.

    Examples
    --------
    >>> import numpy as np
    >>> from dsnn.frames import luma
    >>> luma(np.zeros((72, 99, 3), np.uint8), (72, 99), "rgb").shape
    (72, 99)
    """
    if not isinstance(frame, np.ndarray):
        raise FrameError(f"frame must be a numpy array of shape {shape}, got a {type(frame).__name__}")
    if channels != "grey":
        return _from_colour(frame, shape, channels)
    if frame.shape != shape:
        raise FrameError(f"frame must have the model's shape {shape}, got {frame.shape}{_colour_hint(frame)}")
    if frame.dtype == np.uint8:
        return frame
    if not np.issubdtype(frame.dtype, np.floating):
        raise FrameError(f"frame must be uint8, or floating point in 0..255, got {frame.dtype}")
    # min and max propagate NaN, and a comparison with NaN is false, so one test covers both.
    if not (frame.min() >= 0.0 and frame.max() <= 255.0):
        raise FrameError(f"frame must hold values between 0 and 255, got {frame.min():g} to {frame.max():g}")
    # OpenCV knows two floating types, in this machine's byte order; anything else it misreads.
    return frame if frame.dtype in (np.float32, np.float64) else frame.astype(np.float64)


def _from_colour(frame: npt.NDArray[Any], shape: tuple[int, int], channels: Channels) -> npt.NDArray[Any]:
    if not isinstance(channels, str) or channels not in _TO_GREY:
        raise FrameError(f"channels must be 'grey', 'bgr' or 'rgb', got {channels!r}")
    if frame.shape != (*shape, 3) or frame.dtype != np.uint8:
        raise FrameError(f"frame must be uint8 of shape {(*shape, 3)}, got {frame.dtype} of shape {frame.shape}")
    return cv2.cvtColor(frame, _TO_GREY[channels])


def _colour_hint(frame: npt.NDArray[Any]) -> str:
    return "; name a colour frame with channels='bgr' or 'rgb'" if frame.ndim == 3 else ""
