"""What many robots do and how it is measured, whatever they see: traffic, and chains."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig
from colias_sim.envs.geometry import ARENA_RADIUS
from colias_sim.envs.options import FPS
from colias_sim.envs.swarm import WALL, Body, Drive, Swarm
from colias_sim.pose import Pose, WheelSpeeds

Tracks = npt.NDArray[np.float64]
"""A type: places of the robots, (T, N, 3), x and y in m, heading in radians."""
Seen = dict[str, list[npt.NDArray[np.uint8]]]
"""A type: name of a robot -> its pictures, (R, C) each."""
HULL_CM, TURN = 4.0, 0.25
"""Diameter of a hull, and wheel speeds of a turn on the spot, as shares of the maximum: 313 degrees/s."""
RING_M, GAP_M = 0.26, 0.11
"""Radius of the leader's circle, and the distance along it from one robot to the next at the start, in metres."""
LOST_M, LOST_FRAMES = 0.30, 15
"""A link is broken when the robot ahead is farther than this, or out of the camera's view, for half a second."""


class Pedestrian:
    """Drive ahead; turn away from what ``alarm`` says, turn back at the wall, back off from a touch.

    While it turns and backs off, and for the few frames in which that still echoes in its network, it does not look.

    Parameters
    ----------
    alarm
        From a response to the side to turn to: 1 right, -1 left, 0 neither.
    ahead
        Speed ahead, as a share of the maximum.
    rng
        Generator of turns after a touch.
    """

    FRAMES, ECHO, WALL_M, BACK = 8, 4, 0.03, 12

    def __init__(self, alarm: Callable[[Any], float], ahead: float, rng: np.random.Generator) -> None:
        self._alarm, self._ahead, self._rng = alarm, ahead, rng
        self._doing: list[WheelSpeeds] = []

    def __call__(self, seen: Any, body: Body) -> WheelSpeeds:
        """Return the wheels for the next frame."""
        cruise = (self._ahead, self._ahead)
        if self._doing:
            return self._doing.pop()
        side, frames = 0.0, self.FRAMES
        if body.touched:
            side, frames = (1.0 if self._rng.random() < 0.5 else -1.0), int(self._rng.integers(4, 16))
        elif body.wall_m < self.WALL_M and math.cos(body.wall_bearing) > 0.2:
            side, frames = -math.copysign(1.0, body.wall_bearing), 4
        elif seen is not None:
            side = self._alarm(seen)
        if side == 0.0:
            return cruise
        back = [(-self._ahead, -self._ahead)] * (self.BACK if body.touched else 0)
        self._doing = [
            *[cruise] * self.ECHO,
            *[(side * TURN, -side * TURN)] * frames,
            *back,
        ]  # from the last to the first
        return self._doing.pop()


def by_chance(robots: int, speed_cm_s: float) -> float:
    """Return how often a robot a minute meets others that drive straight in random directions.

    As in a gas of discs: 2 D n v_rel, with the hull's diameter D, n robots an area, and the mean relative speed 4/pi v.
    """
    area = math.pi * (100 * ARENA_RADIUS - HULL_CM / 2) ** 2
    return 60.0 * 2.0 * HULL_CM * (robots - 1) / area * 4.0 / math.pi * speed_cm_s


def chain(rng: np.random.Generator, number: int) -> list[Pose]:
    """Put robots on the leader's circle, each facing along it, some millimetres off; the first one leads."""
    turns = [-GAP_M / RING_M * k for k in range(number)]
    away = RING_M + rng.normal(0.0, 0.002, number)
    return [Pose(out * math.cos(at), out * math.sin(at), at + math.pi / 2) for out, at in zip(away, turns, strict=True)]


def spread_cm(tracks: Tracks) -> float:
    """Return the rms difference of a chain's gaps from those at the start, in cm."""
    gaps, _ = _links(tracks)
    return float(100 * np.sqrt(((gaps - gaps[0]) ** 2).mean()))


def breaks(tracks: Tracks) -> float:
    """Return the share of a chain's links that were lost for `LOST_FRAMES` in a row."""
    gaps, off = _links(tracks)
    lost = (gaps > LOST_M) | (np.abs(off) > math.radians(CameraConfig().hfov_deg / 2))
    return float(np.lib.stride_tricks.sliding_window_view(lost, LOST_FRAMES, 0).all(2).any(0).mean())


def _links(tracks: Tracks) -> tuple[Tracks, Tracks]:
    """Return the gap of each link, (T, N - 1) in m, and the bearing off its heading at which a robot has the next."""
    x, y, heading = np.moveaxis(tracks, 2, 0)
    dx, dy = x[:, :-1] - x[:, 1:], y[:, :-1] - y[:, 1:]
    return np.hypot(dx, dy), np.remainder(np.arctan2(dy, dx) - heading[:, 1:] + np.pi, 2 * np.pi) - np.pi


def played(swarm: Swarm, drives: Mapping[str, Drive], frames: int, every: int) -> tuple[Tracks, Tracks, Seen]:
    """Play some frames.

    Parameters
    ----------
    swarm
        The robots, after their reset.
    drives
        What drives each.
    frames
        How many.
    every
        Number of frames from one picture that is kept to the next; 0 keeps none.

    Returns
    -------
    tracks, commands : ndarray
        Places, (T, N, 3), and wheel speeds, (T, N, 2), as shares of the maximum.
    seen : dict of str to list of ndarray
        The pictures by the robot's name.
    """
    tracks, commands, seen = [], [], Seen((name, []) for name in drives if every)
    for frame in range(frames):
        swarm.play(drives)
        tracks.append([(pose.x, pose.y, pose.heading) for pose in swarm.sim.poses.values()])
        commands.append([agent.wheels for agent in swarm.agents.values()])
        for name in seen if every and frame % every == 0 else ():
            seen[name].append(swarm.agents[name].luma)
    return np.array(tracks), np.array(commands), seen


def encounters(tracks: Tracks, collisions: Sequence[tuple[int, frozenset[str]]]) -> dict[str, float]:
    """Measure any crowd: collisions of robots, theirs and those with the wall a robot and minute, metres driven each.

    Parameters
    ----------
    tracks
        The places.
    collisions
        As of a `colias_sim.envs.swarm.Swarm`.
    """
    frames, number, _ = tracks.shape
    walls = sum(WALL in pair for _, pair in collisions)
    met, robot_minutes = len(collisions) - walls, number * frames / FPS / 60.0
    driven = np.hypot(*np.diff(tracks[..., :2], axis=0).transpose(2, 0, 1)).sum()
    return {
        "collisions": met, "collisions_a_min": 2.0 * met / robot_minutes, "wall_a_min": walls / robot_minutes,
        "driven_m": float(driven) / number,
    }  # fmt: skip
