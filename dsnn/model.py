"""The interface of every vision model, and the value it answers with."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any, Generic, Protocol, TypeVar, runtime_checkable

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.frames import Channels, checked_params, checked_shape, luma

FloatMap = npt.NDArray[np.floating]
Clip = Iterable[npt.NDArray[Any] | tuple[float, npt.NDArray[Any]]]
"""A (T, R, C) array, or any iterable of frames, or of pairs of a frame's time in s and the frame."""
USUAL_FPS = 30.0
"""Frames per second that the models' constants belong to."""
P = TypeVar("P")

CHANNELS = ("hs", "vs", "looming", "azimuth")
"""The potentials and positions that a model may answer by: fields of `Response`."""
SPIKING = ("hs", "vs", "looming")
"""Channels, of `CHANNELS`, that have spikes, in the order in which a trial's spikes are taken from a model's own."""


MAP_SCALES = {"p": (0.25, 128.0), "la": (1.0, 128.0), "f_on": (128.0, -16.0), "f_off": (128.0, -16.0)}
"""Layer map -> (gain, grey of zero) of its picture: signed maps stand about mid grey, and all saturate.

F is some thirty times smaller than LA, hence its gain; its offset clips the noise, which would fill a recording.
"""


@dataclass(frozen=True, slots=True)
class LayerMaps:
    """Copies of the layers' activity after one frame, each of the frame's shape (R, C).

    Parameters
    ----------
    p
        Retina: the change of luminance in grey levels.
    la
        Lamina: the difference of Gaussians of ``p``, signed.
    f_on, f_off
        The signals of the ON and the OFF pathway after FDSR, never negative.
    """

    p: FloatMap
    la: FloatMap
    f_on: FloatMap
    f_off: FloatMap

    def pictures(self) -> npt.NDArray[np.uint8]:
        """Return the maps as 8-bit images, in the order and at the scales of `MAP_SCALES`.

        Returns
        -------
        ndarray
            (4, R, C) uint8.
        """
        pictures = np.empty((len(MAP_SCALES), *self.p.shape), np.uint8)
        for picture, (name, (gain, zero)) in zip(pictures, MAP_SCALES.items(), strict=True):
            layer = getattr(self, name)
            cv2.addWeighted(layer, gain, layer, 0.0, zero, dst=picture, dtype=cv2.CV_8U)
        return pictures


@dataclass(frozen=True, slots=True)
class Response:
    """A model's answer to one frame; a channel that the model does not have stays at its default.

    Parameters
    ----------
    hs
        A direction model's horizontal membrane potential: rightward motion positive, in (-1, 1) unless the model names
        another unit.
    vs
        Its vertical one: downward motion positive.
    hs_spikes, vs_spikes
        Their spikes in this frame, with the potential's sign.
    maps
        The layers' activity, if it was asked for and the model has these layers.
    looming
        A looming detector's membrane potential, from 0.5 at rest up to 1.
    looming_spikes
        Its spikes in this frame, 0 or more.
    azimuth
        Where in the view the motion is, from -1 at its left edge to 1 at its right.
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
    """Answers to T frames as columns of length T. A channel that the model does not have is 0 throughout.

    Parameters
    ----------
    hs, vs
        Membrane potentials of a direction model, (T,); see `Response`.
    hs_spikes, vs_spikes
        Their spikes in each frame, (T,), with the potentials' signs.
    looming
        Membrane potential of a looming detector, (T,).
    looming_spikes
        Its spikes in each frame, (T,).
    azimuth
        Where the motion is, (T,), from -1 at the left edge to 1 at the right.
    time_s
        Time of each frame, (T,), in s: that of a film, otherwise 1/30 s a frame, to which the models' constants belong.
    """

    hs: npt.NDArray[np.float64]
    vs: npt.NDArray[np.float64]
    hs_spikes: npt.NDArray[np.int64]
    vs_spikes: npt.NDArray[np.int64]
    looming: npt.NDArray[np.float64]
    looming_spikes: npt.NDArray[np.int64]
    azimuth: npt.NDArray[np.float64]
    time_s: npt.NDArray[np.float64]

    def accumulated_spikes(self, channel: str) -> int:
        """Count the spikes of either sign over all frames.

        Parameters
        ----------
        channel
            ``hs``, ``vs`` or ``looming``.

        Returns
        -------
        int
            The number of spikes; 0 for any other channel.
        """
        return int(np.abs(getattr(self, f"{channel}_spikes")).sum()) if channel in SPIKING else 0

    @classmethod
    def from_responses(cls, responses: Iterable[Response], time_s: Sequence[float] | None = None) -> ResponseSeries:
        """Stack single answers in time order.

        Parameters
        ----------
        responses
            The answers to T frames.
        time_s
            Their times in s; otherwise 1/30 s a frame.

        Returns
        -------
        ResponseSeries
            The same as columns.
        """
        answers = list(responses)
        times = np.arange(len(answers)) / USUAL_FPS if time_s is None else time_s
        columns: dict[str, Any] = {"time_s": np.array(times, np.float64)}
        for field in fields(cls)[:-1]:
            kind = np.int64 if field.name.endswith("_spikes") else np.float64
            columns[field.name] = np.array([getattr(answer, field.name) for answer in answers], kind)
        return cls(**columns)


@runtime_checkable
class VisionModel(Protocol):
    """A causal model of motion vision: one frame in, one `Response` out.

    It is a protocol: a class that has these is a model, whatever it inherits from. The shape of its frames is fixed
    when it is made.
    """

    @property
    def shape(self) -> tuple[int, int]:
        """(R, C) of the frames."""
        ...

    def step(self, frame: npt.NDArray[np.generic], *, channels: Channels = "grey", maps: bool = False) -> Response:
        """Answer the next frame.

        Parameters
        ----------
        frame
            Grey levels from 0 to 255, uint8 or floating point, (R, C) as ``shape`` says; or a colour image, uint8 of
            (R, C, 3), which is reduced to its luma (ITU-R BT.601).
        channels
            What the frame has: grey levels, or the order of its colours.
        maps
            Whether to copy the layers' activity into the response. Only the DSNN's family has such layers; other
            models leave ``maps`` empty.

        Returns
        -------
        Response
            The answer to this frame, of this frame and those before it.

        Raises
        ------
        dsnn.FrameError
            The frame has another shape or type, or values that are not finite or outside 0 to 255.
        """
        ...

    def reset(self) -> None:
        """Return to the state before the first frame."""
        ...


class Model(ABC, Generic[P]):
    """Base class of the models that ship: it checks shape, parameters and frames, and runs clips.

    Parameters
    ----------
    shape
        (R, C) of the frames.
    params
        The parameters; the defaults of ``kind`` if None.
    kind
        The class of the parameters.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.
    ValueError
        ``params`` is of another class.
    """

    shape: tuple[int, int]
    params: P
    _scale_known = False

    def __init__(self, shape: tuple[int, int], params: P | None, kind: type[P]) -> None:
        self.shape = checked_shape(shape)
        self.params = checked_params(params, kind)

    @abstractmethod
    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        """Return the response to the next frame, (R, C) grey levels; copy the layers' maps into it if asked to."""

    def step(self, frame: npt.NDArray[Any], *, channels: Channels = "grey", maps: bool = False) -> Response:
        """Answer the next frame.

        Parameters, returns and errors are those of `dsnn.VisionModel.step`.
        """
        return self._respond(self._luma(frame, channels), maps)

    @abstractmethod
    def reset(self) -> None:
        """Return to the state before the first frame."""

    def run(self, frames: Clip, *, channels: Channels = "grey") -> ResponseSeries:
        """Reset, then answer every frame of a clip.

        Parameters
        ----------
        frames
            (T, R, C), or any iterable of frames as `step` takes them, or of pairs of a time in s and a frame, such as
            `dsnn.read_video` yields.
        channels
            As of `step`.

        Returns
        -------
        ResponseSeries
            The responses as columns of length T.

        Raises
        ------
        dsnn.FrameError
            As of `step`.
        """
        self.reset()
        timed = (one if isinstance(one, tuple) else (index / USUAL_FPS, one) for index, one in enumerate(frames))
        answers = [(time_s, self.step(frame, channels=channels)) for time_s, frame in timed]
        return ResponseSeries.from_responses([answer for _, answer in answers], [time_s for time_s, _ in answers])

    def _luma(self, frame: npt.NDArray[Any], channels: Channels) -> npt.NDArray[Any]:
        """Return the grey levels of a frame, checked by `luma`; warn once where they go from 0 to 1, not to 255."""
        grey = luma(frame, self.shape, channels)
        if grey.dtype != np.uint8 and not self._scale_known:
            highest = grey.max()
            # Masks of two levels are left alone: 0 and 1 may be meant.
            fractions = highest <= 1 and bool(((grey > grey.min()) & (grey < highest)).any())
            self._scale_known = bool(highest > 1) or fractions
            if fractions:
                problem = "the grey levels of this frame go up to 1, which is all but black"
                warnings.warn(f"{type(self).__name__}: {problem}; white is 255, so multiply them by 255", stacklevel=3)
        return grey
