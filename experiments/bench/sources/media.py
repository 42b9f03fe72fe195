"""Pictures that only a recording shows: camera frames and layer maps, as 8-bit images."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from experiments.bench.run.play import Showing

Images = npt.NDArray[np.uint8]
MAP_SCALES = {"p": (0.25, 128.0), "la": (1.0, 128.0), "f_on": (128.0, -16.0), "f_off": (128.0, -16.0)}
"""Layer map -> (gain, grey of zero): signed maps stand about mid grey, and all saturate.

F is some thirty times smaller than LA, hence its gain; its offset clips the noise, which would fill the file.
"""


@dataclass(frozen=True, slots=True)
class Media:
    """Pictures of one trial that a recording shows.

    Parameters
    ----------
    pictures
        Eye -> its frames, (T, R, C) uint8; the camera of the settings is called ``""``.
    exposure_ms
        Eye -> exposure time of each frame, (T,).
    row_time_us
        Eye -> from the end of a row's exposure to that of the next; 0 of a global shutter.
    maps
        The first model's layer maps, each (T, R, C); empty of a model that shows none.
    """

    pictures: Mapping[str, Images]
    exposure_ms: Mapping[str, npt.NDArray[np.float64]]
    row_time_us: Mapping[str, float]
    maps: Mapping[str, Images]


def collect(showings: Sequence[Showing], first: int = 0) -> Media:
    """Stack a trial's frames of each eye from the ``first`` on, and turn its layer maps into grey images."""
    samples = {showing.eye: showing.samples[first:] for showing in showings}
    pictures = {eye: np.stack([sample.image for sample in of_eye]) for eye, of_eye in samples.items()}
    runner = next((one for showing in showings for one in showing.runners if one.maps and not one.trouble), None)
    layers = [response.maps for response in (runner.responses[first:] if runner else []) if response.maps is not None]
    like = next(iter(pictures.values()))
    maps = {name: np.empty_like(like) for name in MAP_SCALES} if layers else {}
    for name, images in maps.items():
        gain, zero = MAP_SCALES[name]
        for image, layer in zip(images, layers, strict=True):
            cv2.addWeighted(getattr(layer, name), gain, getattr(layer, name), 0.0, zero, dst=image, dtype=cv2.CV_8U)
    return Media(
        pictures,
        {eye: np.array([sample.truth["exposure_ms"] for sample in of_eye]) for eye, of_eye in samples.items()},
        {eye: of_eye[0].truth["row_time_us"] for eye, of_eye in samples.items()},
        maps,
    )
