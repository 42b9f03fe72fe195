"""Paths of one's own in cm, degrees and s, as a condition declares them: a start and legs, or a function of time."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Annotated

import numpy as np
import numpy.typing as npt
from pydantic import AfterValidator, Field, model_validator
from pydantic.dataclasses import dataclass

from colias_sim import PathFollower, Pose, Route, Stretch

SAMPLES_PER_S = 100
"""Rate at which a function of time is read."""
LONGEST_S = 120.0
MOST_LEGS = 20_000
_STANDING_CM = 1e-4
"""Distance between two samples of a function of time below which it stands: 0.01 cm/s."""
_WIDEST_DEG = 90.0
"""The largest angle of one arc: of a wider one it would not be clear where on it a robot is."""

Speed = Annotated[float, Field(ge=0.0, le=100.0)]
Place = Annotated[float, Field(ge=-100.0, le=100.0)]
Seconds = Annotated[float, Field(ge=0.0, le=LONGEST_S)]


@dataclass(frozen=True, slots=True)
class Leg:
    """A piece of a path: a straight line or an arc, or a time for which the robot stands or turns on the spot.

    Parameters
    ----------
    length_cm
        Length, 0 to 500 cm; 0 on the spot.
    speed_cm_s
        Speed, or the speed at its beginning, 0 to 100 cm/s.
    to_cm_s
        Speed at its end, where that is another: it changes evenly in time.
    turn_deg
        Angle by which the heading changes, in degrees, left positive: evenly along the leg, or in the time.
    seconds
        Time on the spot. A leg with a length takes the time that its speed gives.

    Raises
    ------
    pydantic.ValidationError
        A value is not legal, or two of them contradict each other; it is a ``ValueError``.

    Examples
    --------
    >>> from experiments import Leg
    >>> faster = Leg(10, speed_cm_s=4, to_cm_s=16)
    >>> corner = Leg(turn_deg=60, seconds=0.5)
    """

    length_cm: Annotated[float, Field(ge=0.0, le=500.0)] = 0.0
    speed_cm_s: Speed = 0.0
    to_cm_s: Speed | None = None
    turn_deg: Annotated[float, Field(ge=-3600.0, le=3600.0)] = 0.0
    seconds: Seconds = 0.0

    @model_validator(mode="after")
    def _check(self) -> Leg:
        if self.length_cm and self.seconds:
            raise ValueError("a leg has length_cm or seconds: one with a length takes the time that its speed gives")
        if bool(self.length_cm) != bool(self.speed_cm_s or self.to_cm_s):
            raise ValueError("a leg has both length_cm and a speed above 0, or neither")
        if self.turn_deg and not self.length_cm and not self.seconds:
            raise ValueError(f"turning by {self.turn_deg:g} degrees on the spot takes seconds above 0")
        return self

    @property
    def end_cm_s(self) -> float:
        """Speed at its end."""
        return self.speed_cm_s if self.to_cm_s is None else self.to_cm_s

    @property
    def duration_s(self) -> float:
        """Time that it takes, in seconds."""
        return 2 * self.length_cm / (self.speed_cm_s + self.end_cm_s) if self.length_cm else self.seconds

    @property
    def acceleration_cm_s2(self) -> float:
        """Acceleration along it."""
        return (self.end_cm_s**2 - self.speed_cm_s**2) / (2 * self.length_cm) if self.length_cm else 0.0

    def stretches(self) -> Iterator[Stretch]:
        """Convert the leg into m, s and rad; a wide arc in parts.

        Yields
        ------
        Stretch
            Its parts.
        """
        turn = math.radians(self.turn_deg)
        if not self.length_cm:
            yield Stretch(seconds=self.seconds, rate=turn / self.seconds if self.seconds else 0.0)
            return
        parts = max(math.ceil(abs(self.turn_deg) / _WIDEST_DEG), 1)
        length = self.length_cm / 100
        whole = Stretch(length, self.speed_cm_s / 100, self.end_cm_s / 100, turn / length)
        speeds = [whole.speed_at(length * i / parts) for i in range(parts + 1)]
        for speed, end_speed in itertools.pairwise(speeds):
            yield Stretch(length / parts, speed, end_speed, whole.curvature)


@dataclass(frozen=True, slots=True)
class Path:
    """A path with its speeds, for the stimulus, the observer or a further robot of a trial.

    The origin is the camera of an observer that stands where it stands in every other trial, looking along x; y is its
    left. (The tables' ``stimulus_x_cm`` begin at the observer's middle, ``camera.forward_cm`` behind.) For a path of
    the observer the origin is its own place there: left at (0, 0), heading 0, it begins as in every other trial.

    Robots drive forward. Where the speed steps, at the start, at the end or between two legs, the robot takes
    ``acceleration_cm_s2`` of the condition. A stimulus whose first leg begins at a speed has a run-up before it.

    Parameters
    ----------
    legs
        Its pieces in order, one or more.
    x_cm, y_cm
        Where it begins.
    heading_deg
        Its direction there, 0 away from the observer, left positive: -90 crosses rightward, 180 approaches.

    Raises
    ------
    pydantic.ValidationError
        No robot can drive it; it is a ``ValueError``. Whether arena, wheels and view allow it is checked when a run is
        planned.

    Examples
    --------
    >>> from experiments import Leg, Path
    >>> accelerating = Path([Leg(16, speed_cm_s=4, to_cm_s=20)], x_cm=8, y_cm=8, heading_deg=-90)
    """

    legs: Annotated[Sequence[Leg], Field(min_length=1, max_length=MOST_LEGS), AfterValidator(tuple)]
    x_cm: Place = 0.0
    y_cm: Place = 0.0
    heading_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0

    @model_validator(mode="after")
    def _check(self) -> Path:
        if self.seconds > LONGEST_S:
            raise ValueError(f"the legs of a path take at most {LONGEST_S:g} s, got {self.seconds:.1f}")
        return self

    @classmethod
    def of_time(cls, place: Callable[[float], tuple[float, float]], seconds: float) -> Path:
        """Read a path from a function of time.

        The function is read a hundred times a second, here and now: so it may be any function, of any file.

        Parameters
        ----------
        place
            From the time in seconds to (x, y) in cm, which it never leaves alone: to stand is a `Leg`.
        seconds
            Its duration, 0.02 to 120.

        Returns
        -------
        Path
            The path; its heading is the direction of motion.

        Raises
        ------
        ValueError
            The function returns something else than two finite numbers, or stands.

        Examples
        --------
        >>> import math
        >>> from experiments import Path
        >>> slalom = Path.of_time(lambda t: (9 + 2 * math.sin(2 * t), 8 - 4 * t), seconds=4)
        """
        steps = max(round(seconds * SAMPLES_PER_S), 2)
        points = np.array([place(seconds * step / steps) for step in range(steps + 1)], float)
        chords = np.diff(points, axis=0)
        lengths = np.hypot(*chords.T)
        if not (lengths > _STANDING_CM).all():  # nor NaN
            raise ValueError("a path by a function of time must move, in cm, at all times; legs may stand")
        headings = _at_knots(np.unwrap(np.arctan2(chords[:, 1], chords[:, 0])))
        speeds, turns = _at_knots(lengths * steps / seconds), np.diff(headings)
        arcs = lengths / np.sinc(turns / (2 * np.pi))  # longer than their chords
        most = 2 * lengths * steps / seconds
        ends = np.minimum(np.maximum([speeds[:-1], speeds[1:]], 0.0), most)
        legs = [Leg(*leg) for leg in zip(arcs, *ends, np.degrees(turns), strict=True)]
        x, y = points[0].tolist()
        return cls(legs, x, y, math.degrees(math.remainder(headings[0], 2 * math.pi)))

    @property
    def seconds(self) -> float:
        """Time that its legs take, without starts and stops."""
        return math.fsum(leg.duration_s for leg in self.legs)

    @property
    def length_cm(self) -> float:
        """Length of the path."""
        return math.fsum(leg.length_cm for leg in self.legs)

    @property
    def turn_deg(self) -> float:
        """Angle by which the heading changes along it."""
        return math.fsum(leg.turn_deg for leg in self.legs)

    def stimulus_route(self, acceleration_cm_s2: float, ahead_cm: float = 0.0) -> Route:
        """Return the route of a stimulus, with its run-up.

        Parameters
        ----------
        acceleration_cm_s2
            With which it starts and stops.
        ahead_cm
            As of `route`.

        Returns
        -------
        Route
            The route, from where the run-up begins.
        """
        speed = self.legs[0].speed_cm_s / 100
        run_up = PathFollower.run_up(speed, acceleration_cm_s2 / 100) if speed else 0.0
        return self.route(ahead_cm, run_up)

    def route(self, ahead_cm: float = 0.0, run_up: float = 0.0) -> Route:
        """Return the path in m, s and rad.

        Parameters
        ----------
        ahead_cm
            How far the path's origin is ahead of the middle of an observer that stands where it usually does.
        run_up
            Length of a straight line before it, in metres, at the speed of its first leg.

        Returns
        -------
        Route
            The route.
        """
        heading = math.radians(self.heading_deg)
        x, y = (ahead_cm + self.x_cm) / 100, self.y_cm / 100
        first = self.legs[0].speed_cm_s / 100
        stretches = [Stretch(run_up, first, first)] if run_up else []
        for stretch in itertools.chain.from_iterable(leg.stretches() for leg in self.legs):
            if stretches and stretch.moves and stretches[-1].moves and not (stretch.speed or stretches[-1].end_speed):
                stretches.append(Stretch())
            stretches.append(stretch)
        if stretches[-1].moves and not stretches[-1].end_speed:
            stretches.append(Stretch())
        start = Pose(x - run_up * math.cos(heading), y - run_up * math.sin(heading), heading)
        return Route(start, tuple(stretches))

    def mirrored(self) -> Path:
        """Return the path with left and right exchanged.

        Returns
        -------
        Path
            The mirror image in the observer's line of sight.
        """
        legs = tuple(dataclasses.replace(leg, turn_deg=-leg.turn_deg) for leg in self.legs)
        return Path(legs, self.x_cm, -self.y_cm, -self.heading_deg)


def _at_knots(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return values between the middles of intervals, and beyond the first and last as the nearest two go on."""
    between = (values[:-1] + values[1:]) / 2
    return np.concatenate([[2 * values[0] - between[0]], between, [2 * values[-1] - between[-1]]])
