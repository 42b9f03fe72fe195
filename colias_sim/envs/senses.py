"""What an agent may observe: the camera's picture, a vision model's answer, both, or the state that a robot lacks."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from colias_sim.envs.options import Answer, Model
from scenes import ARENA_RADIUS_CM

Vector = npt.NDArray[np.float32]

WIRING = "experiments.wiring"
"""Where names of models are known: this package knows none, so the room that knows both is asked when one is wanted."""

MOST_SPIKES = 10.0
NEURAL = ("hs", "vs", "hs_spikes", "vs_spikes", "looming", "looming_spikes", "azimuth")
"""The entries of a neural observation, in order: fields of ``dsnn.Response``."""
_LOWEST = np.array([-1.0, -1.0, -MOST_SPIKES, -MOST_SPIKES, 0.0, 0.0, -1.0], np.float32)
_HIGHEST = np.array([1.0, 1.0, MOST_SPIKES, MOST_SPIKES, 1.0, MOST_SPIKES, 1.0], np.float32)

SPEED, TURN, LENGTH = 0.35, 5.0, 2 * ARENA_RADIUS_CM / 100
"""What a state's speeds (m/s), turn rates (rad/s) and distances (m) are divided by."""
OWN_ENTRIES, OTHER_ENTRIES = 7, 5


@dataclass(frozen=True, slots=True)
class Other:
    """Another robot as the observer's own frame has it: metres, radians left positive, m/s ahead and to the left."""

    distance: float
    bearing: float
    ahead: float
    left: float


@dataclass(frozen=True, slots=True)
class State:
    """What a robot without any sense of it would have to guess: the privileged observation.

    ``speed`` m/s ahead; ``turn_rate`` and ``drift`` (the rate at which drum or push would turn the view) rad/s, left
    positive; ``slip`` the turn rate against the wall; ``wall_distance`` from the hull to the nearest wall in metres
    and ``wall_bearing`` its direction off the heading in rad, left positive. ``others``: the target first, then the
    nearest.
    """

    speed: float
    turn_rate: float
    slip: float
    drift: float
    wall_distance: float
    wall_bearing: float
    others: tuple[Other, ...]

    def vector(self) -> Vector:
        """The observation ``state``: (7 + 5 N,) float32 in [-1, 1], angles as sine and cosine."""
        own = (
            self.speed / SPEED, self.turn_rate / TURN, self.slip / TURN, self.drift / TURN,
            self.wall_distance / LENGTH, np.sin(self.wall_bearing), np.cos(self.wall_bearing),
        )  # fmt: skip
        others = (
            (o.distance / LENGTH, np.sin(o.bearing), np.cos(o.bearing), o.ahead / SPEED, o.left / SPEED)
            for o in self.others
        )
        values = [*own, *(value for other in others for value in other)]
        return np.clip(np.array(values, np.float32), -1.0, 1.0)

    @classmethod
    def read(cls, vector: Sequence[float] | Vector) -> State:
        """The state that gave ``vector``, as far as nothing was clipped."""
        speed, turn, slip, drift, wall, sine, cosine, *rest = (float(value) for value in vector)
        others = tuple(
            Other(d * LENGTH, float(np.arctan2(s, c)), ahead * SPEED, left * SPEED)
            for d, s, c, ahead, left in zip(*(rest[i::OTHER_ENTRIES] for i in range(OTHER_ENTRIES)), strict=True)
        )
        return cls(
            speed * SPEED,
            turn * TURN,
            slip * TURN,
            drift * TURN,
            wall * LENGTH,
            float(np.arctan2(sine, cosine)),
            others,
        )


def neural(answers: Sequence[Answer]) -> Vector:
    """The observation ``neural``: the last answer's potentials, the spikes of all; (7,) float32."""
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


def space(observation: str, shape: tuple[int, int], robots: int) -> spaces.Space[Any]:
    """The observation space by its keyword, for a camera of ``shape`` (R, C) and a number of other robots."""
    pixels = spaces.Box(0, 255, (*shape, 1), np.uint8)
    nerves = spaces.Box(_LOWEST, _HIGHEST, dtype=np.float32)
    if observation == "both":
        return spaces.Dict({"pixels": pixels, "neural": nerves})
    if observation == "state":
        return spaces.Box(-1.0, 1.0, (OWN_ENTRIES + OTHER_ENTRIES * robots,), np.float32)
    return pixels if observation == "pixels" else nerves


def build_model(model: Any, shape: tuple[int, int]) -> Model:
    """Build the model of neural observations for frames of ``shape`` (R, C); its answers are checked at every frame.

    Parameters
    ----------
    model
        A registered model's name, the path of a .py file that declares ``MODEL``, an entry such as that ``MODEL``, or
        a factory that is called with ``shape``, the tuple (rows, columns), as its only argument.

    Raises
    ------
    ValueError
        On an unknown name, a file that declares no model, and what is none of these.
    """
    built: Model = importlib.import_module(WIRING).build(model, shape)
    return built
