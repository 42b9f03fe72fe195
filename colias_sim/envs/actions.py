"""What an agent may do, of one env or of many: two wheel speeds, or one of seven manoeuvres."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import error, spaces

Wheels = npt.NDArray[np.float32]

MANOEUVRES: Mapping[str, tuple[float, float]] = {
    "stop": (0.0, 0.0), "ahead": (0.3, 0.3), "bend left": (0.2, 0.3), "bend right": (0.3, 0.2),
    "turn left": (-0.2, 0.2), "turn right": (0.2, -0.2), "back": (-0.2, -0.2),
}  # fmt: skip
"""The discrete actions in order: wheel speeds (left, right) as shares of the maximum."""


def action_space(actions: str) -> spaces.Space[Any]:
    """The action space by the keyword ``actions``."""
    return spaces.Discrete(len(MANOEUVRES)) if actions == "manoeuvres" else spaces.Box(-1.0, 1.0, (2,), np.float32)


def wheels_of(space: spaces.Space[Any], action: Any) -> Wheels:
    """The wheel speeds of an action, (2,) in [-1, 1].

    Raises `gymnasium.error.InvalidAction` for one that is not in ``space``, naming it.
    """
    said = " ".join(repr(action).split())[:80]
    if isinstance(space, spaces.Discrete):
        try:
            legal = space.contains(action)
        except OverflowError:
            legal = False
        if not legal:
            raise error.InvalidAction(f"action {said}: expected a whole number from 0 to {len(MANOEUVRES) - 1}")
        return np.array(list(MANOEUVRES.values())[int(action)], np.float32)
    try:
        given = np.asarray(action)
    except ValueError:  # rows of different lengths
        given = np.empty(0)
    if given.shape != (2,) or given.dtype.kind not in "fiu" or not (np.abs(given) <= 1.0).all():  # nor is NaN
        raise error.InvalidAction(f"action {said}: expected two numbers in [-1, 1], for the wheels left and right")
    return given.astype(np.float32)


def batch_of(space: spaces.Space[Any], actions: Any, count: int) -> npt.NDArray[Any]:
    """An action for each of ``count`` envs, (count, *space.shape) of the space's type.

    Raises `gymnasium.error.InvalidAction` if any is not in ``space``, naming the env.
    """
    try:
        rows = len(actions)
    except TypeError:
        rows = -1
    if rows != count:
        raise error.InvalidAction(f"actions {actions!r}: expected {count}, one for each env")
    if isinstance(space, spaces.Box):
        try:
            batch = np.asarray(actions, np.float32)
            if batch.shape == (count, 2) and (np.abs(batch) <= 1.0).all():
                return batch
        except (TypeError, ValueError):
            pass  # one of them will tell
    for index, action in enumerate(actions):
        try:
            wheels_of(space, action)
        except error.InvalidAction as problem:
            raise error.InvalidAction(f"env {index}: {problem}") from None
    return np.array([np.asarray(action) for action in actions]).astype(space.dtype)
