"""The scenarios that ship: many robots that all see. Each has a reflex that works without training."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from colias_sim import CameraConfig, Pose, RobotConfig
from colias_sim.envs.geometry import ARENA_RADIUS, random_poses
from colias_sim.envs.swarm import Body, Drive
from dsnn import Response
from experiments.declare.behaviour import Wheels
from experiments.declare.checks import Check
from experiments.declare.claim import Claim
from experiments.declare.scenario import BLIND, Scenario, SwarmDesign, Tracks
from experiments.paper.behaviours import ProportionalIntegral, turn

HULL_CM, TURN = 4.0, 0.25
"""Diameter of a hull, and wheel speeds of a turn on the spot, as shares of the maximum: 313 degrees/s."""


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

    def __init__(self, alarm: Callable[[Response], float], ahead: float, rng: np.random.Generator) -> None:
        self._alarm, self._ahead, self._rng = alarm, ahead, rng
        self._doing: list[Wheels] = []

    def __call__(self, seen: Response | None, body: Body) -> Wheels:
        """Return the wheels for the next frame."""
        cruise = turn(0.0, self._ahead)
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
        back = [turn(0.0, -self._ahead)] * (self.BACK if body.touched else 0)
        self._doing = [*[cruise] * self.ECHO, *[turn(side * TURN)] * frames, *back]  # from the last to the first
        return self._doing.pop()


def pedestrian(number: int, ahead: float, channels: Sequence[str], rng: np.random.Generator) -> Drive:
    """Make a robot in traffic: a looming spike turns it to a side by chance, or HS alone away from what moves."""

    def looms(seen: Response) -> float:
        return (1.0 if rng.random() < 0.5 else -1.0) if seen.looming_spikes else 0.0

    def moves(seen: Response) -> float:
        return -math.copysign(1.0, seen.hs_spikes) if seen.hs_spikes else 0.0

    return Pedestrian(looms if "looming" in channels else moves, ahead, rng)


def by_chance(robots: int, speed_cm_s: float) -> float:
    """Return how often a robot a minute meets others that drive straight in random directions.

    As in a gas of discs: 2 D n v_rel, with the hull's diameter D, n robots an area, and the mean relative speed 4/pi v.
    """
    area = math.pi * (100 * ARENA_RADIUS - HULL_CM / 2) ** 2
    return 60.0 * 2.0 * HULL_CM * (robots - 1) / area * 4.0 / math.pi * speed_cm_s


def halved(model: str) -> Callable[[Sequence[Mapping[str, Any]]], list[Check]]:
    """Make the judge of a claim that a swarm collides at most half as often as a blind one, over all densities."""

    def judge(rows: Sequence[Mapping[str, Any]]) -> list[Check]:
        seeing, blind = (sum(row["collisions"] for row in rows if row["model"] == name) for name in (model, BLIND))
        share = seeing / blind if blind else math.inf
        return [Check(f"{seeing} collisions of {model}, {blind} of blind ones: {share:.2f}", share, 0.5, "at most")]

    return judge


def kept(rows: Sequence[Mapping[str, Any]]) -> list[Check]:
    """Judge by how much fewer links break with HS than without, as a share of all, over all speeds."""
    seeing, blind = (
        float(np.mean([row["breaks"] for row in rows if row["model"] == name])) for name in ("dsnn", BLIND)
    )
    return [Check(f"{seeing:.2f} of links broken by HS, {blind:.2f} blind", blind - seeing, 0.5, "at least")]


TRAFFIC = Scenario(
    name="traffic",
    summary="robots cross a square and turn away from what looms, or are blind, or see by HS alone",
    start=random_poses,
    make=pedestrian,
    models=("lgmd2", "dsnn", BLIND),
    design=SwarmDesign(robots=(4, 8, 12), seconds=30.0),
    chance=by_chance,
    claims=(
        Claim(
            id="B5",
            on="swarm",
            judge=halved("lgmd2"),
            models=frozenset({"lgmd2", BLIND}),
            title="Looming halves collisions in traffic",
            says="robots that turn away from what looms to LGMD2 collide at most half as often as blind ones",
        ),
        Claim(
            id="B6",
            on="swarm",
            judge=halved("dsnn"),
            models=frozenset({"dsnn", BLIND}),
            title="HS alone halves collisions in traffic",
            says="robots that turn away from motion by the DSNN's HS alone collide at most half as often as blind ones",
        ),
    ),
)

RING_M, GAP_M = 0.26, 0.11
"""Radius of the leader's circle, and the distance along it from one robot to the next at the start, in metres."""
GAINS = 1.0, 8.0
"""Proportional and integral gains of a follower (1, 1/s), of five pairs tried with four robots at seed 0."""
LOST_M, LOST_FRAMES = 0.30, 15
"""A link is broken when the robot ahead is farther than this, or out of the camera's view, for half a second."""


def chain(rng: np.random.Generator, number: int) -> list[Pose]:
    """Put robots on the leader's circle, each facing along it, some millimetres off; the first one leads."""
    turns = [-GAP_M / RING_M * k for k in range(number)]
    away = RING_M + rng.normal(0.0, 0.002, number)
    return [Pose(out * math.cos(at), out * math.sin(at), at + math.pi / 2) for out, at in zip(away, turns, strict=True)]


def follower(number: int, ahead: float, channels: Sequence[str], rng: np.random.Generator) -> Drive:
    """Make the leader, which drives on its circle, or a robot that turns to null HS, or a blind one that drives on."""
    circle = ahead * (RobotConfig().track_cm / 200) / RING_M
    rule = ProportionalIntegral(lambda seen: seen.hs, *GAINS)

    def drive(seen: Response | None, body: Body) -> Wheels:
        if number == 0:
            return turn(-circle, ahead)
        left, right = rule(seen) if seen is not None else (0.0, 0.0)
        return ahead + left, ahead + right

    return drive


def links(tracks: Tracks) -> Mapping[str, float]:
    """Measure a chain: the rms difference of its gaps from those at the start, and the share of links that broke."""
    x, y, heading = np.moveaxis(tracks, 2, 0)
    dx, dy = x[:, :-1] - x[:, 1:], y[:, :-1] - y[:, 1:]
    gaps = np.hypot(dx, dy)
    off = np.remainder(np.arctan2(dy, dx) - heading[:, 1:] + np.pi, 2 * np.pi) - np.pi
    lost = (gaps > LOST_M) | (np.abs(off) > math.radians(CameraConfig().hfov_deg / 2))
    streak, broken = np.zeros(lost.shape[1]), np.zeros(lost.shape[1], bool)
    for row in lost:
        streak = (streak + 1) * row
        broken |= streak >= LOST_FRAMES
    return {"spread_cm": float(100 * np.sqrt(((gaps - gaps[0]) ** 2).mean())), "breaks": float(broken.mean())}


FOLLOW = Scenario(
    name="follow",
    summary="a chain on a circle, each keeps the one ahead in its view by HS, or is blind",
    start=chain,
    make=follower,
    models=("dsnn", BLIND),
    design=SwarmDesign(robots=(5,), speeds_cm_s=(4.0, 8.0), seconds=8.0),
    measure=links,
    figure=("breaks", "share of links broken"),
    along="speed_cm_s",
    arena="plain",
    claims=(
        Claim(
            id="B7",
            on="swarm",
            judge=kept,
            models=frozenset({"dsnn", BLIND}),
            title="HS keeps a chain together",
            says="of a chain that nulls HS the share of links that break is lower by half or more than of a blind one",
        ),
    ),
)

EXPERIMENTS = (TRAFFIC, FOLLOW)
