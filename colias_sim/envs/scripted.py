"""Scripted drivers of the other robots: they know the poses of all robots, and command wheel speeds."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING, Protocol

import numpy as np

from colias_sim.envs.geometry import HULL_RADIUS, gap_to_arena, gap_to_robot
from colias_sim.pose import Pose, WheelSpeeds
from colias_sim.robot import Robot

if TYPE_CHECKING:
    from colias_sim.obstacles import Obstacle


class Driver(Protocol):
    """The interface of a driver of one robot."""

    def wheels(self, dt: float, poses: Mapping[str, Pose]) -> WheelSpeeds:
        """Choose the wheel speeds for the next control interval.

        Parameters
        ----------
        dt
            Length of the interval, in seconds.
        poses
            Poses of all robots by name, including the driven one.

        Returns
        -------
        tuple of float
            The speeds to command, in m/s.
        """
        ...


class Wander:
    """Wandering driver: it meanders ahead, and turns on the spot near a wall, an obstacle or a robot.

    The driver detects anything within ``REACH`` metres of the hull inside a cone about the heading. The cone widens as
    the distance falls. The robot turns away until the path is free.

    Parameters
    ----------
    robot
        The robot to drive.
    speed
        Speed ahead, in m/s.
    rng
        Generator of the meandering.
    unheeded
        Names of the robots that it ignores.
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
        self._turn = fade * self._turn + kick  # drawn even if unused, so that later draws are the same
        side = self._blocked(poses)
        if side == 0.0:
            self._avoiding = 0.0
            return self._robot.wheels_for(self._speed, self._turn)
        self._avoiding = self._avoiding or -side * self.AVOIDING
        return self._robot.wheels_for(0.0, self._avoiding)

    def _blocked(self, poses: Mapping[str, Pose]) -> float:
        """Find the side of the nearest thing in the path: 1 left, -1 right, 0 if the path is free."""
        here = poses[self._robot.name]
        nearest, side = self.REACH, 0.0
        far = 2 * (self.REACH + HULL_RADIUS)  # between two centres: beyond what is detected
        near = [name for name, pose in poses.items() if abs(pose.x - here.x) < far and abs(pose.y - here.y) < far]
        others = (gap_to_robot(here, poses[name]) for name in near if name not in self._unheeded)
        for gap, direction in (gap_to_arena(here, self._obstacles), *others):
            if gap < nearest and abs(direction) < self._cone(gap):
                nearest, side = gap, 1.0 if direction >= 0.0 else -1.0
        return side

    def _cone(self, gap: float) -> float:
        return self.NEAR_CONE + (self.FAR_CONE - self.NEAR_CONE) * max(gap, 0.0) / self.REACH


class Orbit:
    """Orbiting driver: it circles back and forth about a centre.

    Every 1 to 4 seconds it draws a new angular rate and direction. To reverse, the robot drives backward.

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
