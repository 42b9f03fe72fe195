"""The shared memory of a vector env: actions in; observations, rewards and ends of episodes out."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

ALIGNMENT = 64
"""Bytes of a cache line. Every array begins on a line of its own."""


class Buffers:
    """Arrays over one block of memory that all processes of a vector env see, with one row for each env.

    The attributes are ``actions`` (count, ...), ``rewards`` (count,) float64, ``terminated`` and ``truncated``
    (count,) bool, and ``observations``: an array (count, ...), or a dict of these.

    Parameters
    ----------
    memory
        A writable buffer of `size` bytes, all zero.
    observation_space, action_space
        The spaces of one env.
    count
        The number of envs.
    """

    def __init__(
        self, memory: Any, observation_space: spaces.Space[Any], action_space: spaces.Space[Any], count: int
    ) -> None:
        arrays = [
            np.ndarray((count, *shape), kind, memory, offset)
            for shape, kind, offset in _layout(observation_space, action_space, count)
        ]
        self.actions, self.rewards, self.terminated, self.truncated, *observed = arrays
        self._parts: dict[str, npt.NDArray[Any]] = dict(zip(_parts(observation_space), observed, strict=True))
        self.observations: Any = self._parts if isinstance(observation_space, spaces.Dict) else observed[0]

    @staticmethod
    def size(observation_space: spaces.Space[Any], action_space: spaces.Space[Any], count: int) -> int:
        """Return the size of the memory in bytes, for the same arguments as the constructor's."""
        shape, kind, offset = _layout(observation_space, action_space, count)[-1]
        return offset + count * math.prod(shape) * int(np.dtype(kind).itemsize)

    def copy_observations(self) -> Any:
        """Copy the observations: an array (count, ...), or a dict of these."""
        if isinstance(self.observations, np.ndarray):
            return self.observations.copy()
        return {name: part.copy() for name, part in self._parts.items()}

    def write_observation(self, index: int, observation: Any) -> None:
        """Write the observation of env ``index``."""
        if isinstance(self.observations, np.ndarray):
            self.observations[index] = observation
        else:
            for name, part in self._parts.items():
                part[index] = observation[name]


def _parts(space: spaces.Space[Any]) -> dict[str, spaces.Space[Any]]:
    return dict(space.spaces) if isinstance(space, spaces.Dict) else {"": space}


def _layout(
    observation_space: spaces.Space[Any], action_space: spaces.Space[Any], count: int
) -> list[tuple[tuple[int, ...], Any, int]]:
    """(shape of a row, type, offset in bytes) of every array."""
    scalars: list[tuple[tuple[int, ...], Any]] = [((), np.float64), ((), np.bool_), ((), np.bool_)]
    boxes = [(space.shape or (), space.dtype) for space in (action_space, *_parts(observation_space).values())]
    placed, offset = [], 0
    for shape, kind in (boxes[0], *scalars, *boxes[1:]):
        placed.append((shape, kind, offset))
        offset += -(-count * math.prod(shape) * np.dtype(kind).itemsize // ALIGNMENT) * ALIGNMENT
    return placed
