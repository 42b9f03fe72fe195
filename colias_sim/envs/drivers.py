"""How the other robots of an env drive: by their wheels, with senses that the observer lacks."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import Protocol

import numpy as np

from colias_sim.robot import Pose, Robot, WheelSpeeds
from scenes import ARENA_RADIUS_CM

RADIUS = ARENA_RADIUS_CM / 100
HULL = 0.02


class Driver(Protocol):
    """Drives one robot."""

    def wheels(self, dt: float, poses: Mapping[str, Pose]) -> WheelSpeeds:
        """What to command for the next ``dt`` seconds, ``poses`` being where everybody is, itself too."""
        ...


class Wander:
    """Ahead at ``speed`` (m/s) on a meandering path, turning on the spot before a wall or robot.

    It notices what is within ``REACH`` metres of its hull and in a cone about its heading, the wider the nearer it
    is, and turns away from it until the way is free. ``unheeded`` are the robots that it does not notice.
    """

    REACH = 0.045
    FAR_CONE, NEAR_CONE = math.radians(65), math.radians(120)  # more than a right angle: no grazing, and no way in
    MEANDER, MEMORY_S = 0.5, 1.0  # rad/s, standard deviation; seconds
    AVOIDING = 2.5  # rad/s

    def __init__(
        self, robot: Robot, speed: float, rng: np.random.Generator, unheeded: Collection[str] = ()
    ) -> None:  # fmt: skip
        self._robot, self._speed, self._rng, self._unheeded = robot, speed, rng, {robot.name, *unheeded}
        self._turn = self._avoiding = 0.0

    def wheels(self, dt: float, poses: Mapping[str, Pose]) -> WheelSpeeds:
        """What to command for the next ``dt`` seconds."""
        fade = math.exp(-dt / self.MEMORY_S)
        kick = math.sqrt(1.0 - fade * fade) * self.MEANDER * float(self._rng.standard_normal())
        self._turn = fade * self._turn + kick  # drawn always: what comes after does not depend on what is near
        side = self._blocked(poses)
        if side == 0.0:
            self._avoiding = 0.0
            return self._robot.wheels_for(self._speed, self._turn)
        self._avoiding = self._avoiding or -side * self.AVOIDING
        return self._robot.wheels_for(0.0, self._avoiding)

    def _blocked(self, poses: Mapping[str, Pose]) -> float:
        """0 where the way is free, else the side of the nearest thing in it: 1 left, -1 right."""
        here = poses[self._robot.name]
        nearest, side = self.REACH, 0.0
        others = (gap_to(here, there) for name, there in poses.items() if name not in self._unheeded)
        for gap, direction in (wall(here), *others):
            if gap < nearest and abs(direction) < self._cone(gap):
                nearest, side = gap, 1.0 if direction >= 0.0 else -1.0
        return side

    def _cone(self, gap: float) -> float:
        return self.NEAR_CONE + (self.FAR_CONE - self.NEAR_CONE) * max(gap, 0.0) / self.REACH


class Orbit:
    """Round a centre at a distance (metres), to and fro: the angular rate is drawn anew every few seconds.

    Rates are uniform in ``slowest..fastest`` rad/s with a random sign, kept for ``1..4`` seconds. It reverses by
    driving backwards.
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
        """What to command for the next ``dt`` seconds."""
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
        # Counter-clockwise ahead; what pulls back to the circle changes sides when it drives backwards.
        pull = min(max(self.RADIAL_GAIN * off, -0.8), 0.8) * (1.0 if self._speed >= 0.0 else -1.0)
        skew = math.remainder(outward + math.pi / 2 + pull - here.heading, 2 * math.pi)
        return self._robot.wheels_for(self._speed, self._speed / self._distance + self.HEADING_GAIN * skew)


def wall(here: Pose) -> tuple[float, float]:
    """Metres from the hull to the nearest wall, and the wall's direction off the heading in radians."""
    out = math.hypot(here.x, here.y)
    direction = math.atan2(here.y, here.x) if out > 1e-9 else here.heading
    return RADIUS - out - HULL, math.remainder(direction - here.heading, 2 * math.pi)


def gap_to(here: Pose, there: Pose) -> tuple[float, float]:
    """Metres between two hulls, and the other's direction off the heading in radians, left positive."""
    dx, dy = there.x - here.x, there.y - here.y
    return math.hypot(dx, dy) - 2 * HULL, math.remainder(math.atan2(dy, dx) - here.heading, 2 * math.pi)


def scatter(
    rng: np.random.Generator, count: int, taken: Iterable[Pose] = (), *, apart: float = 0.08, clear: float = 0.12
) -> list[Pose]:
    """``count`` random poses in the arena, ``apart`` metres from each other and ``clear`` from those ``taken``.

    Where no such place is left the nearest to it is taken, still outside of every hull.
    """
    kept = [(pose, clear) for pose in taken]
    found: list[Pose] = []
    for _ in range(count):
        best, most = Pose(0.0, 0.0, 0.0), -math.inf
        for _ in range(200):
            out, turn, heading = rng.random(), rng.uniform(-math.pi, math.pi), float(rng.uniform(-math.pi, math.pi))
            away = (RADIUS - 0.06) * math.sqrt(out)
            pose = Pose(away * math.cos(turn), away * math.sin(turn), heading)
            room = min((math.hypot(pose.x - p.x, pose.y - p.y) - far for p, far in kept), default=math.inf)
            if room > most:
                best, most = pose, room
            if room >= 0.0:
                break
        kept.append((best, apart))
        found.append(best)
    return found
