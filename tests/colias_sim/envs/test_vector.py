"""Gymnasium's own vector envs serve: each of their envs plays the episodes of a single one."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from tests.helpers.envs import FIXATION, fingerprint

COUNT, LIMIT = 2, 3
MODES = {"sync": {}, "async": {"context": "spawn"}}


@pytest.mark.parametrize("mode", MODES)
def test_a_vector_env_plays_the_episodes_of_single_ones(mode: str) -> None:
    """Over a time limit, after which each env goes on by itself."""
    options: dict[str, Any] = {"observation": "both", "max_episode_steps": LIMIT}
    given = {**MODES[mode], "autoreset_mode": "SameStep"}
    many = gym.make_vec(FIXATION, COUNT, mode, vector_kwargs=given, **options)
    actions = np.random.default_rng(0).uniform(-0.3, 0.3, (2 * LIMIT, COUNT, 2)).astype(np.float32)
    seen = [many.reset(seed=7)[0], *(many.step(action)[0] for action in actions)]
    many.close()
    for k in range(COUNT):
        one = gym.make(FIXATION, **options)
        expected = [one.reset(seed=7 + k)[0]]
        for action in actions[:, k]:
            observation, _, terminated, truncated, _ = one.step(action)
            expected.append(one.reset()[0] if terminated or truncated else observation)
        one.close()
        assert fingerprint([{name: batch[k] for name, batch in each.items()} for each in seen]) == fingerprint(expected)
