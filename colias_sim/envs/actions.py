"""The action spaces, and the checks of actions: two wheel speeds, or one of seven manoeuvres."""

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
"""The discrete actions, in order: name -> wheel speeds (left, right), as shares of the maximum."""


def action_space(actions: str) -> spaces.Space[Any]:
    """Make the action space of an env.

    Parameters
    ----------
    actions
        The env's argument of that name: ``wheels`` or ``manoeuvres``.

    Returns
    -------
    gymnasium.spaces.Space
        ``Box`` (2,) float32 in [-1, 1], or ``Discrete`` over `MANOEUVRES`.
    """
    return spaces.Discrete(len(MANOEUVRES)) if actions == "manoeuvres" else spaces.Box(-1.0, 1.0, (2,), np.float32)


def wheels_of(space: spaces.Space[Any], action: Any) -> Wheels:
    """Convert an action to wheel speeds.

    Parameters
    ----------
    space
        The action space.
    action
        Two numbers, or the number of a manoeuvre.

    Returns
    -------
    ndarray
        (2,) float32: left and right, as shares of the maximum, in [-1, 1].

    Raises
    ------
    gymnasium.error.InvalidAction
        If the action is not in ``space``. The message names it.
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
    if given.shape != (2,) or given.dtype.kind not in "fiu" or not (np.abs(given) <= 1.0).all():  # true of NaN too
        raise error.InvalidAction(f"action {said}: expected two numbers in [-1, 1], for the wheels left and right")
    return given.astype(np.float32)


def batch_of(space: spaces.Space[Any], actions: Any, count: int) -> npt.NDArray[Any]:
    """Convert one action for each of several envs to an array.

    Parameters
    ----------
    space
        The action space of one env.
    actions
        A sequence of ``count`` actions.
    count
        The number of envs.

    Returns
    -------
    ndarray
        (count, *space.shape), of the type of ``space``.

    Raises
    ------
    gymnasium.error.InvalidAction
        If there are not ``count`` actions, or one is not in ``space``. The message names the env.
    """
    try:
        rows = len(actions)
    except TypeError:
        rows = -1
    if rows != count:
        said = " ".join(repr(actions).split())[:80]
        raise error.InvalidAction(f"actions {said}: expected {count}, one for each env")
    if isinstance(space, spaces.Box):
        try:
            batch = np.asarray(actions, np.float32)
            if batch.shape == (count, 2) and (np.abs(batch) <= 1.0).all():
                return batch
        except (TypeError, ValueError):
            pass  # the loop below finds the one that is wrong
    for index, action in enumerate(actions):
        try:
            wheels_of(space, action)
        except error.InvalidAction as problem:
            raise error.InvalidAction(f"env {index}: {problem}") from None
    return np.array([np.asarray(action) for action in actions]).astype(space.dtype)
