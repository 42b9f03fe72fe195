"""Trials that are driven by hand: what was commanded and changed in which frame, as data that repeats the trial."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal

from pydantic.dataclasses import dataclass

from colias_sim import Pose

if TYPE_CHECKING:
    from colias_sim import Simulation

LONGEST_FRAMES = 36_000
"""Frames of the longest trial by hand: 20 minutes at 30 frames per second."""
FASTEST_CM_S, FASTEST_DEG_S = 35.0, 720.0
"""Largest speed and turn rate of a command."""

Robot = Literal["stimulus", "observer"]
Place = tuple[float, float, float]
"""x and y in cm from the observer's place in other trials, and heading in degrees, left positive."""
Command = tuple[int, Robot, float, float]
"""The frame from which on a robot has a speed, cm/s, and a turn rate, degrees/s, until its next command."""
Change = tuple[int, str, str, str]
"""The frame from which on a model has a parameter's value, as ``--set`` takes it. It begins anew, from rest, there."""


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
    commands, changes
        What was done, in order of frame.
    """

    frames: int
    stimulus: Place
    observer: Place
    commands: tuple[Command, ...] = ()
    changes: tuple[Change, ...] = ()

    def changes_at(self, frame: int) -> dict[str, dict[str, str]]:
        """Return the changes of a frame: model -> parameter -> text."""
        changed: dict[str, dict[str, str]] = {}
        for when, model, name, text in self.changes:
            if when == frame:
                changed.setdefault(model, {})[name] = text
        return changed


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
        self._sim, self._hand = sim, hand
        self._wanted = {"stimulus": (0.0, 0.0), "observer": (0.0, 0.0)}
        self.commands: list[Command] = []
        self.frame, self.over = 0, False
        self._take()

    def command(self, robot: Robot, speed_cm_s: float, turn_deg_s: float) -> None:
        """Command a robot from the next frame on; a command that changes nothing is not noted."""
        if self._wanted[robot] != (speed_cm_s, turn_deg_s):
            self._wanted[robot] = speed_cm_s, turn_deg_s
            self.commands.append((self.frame, robot, speed_cm_s, turn_deg_s))

    def _take(self) -> None:
        """Give the recorded commands of the next frame."""
        for frame, robot, speed_cm_s, turn_deg_s in self._hand.commands:
            if frame == self.frame:
                self.command(robot, speed_cm_s, turn_deg_s)

    def __call__(self, dt: float) -> None:
        """Command the wheels for the next ``dt`` seconds."""
        for name, (speed, turn) in self._wanted.items():
            robot = self._sim.robots[name]
            robot.ease(robot.wheels_for(speed / 100, math.radians(turn)), dt)

    def look(self) -> None:
        """Take the commands of the next frame, once a frame."""
        self.frame += 1
        self.over = self.frame >= self._hand.frames
        self._take()
