"""Scripted drivers of the other robots. They command wheel speeds, and know the poses of all robots."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np

from colias_sim.envs.geometry import gap_to_arena, gap_to_robot
from colias_sim.pose import Pose, WheelSpeeds
from colias_sim.robot import Robot

if TYPE_CHECKING:
    from colias_sim.obstacles import Obstacle


class Driver(Protocol):
    """A driver of one robot."""

    def wheels(self, dt: float, poses: Mapping[str, Pose]) -> WheelSpeeds:
        """Choose the wheel speeds for the next control interval.

        Parameters
        ----------
        dt
            Length of the interval, in seconds.
        poses
            Poses of all robots by name, the driven one among them.

        Returns
        -------
        WheelSpeeds
            The speeds to command, in m/s.
        """
        ...


class Wander:
    """Wandering: ahead on a meandering path, with turns on the spot before a wall, an obstacle or a robot.

    The driver notices what is within ``REACH`` metres of the hull and inside a cone about the heading. The cone is
    the wider the nearer the thing is. The robot turns away from the thing until the way is free.

    Parameters
    ----------
    robot
        The robot to drive.
    speed
        Speed ahead, in m/s.
    rng
        Generator of the meandering.
    unheeded
        Names of the robots that it does not notice.
    obstacles
        What stands in the arena.
    """

    REACH = 0.045
    FAR_CONE, NEAR_CONE = math.radians(65), math.radians(120)  # beyond 90 degrees: it neither grazes nor enters
    MEANDER, MEMORY_S = 0.5, 1.0  # rad/s, standard deviation; seconds
    AVOIDING = 2.5  # rad/s

    def __init__(
        self, robot: Robot, speed: float, rng: np.random.Generator, unheeded: Collection[str] = (),
        obstacles: Collection[Obstacle] = (),
    ) -> None:  # fmt: skip
        self._obstacles = obstacles
        self._robot, self._speed, self._rng, self._unheeded = robot, speed, rng, {robot.name, *unheeded}
        self._turn = self._avoiding = 0.0

    def wheels(self, dt: float, poses: Mapping[str, Pose]) -> WheelSpeeds:
        """Choose the wheel speeds for the next ``dt`` seconds, as `Driver.wheels`."""
        fade = math.exp(-dt / self.MEMORY_S)
        kick = math.sqrt(1.0 - fade * fade) * self.MEANDER * float(self._rng.standard_normal())
        self._turn = fade * self._turn + kick  # drawn even if unused: later draws do not depend on what is near
        side = self._blocked(poses)
        if side == 0.0:
            self._avoiding = 0.0
            return self._robot.wheels_for(self._speed, self._turn)
        self._avoiding = self._avoiding or -side * self.AVOIDING
        return self._robot.wheels_for(0.0, self._avoiding)

    def _blocked(self, poses: Mapping[str, Pose]) -> float:
        """Return the side of the nearest thing in the way: 1 left, -1 right, 0 if the way is free."""
        here = poses[self._robot.name]
        nearest, side = self.REACH, 0.0
        others = (gap_to_robot(here, there) for name, there in poses.items() if name not in self._unheeded)
        for gap, direction in (gap_to_arena(here, self._obstacles), *others):
            if gap < nearest and abs(direction) < self._cone(gap):
                nearest, side = gap, 1.0 if direction >= 0.0 else -1.0
        return side

    def _cone(self, gap: float) -> float:
        return self.NEAR_CONE + (self.FAR_CONE - self.NEAR_CONE) * max(gap, 0.0) / self.REACH


class Orbit:
    """Circling to and fro about a centre. Every 1 to 4 seconds the driver draws a new angular rate and direction.

    To reverse, the robot drives backwards.

    Parameters
    ----------
    robot
        The robot to drive.
    centre
        x and y of the circle's centre, in metres.
    distance
        Radius of the circle, in metres.
    slowest, fastest
        Ends of the uniform distribution of the angular rate, in rad/s; the sign is drawn too.
    rng
        The generator to draw from.
    """

    RADIAL_GAIN, RAMP = 8.0, 0.4  # rad of heading per metre off the circle; m/s^2
    HEADING_GAIN = 6.0  # 1/s

    def __init__(
        self, robot: Robot, centre: tuple[float, float], distance: float, slowest: float, fastest: float,
        rng: np.random.Generator,
    ) -> None:  # fmt: skip
        self._robot, self._centre, self._distance = robot, centre, distance
        self._rates, self._rng = (slowest, fastest), rng
        self._left = self._speed = self._wanted = 0.0

    def wheels(self, dt: float, poses: Mapping[str, Pose]) -> WheelSpeeds:
        """Choose the wheel speeds for the next ``dt`` seconds, as `Driver.wheels`."""
        self._left -= dt
        if self._left <= 0.0:
            self._left = float(self._rng.uniform(1.0, 4.0))
            rate = float(self._rng.uniform(*self._rates)) * (1.0 if self._rng.random() < 0.5 else -1.0)
            self._wanted = rate * self._distance
        step = self.RAMP * dt
        self._speed += min(max(self._wanted - self._speed, -step), step)
        here = poses[self._robot.name]
        dx, dy = here.x - self._centre[0], here.y - self._centre[1]
        outward = math.atan2(dy, dx)
        off = math.hypot(dx, dy) - self._distance
        # Driving ahead is counter-clockwise. The correction towards the circle changes its sign in reverse.
        pull = min(max(self.RADIAL_GAIN * off, -0.8), 0.8) * (1.0 if self._speed >= 0.0 else -1.0)
        skew = math.remainder(outward + math.pi / 2 + pull - here.heading, 2 * math.pi)
        return self._robot.wheels_for(self._speed, self._speed / self._distance + self.HEADING_GAIN * skew)
