"""The designs experiments are made of: which conditions, and the parameters that ``--set experiment.`` reaches."""

from __future__ import annotations

from typing import Annotated, Literal, TypeVar

from pydantic import AfterValidator, Field

from dsnn.field_docs import parameters, unit
from experiments.bench.sources.conditions import Condition, Direction, Motion

SpeedCmS = Annotated[float, Field(ge=0.5, le=35.0), unit("cm/s")]
SlowSpeedCmS = Annotated[float, Field(ge=0.5, le=15.0), unit("cm/s")]
DistanceCm = Annotated[float, Field(ge=3.0, le=20.0), unit("cm")]
AngleDeg = Annotated[float, Field(ge=-60.0, le=60.0), unit("degrees")]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
WallContrast = Annotated[float, Field(ge=0.0, le=4.0)]
DriveCmS = Annotated[float, Field(ge=-5.0, le=5.0), unit("cm/s")]
TurnDegS = Annotated[float, Field(ge=-30.0, le=30.0), unit("degrees/s")]
Value = TypeVar("Value")


def _one_or_more(values: tuple[Value, ...]) -> tuple[Value, ...]:
    if not values:
        raise ValueError("it needs one value or more")
    return values


# Not by min_length: pydantic would count the values without those out of range, and tell of a second error.
Several = Annotated[tuple[Value, ...], AfterValidator(_one_or_more)]


POSE_SD: float = Field(default=1.0, ge=0.0, le=5.0, description="spread of the start position, along both axes")
HEADING_SD: float = Field(default=1.0, ge=0.0, le=5.0, description="spread of the path's heading")
ACCELERATION: float = Field(
    default=17.0, ge=5.0, le=200.0, description="acceleration with which approach and recession start and stop"
)
"""Starts and stops happen in view, and an abrupt start 5 cm away is a flash of motion of its own."""


def _ways(chosen: str) -> tuple[Direction, ...]:
    both: tuple[Direction, ...] = ("rightward", "leftward")
    return tuple(way for way in both if chosen in (way, "both"))


@parameters
class Translation:
    """Straight crossings of the field of view, perpendicular to the optical axis, all speeds at all distances."""

    speeds_cm_s: Several[SpeedCmS]
    """Speeds of the stimulus."""
    distances_cm: Several[DistanceCm]
    """Distance from the camera to the path."""
    direction: Literal["rightward", "leftward", "both"] = "rightward"
    """Direction of the crossing in the image."""
    pose_sd_mm: Annotated[float, unit("mm")] = POSE_SD
    heading_sd_deg: Annotated[float, unit("degrees")] = HEADING_SD

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


def angular(motion: Motion, angle: float, speed: float, near: float, far: float, acceleration: float) -> Condition:
    """An approach or recession along a line at ``angle`` degrees; its image moves in from a side, or out to it."""
    inward = motion == "approach"
    way: Direction = "straight" if angle == 0 else "rightward" if (angle < 0) == inward else "leftward"
    return Condition(motion, way, speed, near, far, angle, acceleration_cm_s2=acceleration)


@parameters
class Angular:
    """Straight lines at several angles to the optical axis, through one point before the camera."""

    motion: Literal["approach", "recession"]
    """Whether the stimulus moves towards the camera or away from it."""
    angles_deg: Several[AngleDeg] = (-30.0, -15.0, 0.0, 15.0, 30.0)
    """Angle of the path to the optical axis, negative on the robot's left."""
    speed_cm_s: SlowSpeedCmS = 6.0
    """Speed of the stimulus."""
    near_cm: Annotated[float, unit("cm")] = Field(default=5.0, ge=4.0, le=10.0)
    """Distance from the camera to the path's near end, on the axis."""
    far_cm: Annotated[float, unit("cm")] = Field(default=20.0, ge=15.0, le=25.0)
    """Distance from the camera to the path's far end."""
    acceleration_cm_s2: Annotated[float, unit("cm/s2")] = ACCELERATION
    pose_sd_mm: Annotated[float, unit("mm")] = POSE_SD
    heading_sd_deg: Annotated[float, unit("degrees")] = HEADING_SD

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: one for each angle.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        near, far, start = self.near_cm, self.far_cm, self.acceleration_cm_s2
        return tuple(angular(self.motion, a, self.speed_cm_s, near, far, start) for a in self.angles_deg)


@parameters
class General:
    """One of each motion: straight approach and recession, a crossing each way."""

    speed_cm_s: SlowSpeedCmS = 6.0
    """Speed of the stimulus."""
    distance_cm: DistanceCm = 8.0
    """Distance from the camera to the path of the crossings."""
    near_cm: Annotated[float, unit("cm")] = Field(default=5.0, ge=4.0, le=10.0)
    """Distance from the camera to the near end of approach and recession."""
    far_cm: Annotated[float, unit("cm")] = Field(default=20.0, ge=15.0, le=25.0)
    """Distance from the camera to the far end of approach and recession."""
    acceleration_cm_s2: Annotated[float, unit("cm/s2")] = ACCELERATION
    pose_sd_mm: Annotated[float, unit("mm")] = POSE_SD
    heading_sd_deg: Annotated[float, unit("degrees")] = HEADING_SD

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: approach, recession, rightward, leftward.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        kinds: tuple[Motion, ...] = ("approach", "recession")
        near, far, start = self.near_cm, self.far_cm, self.acceleration_cm_s2
        return (
            *(angular(kind, 0.0, self.speed_cm_s, near, far, start) for kind in kinds),
            *(Condition("translation", way, self.speed_cm_s, self.distance_cm) for way in _ways("both")),
        )


@parameters
class Contrast:
    """Crossings by shells of several greys, before the same wall."""

    shell_greys: Several[Share] = (0.02, 0.2, 0.4, 0.6, 0.8, 1.0)
    """Reflectance of the stimulus's shell."""
    speed_cm_s: SpeedCmS = 6.0
    """Speed of the stimulus."""
    distance_cm: DistanceCm = 8.0
    """Distance from the camera to the path."""
    direction: Literal["rightward", "leftward", "both"] = "rightward"
    """Direction of the crossing in the image."""
    pose_sd_mm: Annotated[float, unit("mm")] = POSE_SD
    heading_sd_deg: Annotated[float, unit("degrees")] = HEADING_SD

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: greys within directions.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return tuple(
            Condition("translation", way, self.speed_cm_s, self.distance_cm, shell_grey=grey)
            for way in _ways(self.direction)
            for grey in self.shell_greys
        )


@parameters
class Clutter:
    """Crossings before walls of several contrasts."""

    wall_contrasts: Several[WallContrast] = (0.0, 0.5, 1.0, 2.0, 4.0)
    """Contrast of the wall's texture; 1: as the arena has it."""
    speed_cm_s: SpeedCmS = 6.0
    """Speed of the stimulus."""
    distance_cm: DistanceCm = 8.0
    """Distance from the camera to the path."""
    direction: Literal["rightward", "leftward", "both"] = "rightward"
    """Direction of the crossing in the image."""
    pose_sd_mm: Annotated[float, unit("mm")] = POSE_SD
    heading_sd_deg: Annotated[float, unit("degrees")] = HEADING_SD

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: contrasts within directions.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        return tuple(
            Condition("translation", way, self.speed_cm_s, self.distance_cm, wall_contrast=contrast)
            for way in _ways(self.direction)
            for contrast in self.wall_contrasts
        )


@parameters
class Egomotion:
    """Crossings while the observer itself turns or drives; in mid-crossing it is where it stands otherwise."""

    turns_deg_s: Several[TurnDegS] = (-5.0, -2.5, 0.0, 2.5, 5.0)
    """Turning of the observer, left positive."""
    drives_cm_s: tuple[DriveCmS, ...] = (-1.0, 1.0)
    """Driving of the observer where it does not turn, forward positive."""
    speed_cm_s: SpeedCmS = 6.0
    """Speed of the stimulus."""
    distance_cm: DistanceCm = 8.0
    """Distance from the camera to the path, in mid-crossing."""
    direction: Literal["rightward", "leftward", "both"] = "rightward"
    """Direction of the crossing in the image."""
    pose_sd_mm: Annotated[float, unit("mm")] = POSE_SD
    heading_sd_deg: Annotated[float, unit("degrees")] = HEADING_SD

    def conditions(self) -> tuple[Condition, ...]:
        """List the conditions: turns, then drives, within directions.

        Returns
        -------
        tuple of Condition
            One for each trial of a round.
        """
        motions = [(0.0, turn) for turn in self.turns_deg_s] + [(drive, 0.0) for drive in self.drives_cm_s if drive]
        return tuple(
            Condition("translation", way, self.speed_cm_s, self.distance_cm,
                      observer_speed_cm_s=drive, observer_turn_deg_s=turn)
            for way in _ways(self.direction)
            for drive, turn in motions
        )  # fmt: skip
