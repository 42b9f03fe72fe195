"""Distances and free places in the round arena with its robots and obstacles."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from colias_sim.pose import Pose
from scenes import ARENA_RADIUS_CM
from scenes.hints import nearest

if TYPE_CHECKING:
    from colias_sim.obstacles import Obstacle

ARENA_RADIUS = ARENA_RADIUS_CM / 100
"""Radius of the arena, in metres."""
HULL_RADIUS = 0.02
"""Radius of a robot's hull, in metres."""
CLEARANCE = 0.01
"""Least gap between a moved or given start and the nearest robot, obstacle or wall, in metres."""
APART = 2 * HULL_RADIUS + CLEARANCE
"""Least distance between the centres of two given starts, in metres."""
_SHARES = 20


def gap_to_arena(here: Pose, obstacles: Collection[Obstacle] = ()) -> tuple[float, float]:
    """Measure distance and direction to the nearest point of the wall or of an obstacle.

    Parameters
    ----------
    here
        Pose of a robot.
    obstacles
        What stands in the arena.

    Returns
    -------
    gap : float
        Distance from the robot's hull to this point, in metres.
    direction : float
        Direction of this point off the robot's heading, in radians, left positive.
    """
    out = math.hypot(here.x, here.y)
    direction = math.atan2(here.y, here.x) if out > 1e-9 else here.heading
    way = ARENA_RADIUS - out - HULL_RADIUS, math.remainder(direction - here.heading, 2 * math.pi)
    for obstacle in obstacles:
        distance, x, y = obstacle.nearest(here.x, here.y)
        if distance - HULL_RADIUS < way[0]:
            direction = math.atan2(y - here.y, x - here.x) - here.heading
            way = distance - HULL_RADIUS, math.remainder(direction, 2 * math.pi)
    return way


def gap_to_robot(here: Pose, there: Pose) -> tuple[float, float]:
    """Measure distance and direction from one robot to another.

    Parameters
    ----------
    here, there
        Poses of the two robots.

    Returns
    -------
    gap : float
        Distance between the two hulls, in metres.
    direction : float
        Direction of the other robot off the heading of ``here``, in radians, left positive.
    """
    dx, dy = there.x - here.x, there.y - here.y
    return math.hypot(dx, dy) - 2 * HULL_RADIUS, math.remainder(math.atan2(dy, dx) - here.heading, 2 * math.pi)


def random_poses(
    rng: np.random.Generator, count: int, taken: Iterable[Pose] = (), *, apart: float = 0.08, clear: float = 0.12,
    obstacles: Collection[Obstacle] = (),
) -> list[Pose]:  # fmt: skip
    """Draw poses at a distance from each other and from occupied poses.

    Each pose is the first of at most 200 draws that satisfies both distances. If none does, it is the best draw, which
    is still outside every hull.

    Parameters
    ----------
    rng
        The generator to draw from.
    count
        The number of poses.
    taken
        Poses that are taken already.
    apart
        Least distance between the centres of two new poses, in metres.
    clear
        Least distance between the centres of a new pose and one that is taken, in metres.
    obstacles
        What stands in the arena; hulls keep `CLEARANCE` from it.

    Returns
    -------
    list of Pose
        ``count`` poses, uniform over the arena except 4 cm along its wall, with uniform headings.
    """
    kept = [(pose, clear) for pose in taken]
    placed: list[Pose] = []
    for _ in range(count):
        best, most = Pose(0.0, 0.0, 0.0), -math.inf
        for _ in range(200):
            out, turn, heading = rng.random(), rng.uniform(-math.pi, math.pi), float(rng.uniform(-math.pi, math.pi))
            away = (ARENA_RADIUS - 0.06) * math.sqrt(out)
            pose = Pose(away * math.cos(turn), away * math.sin(turn), heading)
            room = min((math.hypot(pose.x - p.x, pose.y - p.y) - far for p, far in kept), default=math.inf)
            if obstacles:
                room = min(room, gap_to_arena(pose, obstacles)[0] - CLEARANCE)
            if room > most:
                best, most = pose, room
            if room >= 0.0:
                break
        kept.append((best, apart))
        placed.append(best)
    return placed


def moved(
    places: Mapping[str, Pose], name: str, ahead: float, left: float, obstacles: Collection[Obstacle] = ()
) -> dict[str, Pose]:
    """Move one robot's start, as far as it stays clear of other robots, the wall and obstacles.

    Parameters
    ----------
    places
        The start of every robot.
    name
        The robot to move.
    ahead, left
        Distances, in metres, along its heading and to its left.
    obstacles
        What stands in the arena.

    Returns
    -------
    dict
        The starts. The move is shortened in steps of a twentieth until a gap of `CLEARANCE` remains.
    """
    start = places[name]
    cos, sin = math.cos(start.heading), math.sin(start.heading)
    dx, dy = ahead * cos - left * sin, ahead * sin + left * cos
    others = [pose for other, pose in places.items() if other != name]
    for part in range(_SHARES, 0, -1):
        share = part / _SHARES
        pose = Pose(start.x + share * dx, start.y + share * dy, start.heading)
        gaps = [math.hypot(pose.x - other.x, pose.y - other.y) - 2 * HULL_RADIUS for other in others]
        if min([*gaps, gap_to_arena(pose, obstacles)[0]]) >= CLEARANCE:
            return {**places, name: pose}
    return dict(places)


def given_poses(
    given: Mapping[str, tuple[float, float, float]], robots: Collection[str], obstacles: Collection[Obstacle] = ()
) -> dict[str, Pose]:
    """Check the start poses among the options of a reset.

    Parameters
    ----------
    given
        Robot -> (x_cm, y_cm, heading_deg).
    robots
        The names of the env's robots.
    obstacles
        What stands in the arena.

    Returns
    -------
    dict
        Robot -> its start.

    Raises
    ------
    ValueError
        The robot is unknown, or is within 1 cm of another robot, an obstacle or the wall.
    """
    poses: dict[str, Pose] = {}
    for name, place in given.items():
        if name not in robots:
            raise ValueError(f"poses: no robot '{name}' ({nearest(name, robots, after='; ')}all: {', '.join(robots)})")
        x_cm, y_cm, heading_deg = map(float, place)
        pose = Pose(x_cm / 100, y_cm / 100, math.radians(heading_deg))
        free = gap_to_arena(pose, obstacles)[0] >= CLEARANCE - 1e-9 and not _near(pose, poses.values())
        if not (free and math.isfinite(heading_deg)):
            raise ValueError(
                f"poses: {name} must be {100 * CLEARANCE:g} cm or more from other robots, obstacles and the wall,"
                f" got {place}"
            )
        poses[name] = pose
    return poses


def placed(
    places: Mapping[str, Pose], given: Mapping[str, Pose], rng: np.random.Generator,
    obstacles: Collection[Obstacle] = (),
) -> dict[str, Pose]:  # fmt: skip
    """Place robots at given starts, and draw new starts for other robots in their way.

    Parameters
    ----------
    places
        The start of every robot, as drawn.
    given
        The requested starts, from `given_poses`.
    rng
        Generator of the new starts.
    obstacles
        What stands in the arena.

    Returns
    -------
    dict
        The starts. A robot that is not in ``given`` keeps its drawn start, unless its hull is within `CLEARANCE` of a
        given one.
    """
    poses = {**places, **given}
    for name in places:
        if name not in given and _near(poses[name], given.values()):
            others = [pose for other, pose in poses.items() if other != name]
            (poses[name],) = random_poses(rng, 1, others, clear=APART, obstacles=obstacles)
    return poses


def _near(pose: Pose, others: Iterable[Pose]) -> bool:
    return any(math.hypot(pose.x - other.x, pose.y - other.y) < APART for other in others)
