"""The env that a policy is trained in: a task's neural observation, steered as `Steering` says."""

from __future__ import annotations

from typing import Any

import cv2
import gymnasium as gym
import numpy as np
from gymnasium import spaces
from threadpoolctl import threadpool_limits

import colias_sim  # noqa: F401  (registers the envs)
from experiments.bench.closed_loop.policy import About
from experiments.bench.closed_loop.steering import WHEELS, Steering, Vector


class Steered(gym.Wrapper[Vector, Vector, Vector, Vector]):
    """Actions add to the wheels' commands, and observations end with these; see `Steering`."""

    def __init__(self, env: gym.Env[Any, Any], steering: Steering) -> None:
        super().__init__(env)
        self._steering, self._command = steering, np.zeros(WHEELS, np.float32)
        inner = env.observation_space
        assert isinstance(inner, spaces.Box)
        ones = np.ones(WHEELS, np.float32)
        self.observation_space = spaces.Box(np.concatenate([inner.low, -ones]), np.concatenate([inner.high, ones]))
        self.action_space = spaces.Box(-1.0, 1.0, (WHEELS,), np.float32)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Vector, dict[str, Any]]:
        """Begin an episode, the wheels at rest."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._command = np.zeros(WHEELS, np.float32)
        return self._steering.sense(observation, self._command), info

    def step(self, action: Vector) -> tuple[Vector, float, bool, bool, dict[str, Any]]:
        """Move the wheels' commands by ``action``, and the robot by them."""
        self._command = self._steering.command(self._command, action)
        observation, reward, terminated, truncated, info = self.env.step(self._command)
        return self._steering.sense(observation, self._command), float(reward), terminated, truncated, info


def steered(about: About) -> Steered:
    """Return a new env of the kind that ``about`` names, with this process kept to one thread."""
    cv2.setNumThreads(1)
    threadpool_limits(1)
    return Steered(gym.make(about.env, observation="neural", model=about.model, **about.options), about.steering)
