"""The task of an env: what its subclass declares of the world, without Gymnasium."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from colias_sim.envs.scripted import Driver
from colias_sim.envs.world import World
from colias_sim.robot import Pose

TOUCH_COST = 10.0
"""What touching anything costs: the reward's term ``touch`` is minus this."""


class Task(World):
    """A world with a task: who is in it, how an episode begins, and what is rewarded. A subclass declares these."""

    _wheels: npt.NDArray[np.float32]  # the last command, (2,) in [-1, 1]

    @abstractmethod
    def _others(self) -> Mapping[str, str]:
        """The other robots, name -> variant, ``options.robots`` of them."""

    @abstractmethod
    def _begin(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        """Draw an episode: the pose of every robot, the observer included, and the drivers of the other robots."""

    @abstractmethod
    def _reward(self) -> dict[str, float]:
        """The reward's terms of the last frame, without ``touch``."""

    def _steer(self, wheels: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Convert the wheel speeds of an action to those to command, both (2,) in [-1, 1]; here they are the same."""
        return wheels

    def _measures(self) -> dict[str, Any]:
        """The entries of ``info`` that only this env has."""
        return {}

    def _effort(self) -> float:
        """The reward's term for motor effort: -0.05 times the mean square of the two wheels."""
        return -0.05 * float(np.mean(self._wheels**2))
