"""A Gymnasium vector env of one world as stable-baselines3's own kind of vector env."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from stable_baselines3.common.vec_env import VecEnv


class SB3Rows(VecEnv):  # type: ignore[misc]  # where stable-baselines3 is not installed
    """A vector env for stable-baselines3.

    Parameters
    ----------
    rows
        The vector env, whose autoreset is ``SAME_STEP``.
    """

    def __init__(self, rows: gym.vector.VectorEnv[Any, Any, Any]) -> None:
        self.rows, self.render_mode = rows, rows.render_mode
        self._seed: int | None = None
        self._actions: Any = None
        super().__init__(rows.num_envs, rows.single_observation_space, rows.single_action_space)

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Seed the next reset."""
        self._seed = seed
        return [seed] * int(self.num_envs)

    def reset(self) -> Any:
        """Begin an episode of all."""
        seen, _ = self.rows.reset(seed=self._seed)
        self._seed = None
        return seen

    def step_async(self, actions: Any) -> None:
        """Take the actions of the next step."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        """Step, and return observations, rewards, dones and infos."""
        seen, rewards, terminated, truncated, info = self.rows.step(self._actions)
        done, infos = terminated | truncated, []
        for k in range(self.num_envs):
            own = {key: value[k] for key, value in info.items() if not key.startswith("final_")}
            if done[k]:
                own["terminal_observation"] = info["final_obs"][k]
                own["TimeLimit.truncated"] = bool(truncated[k])
            infos.append(own)
        return seen, rewards.astype(np.float32), done, infos

    def close(self) -> None:
        """Free every OpenGL context."""
        self.rows.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of the one world, once for each row."""
        return [getattr(self.rows, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute of the one world."""
        setattr(self.rows, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: object) -> list[Any]:
        """Call a method of the one world, once."""
        return [getattr(self.rows, method_name)(*args, **kwargs)] * len([*self._get_indices(indices)])

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """Say that no row is wrapped."""
        return [False for _ in self._get_indices(indices)]
