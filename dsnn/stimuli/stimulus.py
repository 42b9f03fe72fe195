"""The base of every stimulus: a sequence of frames, each with the truth about what moves in it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import parameters, unit

Luma = npt.NDArray[np.uint8]


class Velocity(NamedTuple):
    """A velocity in the image, in px/s.

    Parameters
    ----------
    x
        Rightward positive.
    y
        Downward positive.
    """

    x: float
    y: float


STILL = Velocity(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Box:
    """An upright rectangle in px. Pixel (r, c) covers the square from (c, r) to (c + 1, r + 1).

    Parameters
    ----------
    left, top
        Its upper left corner: column and row, px.
    width, height
        Its size, px.
    """

    left: float
    top: float
    width: float
    height: float

    @classmethod
    def about(cls, x: float, y: float, width: float, height: float) -> Box:
        """Make a box about its centre.

        Parameters
        ----------
        x, y
            Column and row of the centre, px.
        width, height
            Its size, px.

        Returns
        -------
        Box
            The box.
        """
        return cls(x - width / 2, y - height / 2, width, height)

    def shifted(self, x: float, y: float) -> Box:
        """Shift the box.

        Parameters
        ----------
        x, y
            How far to the right and down, px.

        Returns
        -------
        Box
            A box of the same size there.
        """
        return Box(self.left + x, self.top + y, self.width, self.height)

    def touches(self, shape: tuple[int, int]) -> bool:
        """Tell whether any part of it is inside a frame.

        Parameters
        ----------
        shape
            (R, C) of the frame.

        Returns
        -------
        bool
            Whether it is.
        """
        rows, columns = shape
        return self.left < columns and self.left + self.width > 0 and self.top < rows and self.top + self.height > 0


@dataclass(frozen=True, slots=True)
class Truth:
    """Truth about the motion in one frame.

    Parameters
    ----------
    motion
        A word for it: ``rightward``, ``looming``, ``still``, ...
    box
        The whole outline of the object, parts outside the frame included; ``None`` while no object is in the frame.
    velocity
        That of the object's centre, px/s; ``None`` while no object is in the frame.
    background_velocity
        That of everything else, px/s.
    time_to_contact_s
        Seconds to a looming object's contact; negative since a receding one's; otherwise ``None``.
    """

    motion: str
    box: Box | None = None
    velocity: Velocity | None = None
    background_velocity: Velocity = STILL
    time_to_contact_s: float | None = None

    def without_object(self) -> Truth:
        """Leave out the object.

        Returns
        -------
        Truth
            The truth about the background alone.
        """
        return Truth("still", background_velocity=self.background_velocity)


@dataclass(frozen=True, slots=True)
class StimulusFrame:
    """One frame and its truth.

    Parameters
    ----------
    luma
        The picture, (R, C), grey levels.
    truth
        What moves in it.
    """

    luma: Luma
    truth: Truth


@parameters
class ClipParams:
    """Parameters of every stimulus: a frame's size and the rate."""

    rows: Annotated[int, unit("px")] = Field(default=180, ge=8, le=4096)
    """Rows of a frame (paper: 180)."""
    columns: Annotated[int, unit("px")] = Field(default=320, ge=8, le=4096)
    """Columns of a frame (paper: 320, clutter 540)."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, ge=1.0, le=1000.0)
    """Frame rate (paper: 30)."""


@parameters
class TimedParams(ClipParams):
    """A stimulus that moves for a given time, after a rest in which the first frame stands still."""

    rest_s: Annotated[float, unit("s")] = Field(default=0.3, ge=0.0, le=60.0)
    """Stillness before the motion."""
    duration_s: Annotated[float, unit("s")] = Field(default=2.0, gt=0.0, le=600.0)
    """Duration of the motion."""

    def rest_frames(self) -> int:
        """Count the frames of the rest before the motion.

        Returns
        -------
        int
            The index of the frame from which on it moves.
        """
        return round(self.rest_s * self.fps)

    def moving_frames(self) -> int:
        """Count the displacements, one a frame.

        Returns
        -------
        int
            Their number, 1 or more.
        """
        return max(1, round(self.duration_s * self.fps))


P = TypeVar("P", bound=ClipParams, covariant=True)


class Stimulus(ABC, Generic[P]):
    """A clip: ``len(clip)`` frames, painted as they are asked for, any number of times.

    A subclass says how many frames there are (``__len__``) and paints one (`frame`) as a function of its
    index, ``params`` and ``seed`` alone; so equal seeds give equal bytes, whatever was asked for before.
    ``clip[index]`` is a frame too, from the end where ``index`` is below 0.

    Parameters
    ----------
    params
        The parameters, with ``rows``, ``columns`` and ``fps``.
    seed
        Of what is random in it, 0 or more.

    Raises
    ------
    ValueError
        The seed is below 0.

    Examples
    --------
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", speed=120.0, motion="leftward")
    >>> clip[60].luma.shape, clip[60].truth.velocity
    ((180, 320), Velocity(x=-120.0, y=0.0))
    """

    def __init__(self, params: P, seed: int = 0) -> None:
        if not isinstance(seed, int | np.integer) or seed < 0:
            raise ValueError(f"seed={seed!r}: legal is a whole number from 0 up")
        self.params = params
        self.seed = seed

    @property
    def shape(self) -> tuple[int, int]:
        """(R, C) of the frames."""
        return self.params.rows, self.params.columns

    @property
    def fps(self) -> float:
        """Frames per second."""
        return self.params.fps

    @abstractmethod
    def __len__(self) -> int: ...

    @abstractmethod
    def frame(self, index: int) -> StimulusFrame:
        """Paint a frame, as the light stands at ``index / fps`` seconds.

        Parameters
        ----------
        index
            From 0 to ``len(clip) - 1``.

        Returns
        -------
        StimulusFrame
            The frame and its truth.
        """

    def __iter__(self) -> Iterator[StimulusFrame]:
        return (self.frame(index) for index in range(len(self)))

    def __getitem__(self, index: int) -> StimulusFrame:
        return self.frame(range(len(self))[index])


T = TypeVar("T", bound=TimedParams, covariant=True)


class TimedStimulus(Stimulus[T]):
    """A clip of a rest, then a motion for a given time."""

    def __len__(self) -> int:
        return self.params.rest_frames() + self.params.moving_frames() + 1
