"""Pictures that only a recording shows: camera frames and layer maps, as 8-bit images."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from dsnn.model import MAP_SCALES
from experiments.bench.run.play import Showing

Images = npt.NDArray[np.uint8]


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
    """Stack a trial's frames of each eye from the ``first`` on, and the pictures of its layer maps."""
    samples = {showing.eye: showing.samples[first:] for showing in showings}
    pictures = {eye: np.stack([sample.image for sample in of_eye]) for eye, of_eye in samples.items()}
    runners = (runner for showing in showings for runner in showing.runners if not runner.trouble)
    layers = next((runner.pictures[first:] for runner in runners if runner.pictures), [])
    maps = dict(zip(MAP_SCALES, np.stack(layers, axis=1), strict=True)) if layers else {}
    return Media(
        pictures,
        {eye: np.array([sample.truth["exposure_ms"] for sample in of_eye]) for eye, of_eye in samples.items()},
        {eye: of_eye[0].truth["row_time_us"] for eye, of_eye in samples.items()},
        maps,
    )
