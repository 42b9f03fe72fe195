"""The action spaces, and the checks of actions: two wheel speeds, or one of seven manoeuvres."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import error, spaces

from colias_sim.envs.flags import is_flag, one_line

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
    if isinstance(space, spaces.Discrete):
        try:
            legal = space.contains(action) and not is_flag(action)
        except OverflowError:
            legal = False
        if not legal:
            raise error.InvalidAction(
                f"action {one_line(action)}: expected a whole number from 0 to {len(MANOEUVRES) - 1}"
            )
        return np.array(list(MANOEUVRES.values())[int(action)], np.float32)
    try:
        given = np.asarray(action)
    except ValueError:  # rows of different lengths
        given = np.empty(0)
    flags = isinstance(action, list | tuple) and any(map(is_flag, action))  # beside a number, NumPy counts them as 1
    if given.shape != (2,) or flags or not _legal(given):
        problem = f"action {one_line(action)}"
        raise error.InvalidAction(f"{problem}: expected two numbers in [-1, 1], for the wheels left and right")
    return given.astype(np.float32)


def _legal(wheels: npt.NDArray[Any]) -> bool:
    """Tell whether all are numbers in [-1, 1]."""
    return wheels.dtype.kind in "fiu" and bool(((wheels >= -1) & (wheels <= 1)).all())
