"""The observation spaces: the camera's picture, a vision model's response, both, or the state of the world."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from colias_sim.envs.models import ModelResponse
from colias_sim.envs.state import OTHER_ENTRIES, OWN_ENTRIES

MOST_SPIKES = 10.0
NEURAL = ("hs", "vs", "hs_spikes", "vs_spikes", "looming", "looming_spikes", "azimuth")
"""The entries of a neural observation, in order: fields of the model's answer to a frame."""
_LOWEST = np.array([-1.0, -1.0, -MOST_SPIKES, -MOST_SPIKES, 0.0, 0.0, -1.0], np.float32)
_HIGHEST = np.array([1.0, 1.0, MOST_SPIKES, MOST_SPIKES, 1.0, MOST_SPIKES, 1.0], np.float32)


def neural_observation(answers: Sequence[ModelResponse]) -> npt.NDArray[np.float32]:
    """Encode the model's answers to the frames of one step as the observation ``neural``.

    Parameters
    ----------
    answers
        One answer for each frame of the step, in order; at least one.

    Returns
    -------
    ndarray
        (7,) float32, the entries of `NEURAL`: potentials and azimuth of the last answer, and the sums of the spikes
        of all answers, clipped to the observation space.
    """
    last = answers[-1]
    values = (
        last.hs,
        last.vs,
        sum(a.hs_spikes for a in answers),
        sum(a.vs_spikes for a in answers),
        last.looming,
        sum(a.looming_spikes for a in answers),
        last.azimuth,
    )
    return np.clip(np.array(values, np.float32), _LOWEST, _HIGHEST)


def observation_space(observation: str, shape: tuple[int, int], robots: int) -> spaces.Space[Any]:
    """Make the observation space of an env.

    Parameters
    ----------
    observation
        The env's argument of that name: ``pixels``, ``neural``, ``both`` or ``state``.
    shape
        Rows and columns of the camera.
    robots
        The number of other robots.

    Returns
    -------
    gymnasium.spaces.Space
        ``Box`` (R, C, 1) uint8, ``Box`` (7,) float32, ``Dict`` of these two, or ``Box`` (7 + 5 robots,) float32.
    """
    pixels = spaces.Box(0, 255, (*shape, 1), np.uint8)
    nerves = spaces.Box(_LOWEST, _HIGHEST, dtype=np.float32)
    if observation == "both":
        return spaces.Dict({"pixels": pixels, "neural": nerves})
    if observation == "state":
        return spaces.Box(-1.0, 1.0, (OWN_ENTRIES + OTHER_ENTRIES * robots,), np.float32)
    return pixels if observation == "pixels" else nerves
