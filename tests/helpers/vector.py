"""Vector envs as several tests make, play and compare them."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np

from colias_sim.envs.vector import ColiasVectorEnv

FIXATION, COUNT, LIMIT = "colias_sim/Fixation-v0", 3, 4


def make(count: int = COUNT, **options: Any) -> ColiasVectorEnv:
    env = gym.make_vec(FIXATION, num_envs=count, **options)
    assert isinstance(env, ColiasVectorEnv)
    return env


def actions(steps: int, count: int = COUNT) -> np.ndarray:
    return np.random.default_rng(0).uniform(-1, 1, (steps, count, 2)).astype(np.float32)


def assert_same(one: Any, other: Any) -> None:
    """Equal to the bit, in types and in the order of keys."""
    if isinstance(one, dict):
        assert list(one) == list(other)
        one, other = tuple(one.values()), tuple(other.values())
    if isinstance(one, tuple):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            assert_same(a, b)
    elif isinstance(one, np.ndarray) and one.dtype == object:
        assert_same(tuple(one), tuple(other))
    else:
        assert np.asarray(one).dtype == np.asarray(other).dtype
        np.testing.assert_array_equal(one, other)
