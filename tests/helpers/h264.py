"""Reading a video back, with OpenCV's decoder and the encoder's own report on a file."""

from __future__ import annotations

import subprocess
from pathlib import Path

import cv2
import numpy as np


def decoded(path: Path) -> list[np.ndarray]:
    """Every frame, (H, W, 3) uint8, RGB."""
    source, frames = cv2.VideoCapture(str(path)), []
    while (frame := source.read()[1]) is not None:
        frames.append(frame[..., ::-1])
    source.release()
    return frames


def report(path: Path) -> str:
    """What ffmpeg says of a file: codec, format of pixels, size, rate."""
    import imageio_ffmpeg

    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-hide_banner", "-i", str(path)]
    return subprocess.run(command, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL).stderr
