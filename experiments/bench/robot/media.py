"""What only a recording shows: camera frames and layer maps, as 8-bit images."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from colias_sim import Frame
from dsnn import Response

Images = npt.NDArray[np.uint8]
MAP_SCALES = {"p": (0.25, 128.0), "la": (1.0, 128.0), "f_on": (128.0, -16.0), "f_off": (128.0, -16.0)}
"""Layer map -> (gain, grey of zero): signed maps stand about mid grey, and all saturate.

F is some thirty times smaller than LA, hence its gain; its offset clips the noise, which would fill the file.
"""


@dataclass(frozen=True, slots=True)
class Media:
    """Images of one trial, each (T, R, C); ``maps`` is empty for a model that shows no layers."""

    camera: Images
    maps: dict[str, Images]


def collect(frames: Sequence[Frame], responses: Sequence[Response]) -> Media:
    """Stack a trial's frames and turn its layer maps into grey images by `MAP_SCALES`."""
    camera = np.stack([frame.luma for frame in frames])
    shown = [response.maps for response in responses if response.maps is not None]
    maps = {name: np.empty_like(camera) for name in MAP_SCALES} if shown else {}
    for name, images in maps.items():
        gain, zero = MAP_SCALES[name]
        for image, layers in zip(images, shown, strict=True):
            cv2.addWeighted(getattr(layers, name), gain, getattr(layers, name), 0.0, zero, dst=image, dtype=cv2.CV_8U)
    return Media(camera, maps)
