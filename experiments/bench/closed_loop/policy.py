"""A trained policy: a small network that steers by the neural observation, as a behaviour. Plain NumPy."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

import numpy as np
import numpy.typing as npt
from gymnasium.envs.registration import load_env_creator
from pydantic import AfterValidator, ConfigDict, Field, ValidationInfo
from pydantic.dataclasses import dataclass

from colias_sim.envs import ENVS, NEURAL
from colias_sim.envs.options import checked
from dsnn import Response, model_entry
from dsnn.exponential import exp
from experiments.bench.closed_loop.behaviour import Behaviour, Wheels
from experiments.bench.closed_loop.steering import WHEELS, Steering, Vector

Layer = tuple[Vector, Vector]
"""Weights (out, in) and biases (out,), float32."""

FORMAT: Literal["colias-policy 1"] = "colias-policy 1"
TRAINABLE = ("colias_sim/Fixation-v0", "colias_sim/Optomotor-v0")
ROLLOUT = 256
"""Steps of each env between two updates of a network in training, and the size of a minibatch."""

TRAINED_UNDER = ("camera", "robot", "noise", "randomise")
"""The arguments of an env that a training may change."""

SENSED = len(NEURAL) + WHEELS
"""Senses of a network: the neural observation, and what it last told the wheels."""


def _known_env(name: str) -> str:
    if name not in ENVS:
        raise ValueError(f"no such env; known are {', '.join(ENVS)}")
    return name


def _known_model(name: str) -> str:
    model_entry(name)
    return name


def _legal_options(options: Mapping[str, Any], info: ValidationInfo) -> Mapping[str, Any]:
    """Check arguments of the env. Refuse those by which a policy's file could make an env run code of others."""
    for name in options:
        if name not in TRAINED_UNDER:
            raise ValueError(f"no argument to be trained under: '{name}'; legal are {', '.join(TRAINED_UNDER)}")
    if "env" in info.data:
        env: Any = load_env_creator(ENVS[info.data["env"]].entry_point)
        checked(env.options_type, options)
    return options


@dataclass(frozen=True, config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True))
class About:
    """Purpose, size and origin of a policy."""

    env: Annotated[str, AfterValidator(_known_env)]
    seed: int = Field(ge=0, lt=2**32)
    steps: int = Field(ge=0)
    envs: int = Field(ge=1)
    model: Annotated[str, AfterValidator(_known_model)] = "hybrid"
    hidden: tuple[Annotated[int, Field(ge=1, le=512)], ...] = Field(default=(32, 32), max_length=4)
    steering: Steering = Steering()
    versions: Mapping[str, str] = Field(default_factory=dict)
    options: Annotated[Mapping[str, Any], AfterValidator(_legal_options)] = Field(default_factory=dict)
    """The env's arguments in training, beside observation and model."""
    format: Literal["colias-policy 1"] = FORMAT

    def shapes(self) -> list[tuple[int, int]]:
        """(out, in) of each layer."""
        sizes = [SENSED, *self.hidden, WHEELS]
        return list(zip(sizes[1:], sizes[:-1], strict=True))


def _tanh(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the hyperbolic tangent, by the exponential that has equal bits everywhere; to 1e-16."""
    return np.array([1.0 - 2.0 / (exp(2.0 * value) + 1.0) for value in values.flat]).reshape(values.shape)


class Policy:
    """A network of tanh layers, the last linear. Raises ``ValueError`` on layers that do not fit ``about``."""

    def __init__(self, about: About, layers: list[Layer]) -> None:
        shapes = [(weights.shape, biases.shape) for weights, biases in layers]
        expected = [(shape, shape[:1]) for shape in about.shapes()]
        if shapes != expected:
            raise ValueError(f"layers of shapes {shapes}: expected {expected}")
        if not all(np.isfinite(part).all() for layer in layers for part in layer):
            raise ValueError("weights that are not finite")
        self.about, self.layers = about, layers

    def answer(self, sensed: Vector) -> Vector:
        """Return the network's answer, (2,) or (N, 2), not yet cut to [-1, 1], to what is sensed, (9,) or (N, 9).

        The answer has the same bits on every machine; otherwise episodes would differ between machines. Products of
        two float32 numbers are exact in float64. They are added in a fixed order, which a library of linear algebra
        would choose by the processor.
        """
        answered = np.asarray(sensed, np.float32)
        for place, (weights, biases) in enumerate(self.layers, 1):
            terms = answered[..., None, :].astype(np.float64) * weights
            sums = np.cumsum(terms, axis=-1)[..., -1] + biases
            answered = (sums if place == len(self.layers) else _tanh(sums)).astype(np.float32)
        return answered

    def behaviour(self, name: str) -> Behaviour:
        """Return what `behave` plays: each episode begins with the wheels at rest."""
        trained = "untrained" if self.about.steps == 0 else f"trained for {self.about.steps:,} steps"
        return Behaviour(name, f"a network {trained}", self.about.env, lambda rng: self._driver(), "neural",
                         self.about.model)  # fmt: skip

    def _driver(self) -> Callable[[Any], Wheels]:
        steering, command = self.about.steering, np.zeros(WHEELS, np.float32)

        def drive(seen: Response) -> Wheels:
            nonlocal command
            # As in training, a channel that the model does not answer is 0.
            observation = np.array([getattr(seen, name, 0.0) for name in NEURAL], np.float32)
            command = steering.command(command, self.answer(steering.sense(observation, command)))
            return float(command[0]), float(command[1])

        return drive
