"""What the tests of the envs share: making envs, playing episodes, comparing them to the last bit."""

import json
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from colias_sim.envs import ENVS
from colias_sim.envs.base import ColiasEnv

NAMES = sorted(ENVS)
FIXATION = "colias_sim/Fixation-v0"
SENSES = ("pixels", "neural", "both", "state", "events")
every_env = pytest.mark.parametrize("name", NAMES)


def end_after(steps: int, patch: pytest.MonkeyPatch) -> None:
    """Make the episodes of every env end after so many steps."""
    for name, env in ENVS.items():
        patch.setattr(env, "max_episode_steps", steps)
        patch.setattr(gym.registry[name], "max_episode_steps", steps)


OPEN: list[ColiasEnv[Any]] = []
"""Envs to be closed when the test ends."""


def bare(name: str, **options: Any) -> ColiasEnv[Any]:
    """The env without Gymnasium's wrappers: no time limit, no checks but its own."""
    env = gym.make(name, **options).unwrapped
    assert isinstance(env, ColiasEnv)
    OPEN.append(env)
    return env


def episode(env: gym.Env[Any, Any], seed: int | None = None, steps: int = 25) -> list[Any]:
    """Everything an agent is told in an episode of random actions (of the seed), up to its end."""
    rng, told = np.random.default_rng(seed), [env.reset(seed=seed)]
    discrete = isinstance(env.action_space, gym.spaces.Discrete)
    for _ in range(steps):
        told.append(env.step(int(rng.integers(7)) if discrete else rng.uniform(-1.0, 1.0, 2).astype(np.float32)))
        if told[-1][2] or told[-1][3]:
            break
    return told


def fingerprint(told: list[Any]) -> str:
    """All of it to the last bit."""

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: plain(value[key]) for key in sorted(value)}
        if isinstance(value, tuple | list):
            return [plain(item) for item in value]
        return value.tobytes().hex() if isinstance(value, np.ndarray) else repr(value)

    return json.dumps(plain(told))
