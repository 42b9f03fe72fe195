"""Trials that are driven by hand: what was commanded and changed in which frame, as data that repeats the trial."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

from colias_sim import Pose

if TYPE_CHECKING:
    from colias_sim import Simulation

LONGEST_FRAMES = 36_000
"""Frames of the longest trial by hand: 20 minutes at 30 frames per second."""
FASTEST_CM_S, FASTEST_DEG_S = 35.0, 720.0
"""Largest speed and turn rate of a command."""
_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)
_Frame = Annotated[int, Field(ge=0, le=LONGEST_FRAMES)]
_Length = Annotated[float, Field(ge=-100.0, le=100.0)]


@dataclass(frozen=True, config=_STRICT)
class Place:
    """Place where a robot is put down, from the observer's place in other trials: in cm, and degrees, left positive."""

    x_cm: _Length
    y_cm: _Length
    heading_deg: Annotated[float, Field(ge=-360.0, le=360.0)]

    @property
    def pose(self) -> Pose:
        """The same in metres and radians."""
        return Pose(self.x_cm / 100, self.y_cm / 100, math.radians(self.heading_deg))

    @classmethod
    def of(cls, pose: Pose) -> Place:
        """Return the place of a pose."""
        return cls(100 * pose.x, 100 * pose.y, math.degrees(math.remainder(pose.heading, 2 * math.pi)))


@dataclass(frozen=True, config=_STRICT)
class Command:
    """A command to a robot, from the beginning of a frame on until the next."""

    frame: _Frame
    robot: Literal["stimulus", "observer"]
    speed_cm_s: Annotated[float, Field(ge=-FASTEST_CM_S, le=FASTEST_CM_S)]
    turn_deg_s: Annotated[float, Field(ge=-FASTEST_DEG_S, le=FASTEST_DEG_S)]


@dataclass(frozen=True, config=_STRICT)
class Change:
    """A parameter of a model that has another value from a frame on. The model begins anew, from rest, there."""

    frame: _Frame
    model: Annotated[str, Field(max_length=200)]
    name: Annotated[str, Field(max_length=60)]
    text: Annotated[str, Field(max_length=200)]
    """The value, as ``--set`` takes it."""


@dataclass(frozen=True, config=_STRICT)
class Hand:
    """A trial by hand.

    Parameters
    ----------
    frames
        How many it has.
    stimulus, observer
        Where the robots are put down.
    commands, changes
        What was done, in order of frame.
    """

    frames: Annotated[int, Field(ge=1, le=LONGEST_FRAMES)]
    stimulus: Place
    observer: Place
    commands: tuple[Command, ...] = ()
    changes: tuple[Change, ...] = ()


class HandDrive:
    """Commands both robots by what a hand does: as recorded, or as it comes in.

    Attributes
    ----------
    commands
        Those that were given, in order of frame.
    frame
        The number of the frame that is next.
    over
        Whether all frames of the record are past.

    Parameters
    ----------
    sim
        The simulation, reset.
    hand
        The record.
    """

    def __init__(self, sim: Simulation, hand: Hand) -> None:
        self._sim, self._frames = sim, hand.frames
        self._wanted = {"stimulus": (0.0, 0.0), "observer": (0.0, 0.0)}
        self._coming = list(reversed(hand.commands))
        self.commands: list[Command] = []
        self.frame, self.over = 0, False
        self._take()

    def command(self, robot: Literal["stimulus", "observer"], speed_cm_s: float, turn_deg_s: float) -> None:
        """Command a robot from the next frame on; a command that changes nothing is not noted."""
        if self._wanted[robot] == (speed_cm_s, turn_deg_s):
            return
        self._give(Command(self.frame, robot, speed_cm_s, turn_deg_s))

    def _give(self, command: Command) -> None:
        self._wanted[command.robot] = (command.speed_cm_s, command.turn_deg_s)
        self.commands.append(command)

    def _take(self) -> None:
        """Give the recorded commands of the next frame."""
        while self._coming and self._coming[-1].frame <= self.frame:
            self._give(self._coming.pop())

    def __call__(self, dt: float) -> None:
        """Command the wheels for the next ``dt`` seconds."""
        for name, (speed, turn) in self._wanted.items():
            robot = self._sim.robots[name]
            robot.ease(robot.wheels_for(speed / 100, math.radians(turn)), dt)

    def look(self) -> None:
        """Take the commands of the next frame, once a frame."""
        self.frame += 1
        self.over = self.frame >= self._frames
        self._take()


def changes_at(changes: Iterable[Change], frame: int) -> dict[str, dict[str, str]]:
    """Return the changes of a frame: model -> parameter -> text."""
    changed: dict[str, dict[str, str]] = {}
    for change in changes:
        if change.frame == frame:
            changed.setdefault(change.model, {})[change.name] = change.text
    return changed
