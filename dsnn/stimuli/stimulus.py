"""What every stimulus is: a sequence of frames, each with the truth about what moves in it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass as validated

from dsnn.field_docs import with_field_docs

CONFIG = ConfigDict(extra="forbid", allow_inf_nan=False)

Luma = npt.NDArray[np.uint8]


class Velocity(NamedTuple):
    """Pixels per second: rightward and downward positive."""

    x: float
    y: float


STILL = Velocity(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Box:
    """An upright rectangle in px. Pixel (r, c) covers the square from (c, r) to (c + 1, r + 1)."""

    left: float
    top: float
    width: float
    height: float

    @classmethod
    def about(cls, x: float, y: float, width: float, height: float) -> Box:
        """The box of this size whose centre is at column ``x``, row ``y``."""
        return cls(x - width / 2, y - height / 2, width, height)

    def shifted(self, x: float, y: float) -> Box:
        """The same box ``x`` px further right and ``y`` px further down."""
        return Box(self.left + x, self.top + y, self.width, self.height)

    def touches(self, shape: tuple[int, int]) -> bool:
        """Whether any part of it is inside a frame of ``shape`` (R, C)."""
        rows, columns = shape
        return self.left < columns and self.left + self.width > 0 and self.top < rows and self.top + self.height > 0


@dataclass(frozen=True, slots=True)
class Truth:
    """What moves in one frame.

    ``motion`` is a word for it (``rightward``, ``looming``, ``still``, ...). ``box`` is the whole outline of
    the object, parts outside the frame included; it and ``velocity``, that of its centre, are None while no
    object is in the frame. ``background_velocity`` is that of everything else. ``time_to_contact_s`` counts
    down to a looming object's contact and, negative, on from a receding one's; otherwise None.
    """

    motion: str
    box: Box | None = None
    velocity: Velocity | None = None
    background_velocity: Velocity = STILL
    time_to_contact_s: float | None = None

    def without_object(self) -> Truth:
        """The truth about the background alone."""
        return Truth("still", background_velocity=self.background_velocity)


@dataclass(frozen=True, slots=True)
class StimulusFrame:
    """One frame, (R, C) uint8 grey, and its truth."""

    luma: Luma
    truth: Truth


@with_field_docs
@validated(frozen=True, config=CONFIG)
class ClipParams:
    """What every stimulus has: a frame's size and the rate.

    A value outside its legal range raises ``pydantic.ValidationError``, a ``ValueError`` that names field and bound.
    """

    rows: int = Field(default=180, ge=8, le=4096, description="rows of a frame, px (paper: 180)")
    columns: int = Field(default=320, ge=8, le=4096, description="columns of a frame, px (paper: 320, clutter 540)")
    fps: float = Field(default=30.0, ge=1.0, le=1000.0, description="frames per second (paper: 30)")


@with_field_docs
@validated(frozen=True, config=CONFIG)
class TimedParams(ClipParams):
    """A stimulus that moves for a given time, after a rest in which the first frame stands still."""

    rest_s: float = Field(default=0.3, ge=0.0, le=60.0, description="stillness before the motion, s")
    duration_s: float = Field(default=2.0, gt=0.0, le=600.0, description="how long it moves, s")

    def rest_frames(self) -> int:
        """The index of the frame from which on it moves."""
        return round(self.rest_s * self.fps)

    def moving_frames(self) -> int:
        """How many displacements it makes, one a frame."""
        return max(1, round(self.duration_s * self.fps))


P = TypeVar("P", bound=ClipParams, covariant=True)


class Stimulus(ABC, Generic[P]):
    """A clip: ``len(clip)`` frames, painted as they are asked for, any number of times.

    A subclass says how many frames there are (``__len__``) and paints one (`frame`) as a function of its
    index, ``params`` and ``seed`` alone; so equal seeds give equal bytes, whatever was asked for before.
    """

    def __init__(self, params: P, seed: int = 0) -> None:
        if seed < 0:
            raise ValueError(f"seed={seed}: legal is a whole number from 0 up")
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
        """Paint frame ``index``, 0 .. len - 1, as the light stands at ``index / fps`` seconds."""

    def __iter__(self) -> Iterator[StimulusFrame]:
        return (self.frame(index) for index in range(len(self)))

    def __getitem__(self, index: int) -> StimulusFrame:
        return self.frame(range(len(self))[index])
