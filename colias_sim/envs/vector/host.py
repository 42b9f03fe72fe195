"""The envs of one process of a vector env, stepped in turns."""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gymnasium.vector import AutoresetMode

from colias_sim.envs.base import ColiasEnv
from colias_sim.envs.vector.buffers import Buffers
from colias_sim.envs.vector.info import InfoRow
from colias_sim.offscreen import shared_contexts


@dataclass(frozen=True, slots=True)
class Task:
    """The envs that one process is to host.

    Parameters
    ----------
    entry_point
        The env's class, as ``module:name``.
    first, count
        The number of the first env, and how many there are.
    of
        The number of envs in all processes.
    limit
        After how many steps an episode is truncated; ``None`` for no limit.
    mode
        When an env that has ended is reset.
    """

    entry_point: str
    first: int
    count: int
    of: int
    limit: int | None
    mode: AutoresetMode

    @property
    def rows(self) -> slice:
        """The rows of the buffers that belong to these envs."""
        return slice(self.first, self.first + self.count)

    @property
    def who(self) -> str:
        """The numbers of the envs, for messages."""
        last = self.first + self.count - 1
        return f"env {last}" if self.count == 1 else f"envs {self.first}..{last}"


class Host:
    """The envs of a `Task`. They share an OpenGL context where they can.

    Parameters
    ----------
    task
        Which envs.
    options
        The keyword arguments of each env.
    buffers
        Where actions are read, and results written.

    Raises
    ------
    Exception
        Whatever the env's class raises for ``options``. No env is left open then.
    """

    def __init__(self, task: Task, options: Mapping[str, Any], buffers: Buffers) -> None:
        self._task, self._buffers = task, buffers
        self._elapsed, self._over = [0] * task.count, [False] * task.count
        self.envs: list[ColiasEnv[Any]] = []
        make: Any = env_class(task.entry_point)
        try:
            with shared_contexts():
                for _ in range(task.count):
                    self.envs.append(make(**options))
        except BaseException:
            self.close()
            raise

    @property
    def metadata(self) -> dict[str, Any]:
        """The metadata of the envs, equal in all."""
        return self.envs[0].metadata

    @property
    def who(self) -> str:
        """The numbers of the envs, for messages."""
        return self._task.who

    def reset(
        self, seeds: Sequence[int | None], chosen: Sequence[bool], options: Mapping[str, Any]
    ) -> list[InfoRow]:  # fmt: skip
        """Reset the chosen envs.

        Parameters
        ----------
        seeds, chosen
            A seed and a choice for each env.
        options
            Of the reset of each of them.

        Returns
        -------
        list of InfoRow
            The info of each env that was reset; the observations are in the buffers.
        """
        rows = []
        for k, env in enumerate(self.envs):
            if chosen[k]:
                rows.append((self._task.first + k, self._begin(k, env, seeds[k], options)))
                self._write(k, 0.0, False, False)
        return rows

    def step(self) -> list[InfoRow]:
        """Step each env with its action of the buffers, or reset it where the autoreset mode says so.

        Returns
        -------
        list of InfoRow
            The info of each env; with `AutoresetMode.SAME_STEP`, before it the last observation and info of an
            episode that ended. All else is in the buffers.
        """
        actions = self._buffers.actions[self._task.rows].copy()  # a copy, as an env keeps its last action
        rows: list[InfoRow] = []
        for k, env in enumerate(self.envs):
            index = self._task.first + k
            if self._over[k] and self._task.mode is AutoresetMode.NEXT_STEP:
                rows.append((index, self._begin(k, env)))
                self._write(k, 0.0, False, False)
                continue
            observation, reward, terminated, truncated, info = env.step(actions[k])
            self._elapsed[k] += 1
            truncated = truncated or (self._task.limit is not None and self._elapsed[k] >= self._task.limit)
            self._buffers.write_observation(index, observation)
            self._write(k, reward, terminated, truncated)
            if self._over[k] and self._task.mode is AutoresetMode.SAME_STEP:
                rows.append((index, {"final_obs": observation, "final_info": info}))
                info = self._begin(k, env)
                self._over[k] = False
            rows.append((index, info))
        return rows

    def render(self) -> list[Any]:
        """Return the return value of each env's ``render()``."""
        return [env.render() for env in self.envs]

    def call(self, name: str, arguments: tuple[Any, ...], keywords: Mapping[str, Any]) -> list[Any]:
        """Call or read each env's method ``name``, or its attribute of that name if that is not callable."""
        attributes = (env.get_wrapper_attr(name) for env in self.envs)
        return [attribute(*arguments, **keywords) if callable(attribute) else attribute for attribute in attributes]

    def assign(self, name: str, values: Sequence[Any]) -> list[None]:
        """Set an attribute of each env, to one value each."""
        for env, value in zip(self.envs, values, strict=True):
            env.set_wrapper_attr(name, value)
        return [None] * len(self.envs)

    def close(self) -> None:
        """Close every env."""
        for env in self.envs:
            env.close()

    def _begin(
        self, k: int, env: ColiasEnv[Any], seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> dict[str, Any]:
        observation, info = env.reset(seed=seed, options=dict(options or {}))
        self._buffers.write_observation(self._task.first + k, observation)
        self._elapsed[k] = 0
        return info

    def _write(self, k: int, reward: float, terminated: bool, truncated: bool) -> None:
        index, buffers = self._task.first + k, self._buffers
        buffers.rewards[index], buffers.terminated[index], buffers.truncated[index] = reward, terminated, truncated
        self._over[k] = terminated or truncated


def env_class(entry_point: str) -> type[ColiasEnv[Any]]:
    """Import the class that ``module:name`` names."""
    module, _, name = entry_point.partition(":")
    kind: type[ColiasEnv[Any]] = getattr(importlib.import_module(module), name)
    return kind
