"""An env of one's own is one short file: options, entry, class. Here it is this file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from pydantic import Field
from pydantic.dataclasses import dataclass

from colias_sim import Pose
from colias_sim.envs.base import ColiasEnv
from colias_sim.envs.measures import COLLISIONS_PER_METRE, EnvEntry
from colias_sim.envs.options import STRICT, EnvOptions
from colias_sim.envs.scripted import Driver
from colias_sim.envs.world import OBSERVER, parked_robots

ENTRY = EnvEntry(
    f"{__name__}:Circle",
    max_episode_steps=30,
    summary="drive in circles",
    baselines=("straight",),
    measures=(COLLISIONS_PER_METRE,),
)


@dataclass(frozen=True, kw_only=True, config=STRICT)
class CircleOptions(EnvOptions):
    """The keyword arguments of `Circle`."""

    turn_rad_s: float = Field(default=1.0, ge=-5.0, le=5.0, description="wanted turn rate, rad/s")


class Circle(ColiasEnv[CircleOptions]):
    """Drive in circles."""

    options_type: ClassVar[type[EnvOptions]] = CircleOptions

    def _others(self) -> Mapping[str, str]:
        return parked_robots(self.options.robots)

    def _begin(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        places = {OBSERVER: Pose(0.0, 0.0, float(rng.uniform(-3.0, 3.0)))}
        return places | {name: Pose(0.2, 0.1 * k, 0.0) for k, name in enumerate(self._others())}, {}

    def _reward(self) -> dict[str, float]:
        return {"turn": -abs(self.turn_rate - self.options.turn_rad_s)}


def test_gymnasium_checks_it_and_makes_it_by_name() -> None:
    env = Circle(observation="state", turn_rad_s=0.5)
    check_env(env, skip_render_check=True)
    env.close()
    gym.register("tests/Circle-v0", entry_point=ENTRY.entry_point, max_episode_steps=ENTRY.max_episode_steps)
    try:
        envs = gym.make_vec("tests/Circle-v0", 2, observation="state", turn_rad_s=2.0)
        envs.reset(seed=0)
        _, rewards, *_, infos = envs.step(np.zeros((2, 2), np.float32))
        envs.close()
        assert rewards == pytest.approx([-2.0, -2.0], abs=0.05)
        np.testing.assert_array_equal(infos["reward_turn"], rewards)
    finally:
        del gym.registry["tests/Circle-v0"]
