"""The interface of every vision model, and the response that it returns."""

from __future__ import annotations

import inspect
import warnings
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any, Generic, Protocol, Self, TypeVar, runtime_checkable

import cv2
import numpy as np
import numpy.typing as npt

from dsnn.files import USUAL_FPS
from dsnn.frames import Channels, checked_params, checked_shape, luma
from dsnn.snapshot import PARTS, Kind, pack, put, take, unpack

FloatMap = npt.NDArray[np.floating]
P = TypeVar("P")

CHANNELS = ("hs", "vs", "looming", "azimuth", "target", "elevation", "target_direction")
"""The potentials and positions that a model may return: fields of `Response`."""
SPIKING = ("hs", "vs", "looming")
"""The channels with spikes. The first one that a model declares gives a trial's spikes."""


MAP_SCALES = {"p": (0.25, 128.0), "la": (1.0, 128.0), "f_on": (128.0, -16.0), "f_off": (128.0, -16.0)}
"""Layer map -> (gain, grey of zero) of its picture. Signed maps are centred on mid grey, and all saturate.

F is about thirty times smaller than LA, hence its gain. Its offset clips the noise, which would fill a recording.
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
        The signals of the ON and OFF pathways after FDSR, never negative.
    """

    p: FloatMap
    la: FloatMap
    f_on: FloatMap
    f_off: FloatMap

    def pictures(self) -> npt.NDArray[np.uint8]:
        """Convert the maps to 8-bit images, in the order and at the scales of `MAP_SCALES`.

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
    """A model's response to one frame. Channels that the model lacks stay at their defaults.

    Parameters
    ----------
    hs
        Horizontal membrane potential of a direction model, rightward motion positive. It is in (-1, 1) unless the model
        documents another unit.
    vs
        Vertical membrane potential of a direction model, downward motion positive.
    hs_spikes, vs_spikes
        Spikes of HS and VS in this frame, with the potential's sign.
    maps
        The layers' activity, if it was requested and the model has these layers.
    looming
        Membrane potential of a looming detector, from 0.5 at rest up to 1.
    looming_spikes
        Spikes of the looming detector in this frame, 0 or more.
    azimuth
        Position of the motion in the view, from -1 at the left edge to 1 at the right.
    target
        Strength of the response to a small target, 0 or more, in a unit that the model documents. ``azimuth`` and
        ``elevation`` say where it is.
    elevation
        Position of a small target in the view, from -1 at the upper edge to 1 at the lower.
    target_direction
        Direction of a small target in degrees, from -180 to 180: 0 rightward, 90 downward.

    Examples
    --------
    >>> from dsnn import Response
    >>> response = Response(hs=0.3, hs_spikes=2)
    >>> response.hs, response.hs_spikes, response.vs
    (0.3, 2, 0.0)
    """

    hs: float = 0.0
    vs: float = 0.0
    hs_spikes: int = 0
    vs_spikes: int = 0
    maps: LayerMaps | None = None
    looming: float = 0.0
    looming_spikes: int = 0
    azimuth: float = 0.0
    target: float = 0.0
    elevation: float = 0.0
    target_direction: float = 0.0


@dataclass(frozen=True, slots=True)
class ResponseSeries:
    """The responses to T frames as columns of length T. Channels that the model lacks are 0.

    Parameters
    ----------
    hs, vs
        Membrane potentials of a direction model, (T,); see `Response`.
    hs_spikes, vs_spikes
        Spikes of HS and VS in each frame, (T,), with the potentials' signs.
    looming
        Membrane potential of a looming detector, (T,).
    looming_spikes
        Spikes of the looming detector in each frame, (T,).
    azimuth
        Position of the motion, (T,), from -1 at the left edge to 1 at the right.
    target, elevation, target_direction
        Strength, position and direction of a small target, (T,); see `Response`.
    time_s
        Time of each frame, (T,), in s, from the video; otherwise frames are 1/30 s apart.

    Examples
    --------
    >>> from dsnn import Response, ResponseSeries
    >>> series = ResponseSeries.from_responses([Response(hs_spikes=2), Response(hs_spikes=-1)])
    >>> series.accumulated_spikes("hs")
    3
    """

    hs: npt.NDArray[np.float64]
    vs: npt.NDArray[np.float64]
    hs_spikes: npt.NDArray[np.int64]
    vs_spikes: npt.NDArray[np.int64]
    looming: npt.NDArray[np.float64]
    looming_spikes: npt.NDArray[np.int64]
    azimuth: npt.NDArray[np.float64]
    target: npt.NDArray[np.float64]
    elevation: npt.NDArray[np.float64]
    target_direction: npt.NDArray[np.float64]
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
        """Stack single responses in time order.

        Parameters
        ----------
        responses
            The responses to T frames.
        time_s
            Their times in s; by default frames are 1/30 s apart.

        Returns
        -------
        ResponseSeries
            The responses as columns of length T.
        """
        each = list(responses)
        times = np.arange(len(each)) / USUAL_FPS if time_s is None else time_s
        columns: dict[str, Any] = {"time_s": np.array(times, np.float64)}
        for field in fields(cls)[:-1]:
            kind = np.int64 if field.name.endswith("_spikes") else np.float64
            columns[field.name] = np.array([getattr(response, field.name) for response in each], kind)
        return cls(**columns)


@runtime_checkable
class VisionModel(Protocol):
    """A causal model of motion vision: one frame in, one `Response` out.

    It is a protocol: any class with these methods is a model, whatever it inherits from. The shape of the frames is
    fixed when you make the model.

    Examples
    --------
    >>> from dsnn import Response
    >>> class Brightness:
    ...     def __init__(self, shape):
    ...         self.shape = shape
    ...     def step(self, frame, *, channels="grey", maps=False):
    ...         return Response(hs=float(frame.mean()) / 255.0)
    ...     def reset(self):
    ...         pass
    """

    @property
    def shape(self) -> tuple[int, int]:
        """(R, C) of the frames."""
        ...

    def step(self, frame: npt.NDArray[np.generic], *, channels: Channels = "grey", maps: bool = False) -> Response:
        """Respond to the next frame.

        Parameters
        ----------
        frame
            Grey levels from 0 to 255, uint8 or floating point, (R, C) as ``shape`` says; or a colour image, uint8 of
            (R, C, 3), which is reduced to its luma (ITU-R BT.601).
        channels
            ``grey``, or the order of the colours: ``bgr`` or ``rgb``.
        maps
            Whether to copy the layers' activity into the response. Only the DSNN's family has such layers.

        Returns
        -------
        Response
            The response, computed from this frame and the frames before it.

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
    """Base class of the built-in models: it checks shape, parameters and frames, and runs clips.

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
    form = "reference"
    _scale_known = False

    def __init__(self, shape: tuple[int, int], params: P | None, kind: type[P]) -> None:
        self.shape = checked_shape(shape)
        self.params = checked_params(params, kind)

    @abstractmethod
    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        """Compute the response to the next frame, (R, C) grey levels, with copied layer maps if ``maps`` is set."""

    def step(self, frame: npt.NDArray[Any], *, channels: Channels = "grey", maps: bool = False) -> Response:
        """Respond to the next frame.

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
        return self._respond(self._luma(frame, channels), maps)

    @abstractmethod
    def reset(self) -> None:
        """Return to the state before the first frame."""

    def get_state(self) -> bytes:
        """Save what the model keeps between two frames.

        Returns
        -------
        bytes
            The state, for `set_state` of a model of the same class, shape, parameters and form, in any process.

        Raises
        ------
        ValueError
            The model follows another's front.
        """
        return pack(self._kind(), take(self, PARTS))

    def set_state(self, state: bytes) -> None:
        """Restore a state: the next frames have the responses that they had then, to the bit.

        Parameters
        ----------
        state
            The bytes that `get_state` returned.

        Raises
        ------
        ValueError
            The bytes are no state, are damaged, or are of another model, or this model follows another's front. The
            model is then unchanged.
        """
        put(self, unpack(state, self._kind()), PARTS)

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        """Make a twin: views among the arrays, and memory of the native form, are not copied one by one."""
        form = {"form": self.form} if "form" in inspect.signature(type(self)).parameters else {}
        twin = type(self)(self.shape, self.params, **form)  # type: ignore[arg-type]
        twin.set_state(self.get_state())
        return twin

    def _kind(self) -> Kind:
        return f"{type(self).__name__} {self.shape[0]}x{self.shape[1]}", f"{self.params!r} {self.form}"

    def run(
        self, frames: Iterable[npt.NDArray[Any] | tuple[float, npt.NDArray[Any]]], *, channels: Channels = "grey"
    ) -> ResponseSeries:
        """Reset the model, then respond to every frame of a clip.

        Parameters
        ----------
        frames
            (T, R, C), or an iterable of frames for `step`. Pairs of a time in s and a frame, such as `dsnn.read_video`
            yields, work too.
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
        responses = [(time_s, self.step(frame, channels=channels)) for time_s, frame in timed]
        return ResponseSeries.from_responses([each for _, each in responses], [time_s for time_s, _ in responses])

    def _luma(self, frame: npt.NDArray[Any], channels: Channels) -> npt.NDArray[Any]:
        """Return the grey levels of a frame, checked by `luma`; warn once if they span 0 to 1 instead of 255."""
        grey = luma(frame, self.shape, channels)
        if grey.dtype != np.uint8 and not self._scale_known:
            highest = grey.max()
            # No warning for masks of two levels: 0 and 1 may be intended.
            fractions = highest <= 1 and bool(((grey > grey.min()) & (grey < highest)).any())
            self._scale_known = bool(highest > 1) or fractions
            if fractions:
                problem = "the grey levels of this frame go up to 1, which is all but black"
                warnings.warn(f"{type(self).__name__}: {problem}; white is 255, so multiply them by 255", stacklevel=3)
        return grey
