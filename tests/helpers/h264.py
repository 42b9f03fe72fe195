"""Reading a video back, with PyAV and the encoder's own report on a file."""

from __future__ import annotations

import subprocess
from pathlib import Path

import av
import numpy as np


def decoded(path: Path) -> list[np.ndarray]:
    """Every frame, (H, W, 3) uint8, RGB."""
    with av.open(str(path)) as film:
        return [frame.to_ndarray(format="rgb24") for frame in film.decode(video=0)]


def report(path: Path) -> str:
    """What ffmpeg says of a file: codec, format of pixels, size, rate."""
    import imageio_ffmpeg

    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-hide_banner", "-i", str(path)]
    return subprocess.run(command, capture_output=True, text=True, check=False, stdin=subprocess.DEVNULL).stderr
