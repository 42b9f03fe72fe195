"""Conditions of trials with the robot: what the stimulus, the observer and further robots do, by paths or by hand."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from typing import Annotated, Any, Literal, get_args

import numpy as np
import numpy.typing as npt
from pydantic import AfterValidator, ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from colias_sim import PathFollower, Pose, Route, Schedule, Stretch

# --- paths, in cm, degrees and s --------------------------------------------------------------------------------------

SAMPLES_PER_S = 100
"""Rate at which a function of time is read."""
LONGEST_S = 120.0
MOST_LEGS = 20_000
_STANDING_CM = 1e-4
"""Distance between two samples of a function of time below which it stands: 0.01 cm/s."""
_WIDEST_DEG = 90.0
"""The largest angle of one arc: of a wider one it would not be clear where on it a robot is."""

Speed = Annotated[float, Field(ge=0.0, le=100.0)]
Coordinate = Annotated[float, Field(ge=-100.0, le=100.0)]
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
class Trajectory:
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
    >>> from experiments import Leg, Trajectory
    >>> accelerating = Trajectory([Leg(16, speed_cm_s=4, to_cm_s=20)], x_cm=8, y_cm=8, heading_deg=-90)
    """

    legs: Annotated[Sequence[Leg], Field(min_length=1, max_length=MOST_LEGS), AfterValidator(tuple)]
    x_cm: Coordinate = 0.0
    y_cm: Coordinate = 0.0
    heading_deg: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0

    @model_validator(mode="after")
    def _check(self) -> Trajectory:
        if self.seconds > LONGEST_S:
            raise ValueError(f"the legs of a path take at most {LONGEST_S:g} s, got {self.seconds:.1f}")
        return self

    @classmethod
    def of_time(cls, place: Callable[[float], tuple[float, float]], seconds: float) -> Trajectory:
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
        Trajectory
            The path; its heading is the direction of motion.

        Raises
        ------
        ValueError
            The function returns something else than two finite numbers, or stands.

        Examples
        --------
        >>> import math
        >>> from experiments import Trajectory
        >>> slalom = Trajectory.of_time(lambda t: (9 + 2 * math.sin(2 * t), 8 - 4 * t), seconds=4)
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

    def mirrored(self) -> Trajectory:
        """Return the path with left and right exchanged.

        Returns
        -------
        Trajectory
            The mirror image in the observer's line of sight.
        """
        legs = tuple(dataclasses.replace(leg, turn_deg=-leg.turn_deg) for leg in self.legs)
        return Trajectory(legs, self.x_cm, -self.y_cm, -self.heading_deg)


def _at_knots(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return values between the middles of intervals, and beyond the first and last as the nearest two go on."""
    between = (values[:-1] + values[1:]) / 2
    return np.concatenate([[2 * values[0] - between[0]], between, [2 * values[-1] - between[-1]]])


# --- trials by hand: what was commanded in which frame ----------------------------------------------------------------

LONGEST_FRAMES = 36_000
"""Frames of the longest trial by hand: 20 minutes at 30 frames per second."""
FASTEST_CM_S = 35.0
"""Largest speed of a command."""

RobotName = Literal["stimulus", "observer"]
Place = tuple[float, float, float]
"""x and y in cm from the observer's place in other trials, and heading in degrees, left positive."""
Command = tuple[int, RobotName, float, float]
"""The frame from which on a robot has a speed, cm/s, and a turn rate, degrees/s, until its next command."""


def pose_of(place: Place) -> Pose:
    """Return a place in metres and radians."""
    x, y, heading = place
    return Pose(x / 100, y / 100, math.radians(heading))


def place_of(pose: Pose) -> Place:
    """Return the place of a pose."""
    return 100 * pose.x, 100 * pose.y, math.degrees(math.remainder(pose.heading, 2 * math.pi))


@dataclass(frozen=True)
class Hand:
    """A trial by hand.

    Parameters
    ----------
    frames
        How many it has.
    stimulus, observer
        Where the robots are put down.
    commands
        What was done, in order of frame.
    """

    frames: int
    stimulus: Place
    observer: Place
    commands: tuple[Command, ...] = ()


# --- conditions -------------------------------------------------------------------------------------------------------

Motion = Literal["translation", "approach", "recession"]
Direction = Literal["rightward", "leftward", "straight"]
PAPER = get_args(Motion)
DEPTH = ("approach", "recession")
BY_HAND = "by-hand"
"""The motion of trials that were driven by hand."""
SCRIPTED = ("path", "observer", "movers", "hand")
"""The fields of a condition that are no columns: its paths, which the name in ``motion`` stands for."""
WHERE_SET = {"where_set": True}
"""Metadata of fields that descriptions have only where they are set: `experiments.base.files.plain`."""
START_CM_S2 = 100.0
"""The acceleration with which a stimulus starts where its condition does not say."""
_PLACES = 400
"""Places of a path from which its direction and its distance are read."""

Length = Annotated[float, Field(ge=0.5, le=100.0)]


@dataclass(frozen=True, slots=True, config=ConfigDict(extra="forbid", allow_inf_nan=False))
class Condition:
    """Setting of a trial. ``None`` where a motion has no such quantity, or where the settings decide.

    Parameters
    ----------
    motion
        ``translation``: the stimulus crosses the view, perpendicular to the optical axis. ``approach``: it drives
        straight at a point before the camera. ``recession``: it drives the same line the other way. Any other name, of
        lower-case letters, digits and ``-``: it takes the ``path``, and `Condition.along` fills in the numbers.
    direction
        Direction of the stimulus's image: ``rightward`` or ``leftward``; ``straight`` on the optical axis.
    speed_cm_s
        Speed of the stimulus, 0.1 to 100 cm/s.
    distance_cm
        From the camera to the path of a crossing, or to the near end of an approach or recession, 0.5 to 100 cm.
    far_cm
        From the camera to the far end of an approach or recession, above ``distance_cm``, up to 100 cm.
    angle_deg
        Angle of an approach's or recession's line to the optical axis, -80 to 80 degrees, negative on the robot's left.
    shell_grey
        Reflectance of the stimulus's shell, 0 to 1.
    wall_contrast
        Contrast of the arena's wall, 0 to 4; 1 is its own.
    observer_speed_cm_s, observer_turn_deg_s
        At which the observer drives, -35 to 35 cm/s, forward positive, and turns, -360 to 360 degrees/s, left positive.
    acceleration_cm_s2
        With which the stimulus starts, and stops, 1 to 1000 cm/s2. A crossing starts outside the view, and is at its
        speed when it comes in: there nothing of it is seen. For one that accelerates in view see `Condition.along`.
    path
        The stimulus's path, of a motion with a name of its own.
    observer
        The observer's path beside it; otherwise it stands.
    movers
        Paths of further robots, up to 6, that look like the stimulus.
    hand
        Commands and changes by frame of a trial that ``colias live`` recorded, instead of a path.

    Raises
    ------
    pydantic.ValidationError
        No trial can have the value; it is a ``ValueError``. Whether robots and arena allow it is checked when a run is
        planned.

    Examples
    --------
    >>> from experiments import Condition
    >>> Condition("translation", "rightward", speed_cm_s=6.0, distance_cm=8.0).label()
    'translation rightward, 6 cm/s at 8 cm'
    """

    motion: Annotated[str, Field(pattern="^[a-z][a-z0-9-]{0,39}$")]
    direction: Direction
    speed_cm_s: Annotated[float, Field(ge=0.1, le=100.0)]
    distance_cm: Length
    far_cm: Length | None = None
    angle_deg: Annotated[float, Field(ge=-80.0, le=80.0)] | None = None
    shell_grey: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    wall_contrast: Annotated[float, Field(ge=0.0, le=4.0)] | None = None
    observer_speed_cm_s: Annotated[float, Field(ge=-35.0, le=35.0)] = 0.0
    observer_turn_deg_s: Annotated[float, Field(ge=-360.0, le=360.0)] = 0.0
    acceleration_cm_s2: Annotated[float, Field(ge=1.0, le=1000.0)] = START_CM_S2
    path: Trajectory | None = dataclasses.field(default=None, metadata=WHERE_SET)
    observer: Trajectory | None = dataclasses.field(default=None, metadata=WHERE_SET)
    movers: Annotated[tuple[Trajectory, ...], Field(max_length=6)] = dataclasses.field(default=(), metadata=WHERE_SET)
    hand: Hand | None = dataclasses.field(default=None, metadata=WHERE_SET)

    @model_validator(mode="after")
    def _check(self) -> Condition:
        own = self.motion not in PAPER
        if own != (self.path is not None or self.hand is not None):
            legal = f"motion must be one of {', '.join(PAPER)}, or a name of its own with a path (Condition.along)"
            raise ValueError(f"{legal}, got {self.motion}{'' if own else ' with a path'}")
        if self.path is None and (self.observer or self.movers):
            raise ValueError("observer and movers need a path of the stimulus")
        if self.motion == "translation" and self.direction == "straight":
            raise ValueError("the direction of a translation must be rightward or leftward, got straight")
        if self.motion in DEPTH and (self.angle_deg is None or self.far_cm is None):
            raise ValueError(f"{self.motion} needs angle_deg and far_cm")
        if self.far_cm is not None and self.far_cm <= self.distance_cm:
            raise ValueError(f"far_cm must be above distance_cm={self.distance_cm:g}, got {self.far_cm:g}")
        for path in filter(None, (self.path, self.observer, *self.movers)):
            for index, leg in enumerate(path.legs):
                if abs(leg.acceleration_cm_s2) > self.acceleration_cm_s2:
                    there = f"legs[{index}].to_cm_s={leg.end_cm_s:g} takes {abs(leg.acceleration_cm_s2):.0f} cm/s2"
                    most = f"acceleration_cm_s2={self.acceleration_cm_s2:g}"
                    raise ValueError(f"{there}, above {most}: make it longer, or raise that")
        return self

    @classmethod
    def along(
        cls, motion: str, path: Trajectory, *, direction: Direction | None = None, observer: Trajectory | None = None,
        movers: Sequence[Trajectory] = (), acceleration_cm_s2: float = START_CM_S2, **looks: Any,
    ) -> Condition:  # fmt: skip
        """Make a condition in which the stimulus takes a path of one's own.

        Parameters
        ----------
        motion
            Its name in tables and figures, of lower-case letters, digits and ``-``: ``accelerating``.
        path
            The stimulus's path.
        direction
            Of its image; left out, it is that from the bearing at its start to that at its end.
        observer, movers
            Paths of the observer and of further robots. All robots begin at the same time.
        acceleration_cm_s2
            With which robots take a step of the speed: at the start, at the end, or between two legs.
        **looks
            ``shell_grey`` and ``wall_contrast``, as of a `Condition`.

        Returns
        -------
        Condition
            With the mean speed of the path in ``speed_cm_s``, but for starts and stops, its least distance from the
            camera's place in ``distance_cm``, and the observer's mean speed and turn rate.

        Raises
        ------
        ValueError
            No trial can have the value.

        Examples
        --------
        >>> from experiments import Condition, Leg, Trajectory
        >>> path = Trajectory([Leg(16, speed_cm_s=4, to_cm_s=20)], x_cm=8, y_cm=8, heading_deg=-90)
        >>> Condition.along("accelerating", path).label()
        'accelerating rightward, 12 cm/s at 8 cm'
        """
        if not path.length_cm:
            raise ValueError(f"condition {motion}: the stimulus has to move: no leg of its path has a length_cm")
        start = acceleration_cm_s2 / 100
        route = path.stimulus_route(acceleration_cm_s2)
        speed = 100 * Schedule(route, start).speed_over(route.measured(start))
        length = path.length_cm / 100
        places = [route.point(route.length - length * (1 - i / _PLACES)) for i in range(_PLACES + 1)]
        steps = [math.atan2(b.y, b.x) - math.atan2(a.y, a.x) for a, b in itertools.pairwise(places)]
        swept = math.degrees(sum(math.remainder(step, 2 * math.pi) for step in steps))
        seconds = observer.seconds if observer else 0.0
        return cls(
            motion,
            direction or ("straight" if abs(swept) < 1.0 else "leftward" if swept > 0 else "rightward"),
            round(speed, 3),
            round(100 * min(math.hypot(place.x, place.y) for place in places), 3),
            observer_speed_cm_s=round(observer.length_cm / seconds, 3) if observer and seconds else 0.0,
            observer_turn_deg_s=round(observer.turn_deg / seconds, 3) if observer and seconds else 0.0,
            acceleration_cm_s2=acceleration_cm_s2,
            path=path,
            observer=observer,
            movers=tuple(movers),
            **looks,
        )

    def columns(self) -> dict[str, Any]:
        """Return what the tables have of it, by column.

        Returns
        -------
        dict of str to Any
            Every field but the paths.
        """
        return {name: getattr(self, name) for name in CONDITION_COLUMNS}

    def label(self) -> str:
        """Write the condition in words.

        Returns
        -------
        str
            As tables and figures show it.
        """
        where = f"at {self.distance_cm:g} cm" if self.angle_deg is None else f"along {self.angle_deg:g} degrees"
        parts = [f"{self.motion} {self.direction}, {self.speed_cm_s:g} cm/s {where}"]
        looks = (("shell grey", self.shell_grey), ("wall contrast", self.wall_contrast))
        parts += [f"{look} {value:g}" for look, value in looks if value is not None]
        if self.observer_speed_cm_s:
            parts.append(f"observer driving {self.observer_speed_cm_s:g} cm/s")
        if self.observer_turn_deg_s:
            parts.append(f"observer turning {self.observer_turn_deg_s:g} degrees/s")
        return ", ".join(parts)


CONDITION_COLUMNS = tuple(field.name for field in dataclasses.fields(Condition) if field.name not in SCRIPTED)
