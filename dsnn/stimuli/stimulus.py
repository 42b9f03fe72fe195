"""The base class of stimuli: a sequence of frames, each with the truth about its motion."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, ClassVar, Generic, TypeVar, cast

import numpy as np
import numpy.typing as npt
from pydantic import Field

from dsnn.field_docs import parameters, unit

Luma = npt.NDArray[np.uint8]


Velocity = tuple[float, float]
"""A velocity in the image: x and y, px/s, rightward and downward positive."""
STILL: Velocity = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Box:
    """An upright rectangle in px. Pixel (r, c) covers the square from (c, r) to (c + 1, r + 1).

    Parameters
    ----------
    left, top
        Its upper left corner: column and row, px.
    width, height
        Its size, px.

    Examples
    --------
    >>> from dsnn.stimuli import Box
    >>> Box.about(10.0, 20.0, width=4.0, height=6.0)
    Box(left=8.0, top=17.0, width=4.0, height=6.0)
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
            Distances to the right and down, px.

        Returns
        -------
        Box
            A box of the same size at the new place.
        """
        return Box(self.left + x, self.top + y, self.width, self.height)

    def touches(self, shape: tuple[int, int]) -> bool:
        """Check whether any part of the box is inside a frame.

        Parameters
        ----------
        shape
            (R, C) of the frame.

        Returns
        -------
        bool
            Whether any part is inside.
        """
        rows, columns = shape
        return self.left < columns and self.left + self.width > 0 and self.top < rows and self.top + self.height > 0


@dataclass(frozen=True, slots=True)
class Truth:
    """The truth about the motion in one frame.

    Parameters
    ----------
    motion
        Name of the motion: ``rightward``, ``looming``, ``still``, ...
    box
        The whole outline of the object, including parts outside the frame; ``None`` while no object is in the frame.
    velocity
        Velocity (x, y) of the object's centre, px/s, rightward and downward positive; ``None`` while no object is in
        the frame.
    background_velocity
        Velocity of everything else, likewise.
    time_to_contact_s
        Time to a looming object's contact, s. For a receding object it is negative: the time since contact. Otherwise
        ``None``.

    Examples
    --------
    >>> from dsnn.stimuli import stimulus
    >>> truth = stimulus("looming")[60].truth
    >>> truth.motion, truth.time_to_contact_s > 0.0
    ('looming', True)
    """

    motion: str
    box: Box | None = None
    velocity: Velocity | None = None
    background_velocity: Velocity = STILL
    time_to_contact_s: float | None = None

    def without_object(self) -> Truth:
        """Remove the object from the truth.

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
        The truth about its motion.
    """

    luma: Luma
    truth: Truth


@parameters
class ClipParams:
    """Parameters of every stimulus: the frame's size and the frame rate."""

    rows: Annotated[int, unit("px")] = Field(default=180, ge=8, le=4096)
    """Rows of a frame (paper: 180)."""
    columns: Annotated[int, unit("px")] = Field(default=320, ge=8, le=4096)
    """Columns of a frame (paper: 320, clutter 540)."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, ge=1.0, le=1000.0)
    """Frame rate (paper: 30)."""


@parameters
class TimedParams(ClipParams):
    """Parameters of a stimulus that moves for a given time, after a rest."""

    rest_s: Annotated[float, unit("s")] = Field(default=0.3, ge=0.0, le=60.0)
    """Stillness before the motion."""
    duration_s: Annotated[float, unit("s")] = Field(default=2.0, gt=0.0, le=600.0)
    """Duration of the motion."""

    def rest_frames(self) -> int:
        """Count the frames of the rest before the motion.

        Returns
        -------
        int
            Their number, which is the index of the first frame that moves.
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
    """Base class of clips: ``len(clip)`` frames, painted on demand, any number of times.

    A subclass defines the number of frames (``__len__``) and paints one (`frame`). A frame depends only on its index,
    ``params`` and ``seed``, so equal seeds give equal bytes in any order. On another CPU a pixel may have
    the next grey level. ``clip[index]`` is a frame too; a negative index counts from the end.

    Parameters
    ----------
    params
        The parameters, with ``rows``, ``columns`` and ``fps``.
    seed
        Seed of its random parts, 0 or more.

    Raises
    ------
    ValueError
        The seed is below 0.

    Examples
    --------
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", speed=120.0, motion="leftward")
    >>> clip[60].luma.shape, clip[60].truth.velocity
    ((180, 320), (-120.0, 0.0))
    """

    is_continuous: ClassVar[bool] = False
    """Whether `frame` paints moments between two frames too, for a fraction as index."""

    def __init__(self, params: P, seed: int = 0) -> None:
        if not isinstance(seed, int | np.integer) or seed < 0:
            raise ValueError(f"seed must be a whole number from 0 up, got {seed!r}")
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
        """Paint the frame at ``index / fps`` seconds.

        Parameters
        ----------
        index
            From 0 to ``len(clip) - 1``.

        Returns
        -------
        StimulusFrame
            The frame and its truth.
        """

    def at(self, index: float) -> StimulusFrame:
        """Paint the moment at ``index / fps`` seconds.

        Parameters
        ----------
        index
            From 0 to ``len(clip) - 1``, between two frames too.

        Returns
        -------
        StimulusFrame
            What is there at this moment. A stimulus that moves in steps keeps the frame before.
        """
        return self.frame(cast(int, index) if self.is_continuous else int(index))

    def __iter__(self) -> Iterator[StimulusFrame]:
        return (self.frame(index) for index in range(len(self)))

    def __getitem__(self, index: int) -> StimulusFrame:
        return self.frame(range(len(self))[index])


T = TypeVar("T", bound=TimedParams, covariant=True)


class TimedStimulus(Stimulus[T]):
    """Base class of clips with a rest, then a motion for a given time."""

    def __len__(self) -> int:
        return self.params.rest_frames() + self.params.moving_frames() + 1
