"""Pursuit: follow another robot at a set distance."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from colias_sim.envs.base import TargetEnv
from colias_sim.envs.geometry import ARENA_RADIUS, gap_to_robot, random_poses
from colias_sim.envs.measures import PER_MINUTE, SIZE, Values
from colias_sim.envs.options import MOST_ROBOTS, STRICT, EnvOptions
from colias_sim.envs.scripted import Driver, Wander
from colias_sim.envs.world import OBSERVER, TARGET, parked_robots
from colias_sim.pose import Pose
from dsnn.field_docs import unit, with_field_docs


@with_field_docs
@dataclass(frozen=True, kw_only=True, config=STRICT)
class PursuitOptions(EnvOptions):
    """Keyword arguments of `Pursuit`."""

    robots: int = Field(default=1, ge=1, le=MOST_ROBOTS)
    """Other robots: the target, the rest parked."""
    distance_cm: Annotated[float, unit("cm")] = Field(default=10.0, ge=2.0, le=30.0)
    """Target gap between the hulls."""
    target_speed_cm_s: Annotated[float, unit("cm/s")] = Field(default=6.0, ge=0.0, le=20.0)
    """Speed of the target."""


class Pursuit(TargetEnv[PursuitOptions]):
    """
    ## Description

    Follow a black Colias that wanders about the arena, at a set distance. The target meanders, and turns away on the
    spot from anything within 4.5 cm of it, except the observer.

    ## Rewards

    - `distance`: 1 - |gap - `distance_cm`| / `distance_cm`, at least -1; the gap is the distance between the hulls.
    - `centre`: 1 - |bearing| / half the view, at least -1; the bearing is the target's angle off the optical axis.
    - `touch`: -10 when the hull touches anything.

    ## Info

    This env adds `gap_cm`, `bearing_deg` (right positive) and `in_view` (whether that is within half the view).

    ## Starting State

    The target stands at a random place on a ring about the arena's middle. The observer stands behind it at the target
    distance, and faces it. Robots beyond the first are parked at random places.

    ## Episode End

    Terminated when the observer touches anything; truncated after 900 steps (30 s, times `frame_skip`).

    ## Arguments

    `help(env.unwrapped.options)` lists them. What all envs share, such as spaces and `info`: `help(colias_sim.envs)`.

    ## Version History

    - v0: first release.
    """

    options_type: ClassVar[type[EnvOptions]] = PursuitOptions
    max_episode_steps = 900
    summary = "follow another robot at a set distance"
    baselines = ("random-walk", "straight", "oracle-distance")
    columns: ClassVar = {**TargetEnv.columns, "gap_error_cm": SIZE}
    measures: ClassVar = {"time on target": "in_view", "gap error (cm)": "gap_error_cm"}
    collisions = (PER_MINUTE,)
    note = "Time on target: the share of frames with the target in the camera's horizontal view."
    draws_paths = True

    def _begin(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        options = self.options
        away = options.distance_cm / 100 + 0.04
        # On a ring about the middle, heading along it: away from the wall, with room behind for the observer.
        ring = max(min(ARENA_RADIUS - 0.08, 0.5 * away + 0.1), 0.12)
        turn, way = float(rng.uniform(-math.pi, math.pi)), 1.0 if rng.random() < 0.5 else -1.0
        behind = turn - way * 2 * math.asin(min(away / 2 / ring, 1.0))
        target = Pose(ring * math.cos(turn), ring * math.sin(turn), turn + way * math.pi / 2)
        x, y = ring * math.cos(behind), ring * math.sin(behind)
        observer = Pose(x, y, math.atan2(target.y - y, target.x - x))
        places = {OBSERVER: observer, TARGET: target}
        obstacles = self._sim.obstacles
        others = random_poses(rng, options.robots - 1, places.values(), obstacles=obstacles)
        places |= zip(parked_robots(options.robots - 1), others, strict=True)
        speed = options.target_speed_cm_s / 100
        driver = Wander(self._sim.robots[TARGET], speed, rng, unheeded=[OBSERVER], obstacles=obstacles)
        return places, {TARGET: driver}

    def _reward(self) -> dict[str, float]:
        wanted = self.options.distance_cm
        return {"distance": max(1.0 - abs(self._gap_cm() - wanted) / wanted, -1.0), "centre": self._centre()}

    def _gap_cm(self) -> float:
        return 100 * gap_to_robot(self._here, self._sim.robots[TARGET].pose)[0]

    def _measures(self) -> dict[str, Any]:
        return {"gap_cm": self._gap_cm(), **super()._measures()}

    def measured(self, infos: Mapping[str, Values]) -> dict[str, float | None]:
        """Compute the columns of an episode."""
        error = infos["gap_cm"] - self.options.distance_cm
        return {**super().measured(infos), "gap_error_cm": float(np.abs(error).mean())}
