"""The designs experiments are made of: which conditions, and the parameters that ``--set experiment.`` reaches."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import KW_ONLY, asdict, dataclass, replace
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, Field, TypeAdapter, ValidationError

from colias_sim import bearing
from dsnn.field_docs import parameters, unit
from experiments.bench.run.errors import UsageError, explain
from experiments.bench.sources.conditions import BY_HAND, Condition, Direction, Motion
from experiments.bench.sources.experiment import Experiment
from experiments.bench.sources.hand import Hand

SpeedCmS = Annotated[float, Field(ge=0.5, le=35.0), unit("cm/s")]
SlowSpeedCmS = Annotated[float, Field(ge=0.5, le=15.0), unit("cm/s")]
DistanceCm = Annotated[float, Field(ge=3.0, le=20.0), unit("cm")]
AngleDeg = Annotated[float, Field(ge=-60.0, le=60.0), unit("degrees")]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
WallContrast = Annotated[float, Field(ge=0.0, le=4.0)]
DriveCmS = Annotated[float, Field(ge=-5.0, le=5.0), unit("cm/s")]
TurnDegS = Annotated[float, Field(ge=-30.0, le=30.0), unit("degrees/s")]
Ways = Literal["rightward", "leftward", "both"]
Value = TypeVar("Value")


def _one_or_more(values: tuple[Value, ...]) -> tuple[Value, ...]:
    if not values:
        raise ValueError("it needs one value or more")
    return values


# Not by min_length: pydantic would count the values without those out of range, and tell of a second error.
Several = Annotated[tuple[Value, ...], AfterValidator(_one_or_more)]


def _ways(chosen: Ways) -> tuple[Direction, ...]:
    both: tuple[Direction, ...] = ("rightward", "leftward")
    return tuple(way for way in both if chosen in (way, "both"))


@parameters
class Placed:
    """The errors with which the stimulus of a design is set down."""

    _: KW_ONLY
    pose_sd_mm: Annotated[float, Field(ge=0.0, le=5.0), unit("mm")] = 1.0
    """Spread of the start position, along both axes."""
    heading_sd_deg: Annotated[float, Field(ge=0.0, le=5.0), unit("degrees")] = 1.0
    """Spread of the path's heading."""


@parameters
class Translation(Placed):
    """Straight crossings of the field of view, perpendicular to the optical axis, all speeds at all distances."""

    speeds_cm_s: Several[SpeedCmS]
    """Speeds of the stimulus."""
    distances_cm: Several[DistanceCm]
    """Distance from the camera to the path."""
    direction: Ways = "rightward"
    """Direction of the crossing in the image."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: speeds within distances within directions.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return tuple(
            Condition("translation", way, speed, distance)
            for way in _ways(self.direction)
            for distance in self.distances_cm
            for speed in self.speeds_cm_s
        )


@parameters
class Depth(Placed):
    """What approaches and recessions have in common."""

    _: KW_ONLY
    speed_cm_s: SlowSpeedCmS = 6.0
    """Speed of the stimulus."""
    near_cm: Annotated[float, Field(ge=4.0, le=10.0), unit("cm")] = 5.0
    """Distance from the camera to the near end of approach and recession, on the axis."""
    far_cm: Annotated[float, Field(ge=15.0, le=25.0), unit("cm")] = 20.0
    """Distance from the camera to the far end of approach and recession."""
    # Starts and stops happen in view, and an abrupt start 5 cm away is a flash of motion of its own.
    acceleration_cm_s2: Annotated[float, Field(ge=5.0, le=200.0), unit("cm/s2")] = 17.0
    """Acceleration with which approach and recession start and stop."""

    def at(self, motion: Motion, angle: float) -> Condition:
        """Return the approach or recession along a line at ``angle`` degrees.

        Parameters
        ----------
        motion
            ``approach``, whose image moves in from a side, or ``recession``, whose image moves out to it.
        angle
            To the optical axis, negative on the robot's left.

        Returns
        -------
        Condition
            The condition.
        """
        inward = (angle < 0) == (motion == "approach")
        way: Direction = "straight" if angle == 0 else "rightward" if inward else "leftward"
        return Condition(motion, way, self.speed_cm_s, self.near_cm, self.far_cm, angle,
                         acceleration_cm_s2=self.acceleration_cm_s2)  # fmt: skip


@parameters
class Angular(Depth):
    """Straight lines at several angles to the optical axis, through one point before the camera."""

    motion: Literal["approach", "recession"]
    """Whether the stimulus moves towards the camera or away from it."""
    angles_deg: Several[AngleDeg] = (-30.0, -15.0, 0.0, 15.0, 30.0)
    """Angle of the path to the optical axis, negative on the robot's left."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: one for each angle.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return tuple(self.at(self.motion, angle) for angle in self.angles_deg)


@parameters
class General(Depth):
    """One of each motion: straight approach and recession, a crossing each way."""

    distance_cm: DistanceCm = 8.0
    """Distance from the camera to the path of the crossings."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: approach, recession, rightward, leftward.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        crossings = (Condition("translation", way, self.speed_cm_s, self.distance_cm) for way in _ways("both"))
        return (self.at("approach", 0.0), self.at("recession", 0.0), *crossings)


@parameters
class Crossings(Placed):
    """What crossings of one speed at one distance have in common."""

    _: KW_ONLY
    speed_cm_s: SpeedCmS = 6.0
    """Speed of the stimulus."""
    distance_cm: DistanceCm = 8.0
    """Distance from the camera to the path, in mid-crossing."""
    direction: Ways = "rightward"
    """Direction of the crossing in the image."""

    def each(self, changes: Iterable[Mapping[str, Any]]) -> tuple[Condition, ...]:
        """Return a crossing with each of the ``changes``, within directions.

        Parameters
        ----------
        changes
            Fields of a `Condition`.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return tuple(
            Condition("translation", way, self.speed_cm_s, self.distance_cm, **changed)
            for way in _ways(self.direction)
            for changed in changes
        )


@parameters
class Contrast(Crossings):
    """Crossings by shells of several greys, before the same wall."""

    shell_greys: Several[Share] = (0.02, 0.2, 0.4, 0.6, 0.8, 1.0)
    """Reflectance of the stimulus's shell."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: greys within directions.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return self.each([{"shell_grey": grey} for grey in self.shell_greys])


@parameters
class Clutter(Crossings):
    """Crossings before walls of several contrasts."""

    wall_contrasts: Several[WallContrast] = (0.0, 0.5, 1.0, 2.0, 4.0)
    """Contrast of the wall's texture; 1: as the arena has it."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: contrasts within directions.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return self.each([{"wall_contrast": contrast} for contrast in self.wall_contrasts])


@parameters
class Egomotion(Crossings):
    """Crossings while the observer itself turns or drives; in mid-crossing it is where it stands otherwise."""

    turns_deg_s: Several[TurnDegS] = (-5.0, -2.5, 0.0, 2.5, 5.0)
    """Turning of the observer, left positive."""
    drives_cm_s: tuple[DriveCmS, ...] = (-1.0, 1.0)
    """Driving of the observer where it does not turn, forward positive."""

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: turns, then drives, within directions.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        turns = [{"observer_turn_deg_s": turn} for turn in self.turns_deg_s]
        return self.each([*turns, *({"observer_speed_cm_s": drive} for drive in self.drives_cm_s if drive)])


# --- trials by hand ---------------------------------------------------------------------------------------------------

LIVE = "live"
"""The name of the experiment of a trial by hand: what ``colias live`` records, and ``colias run --again`` repeats."""


@dataclass(frozen=True)
class ByHand:
    """The design of a trial by hand: one condition, without errors of the start pose.

    Parameters
    ----------
    hand
        What was done.
    """

    hand: Hand
    pose_sd_mm: float = 0.0
    heading_sd_deg: float = 0.0

    def conditions(self) -> tuple[Condition, ...]:
        """List its condition.

        Returns
        -------
        tuple of Condition
            One. Its speed is the mean of the stimulus's commanded speeds, each by how long it lasted, its distance
            that of the stimulus from the observer's middle at the start, and its direction, by the first command that
            moves the stimulus, that in which its bearing begins to go.
        """
        hand = self.hand
        moves = [command for command in hand.commands if command.robot == "stimulus"]
        ends = [*(command.frame for command in moves[1:]), hand.frames][: len(moves)]
        driven = math.fsum(abs(c.speed_cm_s) * (end - c.frame) for c, end in zip(moves, ends, strict=True))
        speed = driven / hand.frames
        away = math.hypot(hand.stimulus.x_cm - hand.observer.x_cm, hand.stimulus.y_cm - hand.observer.y_cm)
        first = next((command.speed_cm_s for command in moves if command.speed_cm_s), 0.0)
        here, observer = hand.stimulus.pose, hand.observer.pose
        step = math.copysign(0.01, first) if first else 0.0
        there = replace(here, x=here.x + step * math.cos(here.heading), y=here.y + step * math.sin(here.heading))
        swept = math.remainder(bearing(observer, there, 0.0) - bearing(observer, here, 0.0), 2 * math.pi)
        straight = abs(swept) < math.radians(0.1)
        return (
            Condition(
                BY_HAND, "straight" if straight else "rightward" if swept > 0 else "leftward",
                min(max(round(speed, 3), 0.1), 100.0), min(max(round(away, 3), 0.5), 100.0), hand=hand,
            ),
        )  # fmt: skip


def visit(hand: Hand) -> Experiment:
    """Return the experiment of a trial by hand.

    Parameters
    ----------
    hand
        What was done.
    """
    return Experiment(LIVE, "driven by hand, from the page of colias live", ByHand(hand), "speed_cm_s", 1)


def visit_described(experiment: object) -> dict[str, Any] | None:
    """Return what `visit_declared` takes of an experiment that was driven by hand; ``None`` of any other."""
    design = getattr(experiment, "design", None)
    return {LIVE: asdict(design.hand)} if isinstance(design, ByHand) else None


def visit_declared(value: Any, where: str) -> Experiment | None:
    """Return the experiment that `visit_described` describes; ``None`` where it describes none.

    Raises
    ------
    UsageError
        A value of it is not legal.
    """
    if not isinstance(value, Mapping) or set(value) != {LIVE}:
        return None
    try:
        return visit(TypeAdapter(Hand).validate_python(value[LIVE]))
    except ValidationError as error:
        raise UsageError(f"{where}: {explain(error)}") from None
