"""Avoidance: wander about without touching anything."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from colias_sim.envs.base import OBSERVER, ColiasEnv, parked
from colias_sim.envs.describing import documented
from colias_sim.envs.drivers import Driver, Wander, scatter
from colias_sim.envs.options import MOST_ROBOTS, STRICT, Arena, EnvOptions
from colias_sim.robot import Pose


@dataclass(frozen=True, config=STRICT)
class AvoidanceOptions(EnvOptions):
    """The arguments of `Avoidance`."""

    arena: Arena = Field(default="leaves", description="an arena of scenes")
    robots: int = Field(default=10, ge=1, le=MOST_ROBOTS, description="other robots, moving and parked")
    moving: int = Field(default=5, ge=0, le=MOST_ROBOTS, description="how many of them move; at most all")
    speed_cm_s: float = Field(default=8.0, ge=0.0, le=20.0, description="of those that move")


@documented
class Avoidance(ColiasEnv[AvoidanceOptions]):
    """
    ## Description

    Wander about a cluttered arena of 90 cm, as far as possible, and touch neither its wall nor another robot. Black
    robots stand about and drive about in it; those that drive turn away on the spot from what comes within 4.5 cm of
    them, the observer too, as a Colias's infrared bumpers would let them.

    ## Action Space

    <ACTIONS>

    ## Observation Space

    <OBSERVATIONS>

    ## Rewards

    - `ahead`: the distance driven along the heading, as a share of what full speed would have covered.
    <REWARDS>

    ## Info

    <INFO>

    ## Starting State

    Everybody at random, 8 cm or more apart, the observer 12 cm or more from all.

    <RANDOM>

    ## Episode End

    Terminated when the observer touches anything, or is touched; truncated after 1800 steps (60 s, times `frame_skip`).

    ## Arguments

    <ARGUMENTS>

    ## Version History

    - v0: first release.
    """

    options_type: ClassVar[type[EnvOptions]] = AvoidanceOptions

    def _others(self) -> Mapping[str, str]:
        moving = min(self.options.moving, self.options.robots)
        return {f"mover{i}": "colias_black" for i in range(1, moving + 1)} | parked(self.options.robots - moving)

    def _begin(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        (observer,) = scatter(rng, 1)
        others = scatter(rng, self.options.robots, [observer])
        places = {OBSERVER: observer, **dict(zip(self._others(), others, strict=True))}
        speed = self.options.speed_cm_s / 100
        movers = [name for name in places if name.startswith("mover")]
        return places, {name: Wander(self._sim.robots[name], speed, rng) for name in movers}

    def _reward(self) -> dict[str, float]:
        return {"ahead": self.speed / self._fastest}
