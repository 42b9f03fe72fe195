"""Mean dense optical flow, an engineer's baseline."""

from __future__ import annotations

from typing import Any, Literal

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.field_docs import parameters
from dsnn.filters import total
from dsnn.frames import FrameError
from dsnn.model import Model, Response

PRESETS = {
    "ultrafast": cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST,
    "fast": cv2.DISOPTICAL_FLOW_PRESET_FAST,
    "medium": cv2.DISOPTICAL_FLOW_PRESET_MEDIUM,
}

MIN_SIZE = 32
"""Least length of either side, px: OpenCV's DIS reads outside smaller images, and crashes (its patches are 8 px at
quarter size).
"""


@parameters
class FlowParams:
    """Parameters of the optical flow: OpenCV's preset for dense inverse search (DIS)."""

    preset: Literal["ultrafast", "fast", "medium"] = "ultrafast"
    """OpenCV's preset of DIS, from coarse and quick to fine and slow."""


class Flow(Model[FlowParams]):
    """Mean of the dense flow between this frame and the one before, by dense inverse search (DIS).

    The flow is computed by OpenCV with its presets. Channels: ``hs`` and ``vs``, mean horizontal and vertical flow over
    all pixels in px per frame, right and down positive. They are not membrane potentials, are unbounded, and have no
    spikes. Both are 0 on the first frame. Floating-point frames are rounded to 8 bits, which DIS requires. Its patches
    lie on a grid from the upper left corner, so a mirrored clip gives only approximately the mirrored response.

    Assumed: HS and VS are the means over all pixels, which is our choice. OpenCV's constants replace the paper's.

    Costs about 1.6 DSNN steps at 99x72 with the preset ``ultrafast``.

    Parameters
    ----------
    shape
        (R, C) of the frames, 32 or more each.
    params
        The constants; by default ``FlowParams()``.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 32 up.

    References
    ----------
    Kroeger, Timofte, Dai and Van Gool 2016, ECCV (DIS).

    Examples
    --------
    >>> from dsnn import Flow
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", motion="leftward", rows=72, columns=99, width=20, height=40)
    >>> series = Flow(clip.shape).run(frame.luma for frame in clip)
    >>> bool(series.hs.min() < -0.1)
    True
    """

    def __init__(self, shape: tuple[int, int], params: FlowParams | None = None) -> None:
        super().__init__(shape, params, FlowParams)
        if min(self.shape) < MIN_SIZE:
            raise FrameError(f"shape must be at least {MIN_SIZE} rows and columns for optical flow, got {self.shape}")
        self._dis = cv2.DISOpticalFlow.create(PRESETS[self.params.preset])
        self._before, self._now = np.zeros((2, *self.shape), np.uint8)
        self._flow = np.zeros((*self.shape, 2), np.float32)
        self.reset()

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._first = True

    @property
    def local_motion(self) -> npt.NDArray[np.float32]:
        """The flow of the last frame, (R, C, 2), px since the frame before, right and down positive; a copy."""
        return np.zeros_like(self._flow) if self._first else self._flow.copy()

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        self._before, self._now = self._now, self._before
        if luminance.dtype == np.uint8:
            np.copyto(self._now, luminance)
        else:
            cv2.convertScaleAbs(luminance, self._now)
        if self._first:
            self._first = False
            return Response()
        self._flow[:] = 0.0  # where the search starts: what the buffer holds
        flow = self._dis.calc(self._before, self._now, self._flow)
        hs, vs = (total(flow[..., axis]) / luminance.size for axis in (0, 1))
        return Response(hs, vs)
