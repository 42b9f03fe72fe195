"""The task of an env: what its subclass declares of the world, without Gymnasium."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from colias_sim.envs.scripted import Driver
from colias_sim.envs.world import World
from colias_sim.pose import Pose

TOUCH_COST = 10.0
"""Cost of touching anything: the reward's term ``touch`` is minus this."""


class Task(World):
    """A world with a task: who is in it, how an episode begins, and what is rewarded. A subclass declares these."""

    _wheels: npt.NDArray[np.float32]  # the last command, (2,) in [-1, 1]

    @abstractmethod
    def _others(self) -> Mapping[str, str]:
        """List the other robots. It is called once, when the env is made.

        Returns
        -------
        mapping of str to str
            Name -> variant, as `scenes.ROBOTS` lists them; ``options.robots`` of them.
        """

    @abstractmethod
    def _begin(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        """Draw an episode.

        Parameters
        ----------
        rng
            Generator of the episode's world.

        Returns
        -------
        poses : mapping of str to Pose
            The start of every robot by name, that of ``observer`` too.
        drivers : mapping of str to Driver
            What drives each of the other robots that moves: its ``wheels(dt, poses)`` gives the wheel speeds for a
            control interval of ``dt`` seconds.
        """

    @abstractmethod
    def _reward(self) -> dict[str, float]:
        """Compute the reward's terms of the last frame, without ``touch``.

        Returns
        -------
        dict of str to float
            Name of the term -> its value; the reward is their sum.
        """

    def _steer(self, wheels: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Convert the wheel speeds of an action to those to command; here they are the same.

        Parameters
        ----------
        wheels
            (2,): left and right, in [-1, 1], as shares of the maximum.

        Returns
        -------
        ndarray of float32
            (2,), likewise.
        """
        return wheels

    def _measures(self) -> dict[str, Any]:
        """Compute the entries of ``info`` that only this env has.

        Returns
        -------
        dict
            Name -> value; names end in their units.
        """
        return {}

    def _effort(self) -> float:
        """Return the reward's term for motor effort: -0.05 times the mean square of the two wheels."""
        return -0.05 * float(np.mean(self._wheels**2))
