"""Films of a street with somebody who crosses it: the stimulus of that name, whose truth is known, as a video file."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from dsnn.stimuli import Stimulus, stimulus

FPS = 30.0


def street(speed: float = 100.0, **changes: Any) -> Stimulus:
    """Somebody, 140 px tall, who crosses 320 px rightward at ``speed`` px/s."""
    return stimulus(
        "street", speed=speed, height=140.0, grey=10.0, ground="even", ground_grey=200.0, rest_s=0.0, **changes
    )


def write(path: Path, pictures: Iterable[np.ndarray], fps: float = FPS, codec: str = "MJPG") -> Path:
    """Write pictures of one size, (R, C) or BGR, through OpenCV."""
    writer = None
    for picture in pictures:
        if writer is None:
            writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), fps, picture.shape[1::-1])
            assert writer.isOpened()
        writer.write(picture if picture.ndim == 3 else cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR))
    assert writer is not None
    writer.release()
    return path


def film(path: Path, clip: Iterable[Any], frames: int | None = None, **more: Any) -> Path:
    """Write the first frames of a clip."""
    lumas = [frame.luma for frame in clip]
    return write(path, lumas[:frames], **more)
