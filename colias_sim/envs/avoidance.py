"""Avoidance: drive about without touching anything."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from colias_sim.envs.base import ColiasEnv
from colias_sim.envs.geometry import random_poses
from colias_sim.envs.measures import COLLISIONS
from colias_sim.envs.options import MOST_ROBOTS, STRICT, Arena, EnvOptions
from colias_sim.envs.scripted import Driver, Wander
from colias_sim.envs.world import OBSERVER, parked_robots
from colias_sim.pose import Pose
from dsnn.field_docs import unit, with_field_docs


@with_field_docs
@dataclass(frozen=True, kw_only=True, config=STRICT)
class AvoidanceOptions(EnvOptions):
    """Keyword arguments of `Avoidance`."""

    arena: Arena = "leaves"
    """An arena of scenes, or your own file."""
    robots: int = Field(default=10, ge=1, le=MOST_ROBOTS)
    """Other robots, moving and parked."""
    moving: int = Field(default=5, ge=0, le=MOST_ROBOTS)
    """Number of the other robots that move; at most all."""
    speed_cm_s: Annotated[float, unit("cm/s")] = Field(default=8.0, ge=0.0, le=20.0)
    """Speed of the other robots that move."""


class Avoidance(ColiasEnv[AvoidanceOptions]):
    """
    ## Description

    Drive about a cluttered arena of 90 cm as far as possible, and touch neither its wall nor another robot. Some black
    robots stand in the arena and others drive about. Those that drive turn away on the spot from anything that comes
    within 4.5 cm of them, the observer included, as a Colias does by its infrared bumpers.

    ## Rewards

    - `ahead`: the distance driven along the heading, as a share of the distance at full speed.
    - `touch`: -10 when the hull touches anything.

    ## Starting State

    All robots stand at random places: 8 cm or more apart, and 12 cm or more from the observer.

    ## Episode End

    Terminated when the observer touches anything or is touched; truncated after 1800 steps (60 s, times `frame_skip`).

    ## Arguments

    `help(env.unwrapped.options)` lists them. What all envs share, such as spaces and `info`: `help(colias_sim.envs)`.

    ## Version History

    - v0: first release.
    """

    options_type: ClassVar[type[EnvOptions]] = AvoidanceOptions
    max_episode_steps = 1800
    summary = "wander about without touching anything"
    baselines = ("random-walk", "straight", "oracle-ways")
    collisions = COLLISIONS
    note = "An episode ends with its first collision. Intervals are those of Poisson rates."
    draws_paths = True

    def _others(self) -> Mapping[str, str]:
        moving = min(self.options.moving, self.options.robots)
        return {f"mover{i}": "colias_black" for i in range(1, moving + 1)} | parked_robots(self.options.robots - moving)

    def _begin(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        obstacles = self._sim.obstacles
        (observer,) = random_poses(rng, 1, obstacles=obstacles)
        others = random_poses(rng, self.options.robots, [observer], obstacles=obstacles)
        places = {OBSERVER: observer, **dict(zip(self._others(), others, strict=True))}
        speed = self.options.speed_cm_s / 100
        movers = [name for name in places if name.startswith("mover")]
        return places, {name: Wander(self._sim.robots[name], speed, rng, obstacles=obstacles) for name in movers}

    def _reward(self) -> dict[str, float]:
        return {"ahead": self.speed / self._fastest}
