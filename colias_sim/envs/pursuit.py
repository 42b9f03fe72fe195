"""Pursuit: follow another robot at a set distance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from colias_sim.envs.base import OBSERVER, TARGET, parked
from colias_sim.envs.describing import documented
from colias_sim.envs.drivers import RADIUS, Driver, Wander, gap_to, scatter
from colias_sim.envs.options import MOST_ROBOTS, STRICT, EnvOptions
from colias_sim.envs.targeted import TargetEnv
from colias_sim.robot import Pose


@dataclass(frozen=True, config=STRICT)
class PursuitOptions(EnvOptions):
    """The arguments of `Pursuit`."""

    robots: int = Field(default=1, ge=1, le=MOST_ROBOTS, description="other robots: the target, the rest parked")
    distance_cm: float = Field(default=10.0, ge=2.0, le=30.0, description="between the hulls, to be kept")
    target_speed_cm_s: float = Field(default=6.0, ge=0.0, le=20.0, description="of the target")


@documented
class Pursuit(TargetEnv[PursuitOptions]):
    """
    ## Description

    Follow a black Colias that wanders about the arena, at a set distance. The target meanders, turns away on the spot
    from what comes within 4.5 cm of it, and does not heed who follows.

    ## Action Space

    <ACTIONS>

    ## Observation Space

    <OBSERVATIONS>

    ## Rewards

    - `distance`: 1 - |gap - `distance_cm`| / `distance_cm`, at least -1; the gap is that between the hulls.
    - `centre`: 1 - |bearing| / 35 degrees, at least -1; the bearing is the target's angle off the optical axis.
    <REWARDS>

    ## Info

    <INFO>

    Here: `gap_cm`, `bearing_deg` (left positive) and `in_view` (whether that is within 35 degrees).

    ## Starting State

    The target is put down anywhere, the observer behind it at the distance to be kept, looking at it; robots beyond
    the first are parked.

    <RANDOM>

    ## Episode End

    Terminated when the observer touches anything; truncated after 900 steps (30 s, times `frame_skip`).

    ## Arguments

    <ARGUMENTS>

    ## Version History

    - v0: first release.
    """

    options_type: ClassVar[type[EnvOptions]] = PursuitOptions

    def _begin(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        own = self.options
        away = own.distance_cm / 100 + 0.04
        # In a ring about the middle, driving along it: wall on neither side, room behind for the observer.
        ring = max(min(RADIUS - 0.08, 0.5 * away + 0.1), 0.12)
        turn, way = float(rng.uniform(-math.pi, math.pi)), 1.0 if rng.random() < 0.5 else -1.0
        behind = turn - way * 2 * math.asin(min(away / 2 / ring, 1.0))
        target = Pose(ring * math.cos(turn), ring * math.sin(turn), turn + way * math.pi / 2)
        x, y = ring * math.cos(behind), ring * math.sin(behind)
        observer = Pose(x, y, math.atan2(target.y - y, target.x - x))
        places = {OBSERVER: observer, TARGET: target}
        places |= zip(parked(own.robots - 1), scatter(rng, own.robots - 1, places.values()), strict=True)
        driver = Wander(self._sim.robots[TARGET], own.target_speed_cm_s / 100, rng, unheeded=[OBSERVER])
        return places, {TARGET: driver}

    def _reward(self) -> dict[str, float]:
        wanted = self.options.distance_cm
        return {"distance": max(1.0 - abs(self._gap_cm() - wanted) / wanted, -1.0), "centre": self._centre()}

    def _gap_cm(self) -> float:
        robots = self._sim.robots
        return 100 * gap_to(robots[OBSERVER].pose, robots[TARGET].pose)[0]

    def _measures(self) -> dict[str, Any]:
        return {"gap_cm": self._gap_cm(), **super()._measures()}
