"""Observations and actions of the envs: their spaces, the neural observation, and the manoeuvres."""

from __future__ import annotations

import importlib
from collections import namedtuple
from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt
from gymnasium import error, spaces

from colias_sim.envs.state import OTHER_ENTRIES, OWN_ENTRIES

WIRING = "experiments.wiring"
"""The module that builds models from names. `colias_sim` contains no model, so it imports this one on demand."""

MANOEUVRES: Mapping[str, tuple[float, float]] = {
    "stop": (0.0, 0.0), "ahead": (0.3, 0.3), "bend left": (0.2, 0.3), "bend right": (0.3, 0.2),
    "turn left": (-0.2, 0.2), "turn right": (0.2, -0.2), "back": (-0.2, -0.2),
}  # fmt: skip
"""The discrete actions, in order: name -> wheel speeds (left, right), as shares of the maximum."""

MOST_SPIKES = 10.0
NEURAL = ("hs", "vs", "hs_spikes", "vs_spikes", "looming", "looming_spikes", "azimuth")
"""The entries of a neural observation, in order: fields of the model's response to a frame."""
_LOWEST = np.array([-1.0, -1.0, -MOST_SPIKES, -MOST_SPIKES, 0.0, 0.0, -1.0], np.float32)
_HIGHEST = np.array([1.0, 1.0, MOST_SPIKES, MOST_SPIKES, 1.0, MOST_SPIKES, 1.0], np.float32)


class Response(Protocol):
    """What a neural observation reads of a model's response to a frame: potentials, spikes and an azimuth."""

    @property
    def hs(self) -> float:
        """Membrane potential of HS, -1 to 1."""
        ...

    @property
    def vs(self) -> float:
        """Membrane potential of VS, -1 to 1."""
        ...

    @property
    def hs_spikes(self) -> int:
        """Spikes of HS, signed."""
        ...

    @property
    def vs_spikes(self) -> int:
        """Spikes of VS, signed."""
        ...

    @property
    def looming(self) -> float:
        """Potential of a looming detector, 0 to 1."""
        ...

    @property
    def looming_spikes(self) -> int:
        """Its spikes, 0 or more."""
        ...

    @property
    def azimuth(self) -> float:
        """Where the model sees the stimulus, -1 to 1."""
        ...


PastResponse = namedtuple("PastResponse", "hs vs hs_spikes vs_spikes looming looming_spikes azimuth")
"""What an env's state keeps of a response: the entries of `NEURAL`."""


class Model(Protocol):
    """The interface of a vision model in an env. The models of ``dsnn`` satisfy it."""

    def step(self, frame: npt.NDArray[np.uint8] | npt.NDArray[np.void]) -> Response:
        """Respond to the next frame, (R, C) uint8, or to the events since the last step."""
        ...

    def reset(self) -> None:
        """Return to the state before the first frame."""
        ...

    def get_state(self) -> bytes:
        """Save what it keeps between two frames; ``ValueError`` if the model has no such method."""
        ...

    def set_state(self, state: bytes) -> None:
        """Restore what `get_state` saved; ``ValueError``, and nothing done, if that is not its own."""
        ...


def build_model(model: Any, shape: tuple[int, int]) -> Model:
    """Build the vision model of the neural observations, with a check of its response to every frame.

    Parameters
    ----------
    model
        The name of a registered model, the path of a .py file that declares ``MODEL``, or such an entry. A factory
        works too: it is called with ``shape``, the tuple (rows, columns), as its only argument.
    shape
        Rows and columns of the frames.

    Returns
    -------
    Model
        A new model, before its first frame.

    Raises
    ------
    ValueError
        The name is unknown, the file declares no model, or ``model`` has another type.
    """
    built: Model = importlib.import_module(WIRING).build(model, shape)
    return built


def senses_events(model: Model | None) -> bool:
    """Say whether a model receives the events of an event camera in place of a frame."""
    return getattr(model, "senses", "") == "events"


def neural_observation(responses: Sequence[Response]) -> npt.NDArray[np.float32]:
    """Encode the model's responses to the frames of one step as the observation ``neural``.

    Parameters
    ----------
    responses
        One response for each frame of the step, in order; at least one.

    Returns
    -------
    ndarray
        (7,) float32, the entries of `NEURAL`: potentials and azimuth of the last response, and the summed spikes of all
        responses, clipped to the observation space.
    """
    last = responses[-1]
    counts = ((one.hs_spikes, one.vs_spikes, one.looming_spikes) for one in responses)
    hs_spikes, vs_spikes, looming_spikes = map(sum, zip(*counts, strict=True))
    values = (last.hs, last.vs, hs_spikes, vs_spikes, last.looming, looming_spikes, last.azimuth)
    return np.minimum(np.maximum(np.array(values, np.float32), _LOWEST), _HIGHEST)


def observation_space(observation: str, shape: tuple[int, int], robots: int) -> spaces.Space[Any]:
    """Make the observation space of an env.

    Parameters
    ----------
    observation
        The env's argument of that name: ``pixels``, ``neural``, ``both``, ``state`` or ``events``.
    shape
        Rows and columns of the camera.
    robots
        The number of other robots.

    Returns
    -------
    gymnasium.spaces.Space
        ``Box`` (R, C, 1) uint8, ``Box`` (7,) float32, ``Dict`` of these two, ``Box`` (7 + 5 robots,) float32,
        or ``Box`` (2, R, C) uint8.
    """
    pixels = spaces.Box(0, 255, (*shape, 1), np.uint8)
    nerves = spaces.Box(_LOWEST, _HIGHEST, dtype=np.float32)
    if observation == "both":
        return spaces.Dict({"pixels": pixels, "neural": nerves})
    if observation == "state":
        return spaces.Box(-1.0, 1.0, (OWN_ENTRIES + OTHER_ENTRIES * robots,), np.float32)
    if observation == "events":
        return spaces.Box(0, 255, (2, *shape), np.uint8)
    return pixels if observation == "pixels" else nerves


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


def wheels_of(space: spaces.Space[Any], action: Any) -> npt.NDArray[np.float32]:
    """Convert an action to wheel speeds.

    Parameters
    ----------
    space
        From `action_space`.
    action
        Two wheel speeds, or the number of a manoeuvre.

    Returns
    -------
    ndarray
        (2,) float32: left and right, as shares of the maximum, cut to [-1, 1].

    Raises
    ------
    gymnasium.error.InvalidAction
        The action is not a pair of numbers, a number is NaN, or the manoeuvre is unknown.
    """
    if isinstance(space, spaces.Discrete):
        if not space.contains(action):
            raise error.InvalidAction(f"an action must be from 0 to {space.n - 1}, got {action!r}")
        return np.array(list(MANOEUVRES.values())[int(action)], np.float32)
    wheels = np.asarray(action, np.float32)
    if wheels.shape != (2,) or np.isnan(wheels).any():
        raise error.InvalidAction(f"an action must be two numbers, for the wheels left and right, got {action!r}")
    return np.minimum(np.maximum(wheels, np.float32(-1.0)), np.float32(1.0))
