"""Several worlds of one env, stepped in turns in one process: the half of a vector env that does the work."""

from __future__ import annotations

import importlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.vector import AutoresetMode

from colias_sim.envs.base import ColiasEnv
from colias_sim.offscreen import shared_contexts

ALIGNMENT = 64
Row = tuple[int, dict[str, Any]]
"""An env's number and one info of it."""


class Board:
    """What all processes see: actions in, observations, rewards and ends out, one row for each of ``count`` envs.

    ``observations`` is an array, or a dict of them; ``memory`` is zeros of `size` bytes.
    """

    def __init__(self, memory: Any, seen: spaces.Space[Any], acted: spaces.Space[Any], count: int) -> None:
        arrays = [
            np.ndarray((count, *shape), kind, memory, offset) for shape, kind, offset in _layout(seen, acted, count)
        ]
        self.actions, self.rewards, self.terminated, self.truncated, *observed = arrays
        self._parts: dict[str, npt.NDArray[Any]] = dict(zip(_parts(seen), observed, strict=True))
        self.observations: Any = self._parts if isinstance(seen, spaces.Dict) else observed[0]

    @staticmethod
    def size(seen: spaces.Space[Any], acted: spaces.Space[Any], count: int) -> int:
        """Bytes of memory that it takes."""
        shape, kind, offset = _layout(seen, acted, count)[-1]
        return offset + count * math.prod(shape) * int(np.dtype(kind).itemsize)

    def copied(self) -> Any:
        """The observations, the caller's own."""
        if isinstance(self.observations, np.ndarray):
            return self.observations.copy()
        return {name: part.copy() for name, part in self._parts.items()}

    def write(self, index: int, observation: Any) -> None:
        """Put down what one env observes."""
        if isinstance(self.observations, np.ndarray):
            self.observations[index] = observation
        else:
            for name, part in self._parts.items():
                part[index] = observation[name]


@dataclass(frozen=True, slots=True)
class Task:
    """What a host is to host: the envs ``first .. first + count - 1`` of a board of ``of``.

    ``entry_point`` is a class as ``module:name``, ``limit`` after how many steps an episode is truncated.
    """

    entry_point: str
    first: int
    count: int
    of: int
    limit: int | None
    mode: AutoresetMode

    @property
    def rows(self) -> slice:
        """Of the board."""
        return slice(self.first, self.first + self.count)

    @property
    def who(self) -> str:
        """The envs' numbers, for a person."""
        last = self.first + self.count - 1
        return f"env {last}" if self.count == 1 else f"envs {self.first}..{last}"


class Host:
    """The worlds of a `Task`, which share what OpenGL context they can.

    Raises whatever the env's class raises for ``options``; nothing is left open then.
    """

    def __init__(self, task: Task, options: Mapping[str, Any], board: Board) -> None:
        self._task, self._board = task, board
        self._elapsed, self._over = [0] * task.count, [False] * task.count
        self.envs: list[ColiasEnv[Any]] = []
        kind = env_class(task.entry_point)
        try:
            with shared_contexts():
                for _ in range(task.count):
                    self.envs.append(kind(**options))
        except BaseException:
            self.close()
            raise

    @property
    def metadata(self) -> dict[str, Any]:
        """The envs' own."""
        return self.envs[0].metadata

    def reset(self, seeds: Sequence[int | None], chosen: Sequence[bool]) -> list[Row]:
        """Reset the envs that are ``chosen``; a seed and a choice for each."""
        rows = []
        for k, env in enumerate(self.envs):
            if chosen[k]:
                rows.append((self._task.first + k, self._begin(k, env, seeds[k])))
                self._put(k, 0.0, False, False)
        return rows

    def step(self) -> list[Row]:
        """Let each env do what the board's actions say, or begin anew where that is due."""
        actions = self._board.actions[self._task.rows].copy()  # an env keeps what it is given
        rows: list[Row] = []
        for k, env in enumerate(self.envs):
            index = self._task.first + k
            if self._over[k] and self._task.mode is AutoresetMode.NEXT_STEP:
                rows.append((index, self._begin(k, env)))
                self._put(k, 0.0, False, False)
                continue
            observation, reward, terminated, truncated, info = env.step(actions[k])
            self._elapsed[k] += 1
            truncated = truncated or (self._task.limit is not None and self._elapsed[k] >= self._task.limit)
            self._board.write(index, observation)
            self._put(k, reward, terminated, truncated)
            if self._over[k] and self._task.mode is AutoresetMode.SAME_STEP:
                rows.append((index, {"final_obs": observation, "final_info": info}))
                info = self._begin(k, env)
                self._over[k] = False
            rows.append((index, info))
        return rows

    def render(self) -> list[Any]:
        """A picture of each, by the envs' ``render_mode``."""
        return [env.render() for env in self.envs]

    def call(self, name: str, arguments: tuple[Any, ...], keywords: Mapping[str, Any]) -> list[Any]:
        """What each env's method ``name`` gives; or its attribute of that name, if that is no function."""
        found = (env.get_wrapper_attr(name) for env in self.envs)
        return [each(*arguments, **keywords) if callable(each) else each for each in found]

    def assign(self, name: str, values: Sequence[Any]) -> list[None]:
        """Set an attribute of each env, a value for each."""
        for env, value in zip(self.envs, values, strict=True):
            env.set_wrapper_attr(name, value)
        return [None] * len(self.envs)

    @property
    def who(self) -> str:
        """The envs' numbers, for a person."""
        return self._task.who

    def close(self) -> None:
        """Close every env."""
        for env in self.envs:
            env.close()

    def _begin(self, k: int, env: ColiasEnv[Any], seed: int | None = None) -> dict[str, Any]:
        observation, info = env.reset(seed=seed)
        self._board.write(self._task.first + k, observation)
        self._elapsed[k] = 0
        return info

    def _put(self, k: int, reward: float, terminated: bool, truncated: bool) -> None:
        index, board = self._task.first + k, self._board
        board.rewards[index], board.terminated[index], board.truncated[index] = reward, terminated, truncated
        self._over[k] = terminated or truncated


def env_class(entry_point: str) -> type[ColiasEnv[Any]]:
    """The class that ``module:name`` names."""
    module, _, name = entry_point.partition(":")
    kind: type[ColiasEnv[Any]] = getattr(importlib.import_module(module), name)
    return kind


def _parts(seen: spaces.Space[Any]) -> dict[str, spaces.Space[Any]]:
    return dict(seen.spaces) if isinstance(seen, spaces.Dict) else {"": seen}


def _layout(seen: spaces.Space[Any], acted: spaces.Space[Any], count: int) -> list[tuple[tuple[int, ...], Any, int]]:
    """(shape of a row, type, offset) of every array, each on cache lines of its own."""
    scalars: list[tuple[tuple[int, ...], Any]] = [((), np.float64), ((), np.bool_), ((), np.bool_)]
    boxes = [(space.shape or (), space.dtype) for space in (acted, *_parts(seen).values())]
    placed, offset = [], 0
    for shape, kind in (boxes[0], *scalars, *boxes[1:]):
        placed.append((shape, kind, offset))
        offset += -(-count * math.prod(shape) * np.dtype(kind).itemsize // ALIGNMENT) * ALIGNMENT
    return placed
