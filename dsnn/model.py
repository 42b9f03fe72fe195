"""What every vision model offers, and the value it answers with."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from dsnn.frames import Channels

FloatMap = npt.NDArray[np.floating]

CHANNELS = ("hs", "vs", "looming", "azimuth")
"""The potentials and positions that a model may answer by: fields of `Response`."""
SPIKING = ("hs", "vs", "looming")
"""Those of `CHANNELS` that have spikes, in the order in which a trial's spikes are taken from a model's own."""


@dataclass(frozen=True, slots=True)
class LayerMaps:
    """Copies of the layers' activity after one frame, each of the frame's shape (R, C).

    ``p``: retina, change of luminance in grey levels. ``la``: lamina, signed.
    ``f_on`` and ``f_off``: the pathways' signals after FDSR, never negative.
    """

    p: FloatMap
    la: FloatMap
    f_on: FloatMap
    f_off: FloatMap


@dataclass(frozen=True, slots=True)
class Response:
    """A model's answer to one frame; a channel that the model does not have stays at its default.

    ``hs`` and ``vs`` are a direction model's membrane potentials: rightward and
    downward motion positive, in (-1, 1) unless the model names another unit.
    Their spikes are counts per frame carrying the potential's sign. ``looming``
    is a looming detector's membrane potential, from 0.5 at rest up to 1.
    ``azimuth`` is where in the view the motion is, from -1 at its left edge to 1 at its right.
    ``maps`` are there if they were asked for and the model has these layers.
    """

    hs: float = 0.0
    vs: float = 0.0
    hs_spikes: int = 0
    vs_spikes: int = 0
    maps: LayerMaps | None = None
    looming: float = 0.0
    looming_spikes: int = 0
    azimuth: float = 0.0


@dataclass(frozen=True, slots=True)
class ResponseSeries:
    """Answers to T frames as columns of length T: potentials and azimuth float64, spikes int64.

    A channel that the model does not have is 0 throughout.
    """

    hs: npt.NDArray[np.float64]
    vs: npt.NDArray[np.float64]
    hs_spikes: npt.NDArray[np.int64]
    vs_spikes: npt.NDArray[np.int64]
    looming: npt.NDArray[np.float64]
    looming_spikes: npt.NDArray[np.int64]
    azimuth: npt.NDArray[np.float64]

    def accumulated_spikes(self, channel: str) -> int:
        """Number of spikes of either sign, over all frames, in ``channel``: one of `SPIKING`, or 0 for any other."""
        return int(np.abs(getattr(self, f"{channel}_spikes")).sum()) if channel in SPIKING else 0

    @classmethod
    def from_responses(cls, responses: Iterable[Response]) -> ResponseSeries:
        """Stack single answers in time order."""
        answers = list(responses)
        return cls(
            hs=np.array([a.hs for a in answers], np.float64),
            vs=np.array([a.vs for a in answers], np.float64),
            hs_spikes=np.array([a.hs_spikes for a in answers], np.int64),
            vs_spikes=np.array([a.vs_spikes for a in answers], np.int64),
            looming=np.array([a.looming for a in answers], np.float64),
            looming_spikes=np.array([a.looming_spikes for a in answers], np.int64),
            azimuth=np.array([a.azimuth for a in answers], np.float64),
        )


@runtime_checkable
class VisionModel(Protocol):
    """A causal model of motion vision: one frame in, one `Response` out.

    ``shape`` is (R, C), fixed at construction. ``step`` takes the next frame (see
    `dsnn.frames.luma` for what is accepted) and raises `dsnn.frames.FrameError`
    for anything else; ``maps`` asks for `LayerMaps`, which only the DSNN's family
    has. ``reset`` returns to the state before the first frame.
    """

    @property
    def shape(self) -> tuple[int, int]:
        """(R, C) of the frames."""
        ...

    def step(self, frame: npt.NDArray[np.generic], *, channels: Channels = "grey", maps: bool = False) -> Response:
        """Answer the next frame."""
        ...

    def reset(self) -> None:
        """Forget every frame."""
        ...


def run_model(
    model: VisionModel, frames: Iterable[npt.NDArray[np.generic]], *, channels: Channels = "grey"
) -> ResponseSeries:
    """Reset ``model`` and step it through ``frames``, a (T, R, C) array or any iterable of frames."""
    model.reset()
    return ResponseSeries.from_responses(model.step(frame, channels=channels) for frame in frames)
