"""Behaviours, which drive the robot in an env, and trained policies, which are behaviours in a file."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from pydantic import ConfigDict, Field, TypeAdapter
from pydantic.dataclasses import dataclass as checked_dataclass

from colias_sim.envs import ENVS, NEURAL
from dsnn import Response, model_entry
from dsnn.exponential import exp
from experiments.base.errors import UsageError, check_known, check_name, short

Wheels = tuple[float, float]
"""A type: speeds of the wheels, left and right, as shares of the maximum; beyond -1 and 1 they are cut."""
Policy = Callable[[Any], Wheels]
"""Function from what is sensed to what to do next: a `dsnn.Response`, or a `colias_sim.envs.State`."""
Vector = npt.NDArray[np.float32]

AVOIDANCE, FIXATION = "colias_sim/Avoidance-v0", "colias_sim/Fixation-v0"
OPTOMOTOR, PURSUIT = "colias_sim/Optomotor-v0", "colias_sim/Pursuit-v0"
"""Ids of the envs."""
WHEELS = 2
TRAINED_UNDER = ("camera", "robot", "noise", "randomise")
"""The arguments of an env that a training may change. No other could be read from a file and make code run."""
ENDING = ".npz"
KEEP, REACH, LIMIT = 0.9, 0.04, 0.3
"""Share of a command that stays, its change by an answer of 1, and the greatest one: shares of the maximum."""
STEERING = {"keep": KEEP, "reach": REACH, "limit": LIMIT}


@dataclass(frozen=True, slots=True)
class Behaviour:
    """A driver of the robot in an env.

    Parameters
    ----------
    name
        Up to 60 letters, digits, ``.``, ``-`` and ``_``.
    summary
        A line for ``colias list``.
    env
        The env that it was written for, one of the four: ``Avoidance``, say.
    make
        Builds one episode's policy: a function of what is sensed that returns the wheels' speeds, left and right, as
        shares of the maximum, once a frame. ``make`` gets the episode's random generator.
    senses
        ``neural``: the policy gets a `dsnn.Response`. ``state``: it gets a `colias_sim.envs.State`, which is
        privileged.
    model
        The vision model on its camera, if its senses are neural: a name, or the path of a .py file.
    options
        Arguments that its env has unless others are given, such as the camera that a policy was trained with.

    Raises
    ------
    ValueError
        The name or the senses are not legal.

    Examples
    --------
    >>> from experiments import Behaviour
    >>> turn = Behaviour.reflex("turn", "turns with HS", "Optomotor", lambda seen: (0.2 * seen.hs, -0.2 * seen.hs))
    """

    name: str
    summary: str
    env: str
    make: Callable[[np.random.Generator], Policy]
    senses: Literal["neural", "state"] = "neural"
    model: str = "hybrid"
    options: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_name("behaviour", self.name)
        check_known("senses", self.senses, ("neural", "state"))

    @classmethod
    def reflex(cls, name: str, summary: str, env: str, reflex: Callable[[Response], Wheels]) -> Behaviour:
        """Make a behaviour without memory.

        Parameters
        ----------
        name, summary, env
            As of `Behaviour`.
        reflex
            A function of a `dsnn.Response` that returns the wheels' speeds, left and right, as shares of the maximum.

        Returns
        -------
        Behaviour
            The behaviour, with the model ``hybrid``.

        Raises
        ------
        ValueError
            A value is not legal.
        """
        return cls(name, summary, env, lambda rng: reflex)


def sense(observation: Vector, command: Vector) -> Vector:
    """Return what a network senses, (9,), of an observation (7,) and the last command to the wheels (2,)."""
    return np.concatenate([observation, command / np.float32(LIMIT)]).astype(np.float32)


def steer(last: Vector, answer: Vector) -> Vector:
    """Return the next command to the wheels, (2,), after the ``last`` one and two answers in [-1, 1].

    Answers do not move the wheels at once, full speed being 1250 degrees/s of turn: each frame a wheel keeps a share
    of its command and adds to it, within a limit.
    """
    wanted = KEEP * last + REACH * np.clip(answer, -1.0, 1.0)
    return np.clip(wanted, -LIMIT, LIMIT).astype(np.float32)


@checked_dataclass(frozen=True, config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True))
class TrainedPolicy:
    """A network of tanh layers, the last linear, that steers by the neural observation, and how it is trained.

    Plain NumPy. Before the training it has no layers.
    """

    env: str
    seed: int = Field(ge=0, lt=2**32)
    steps: int = Field(ge=0)
    envs: int = Field(ge=1)
    model: str = "hybrid"
    hidden: tuple[int, ...] = (32, 32)
    steering: Mapping[str, float] = Field(default_factory=lambda: STEERING)
    """How commands follow the network's answers; a policy drives only with the steering that it was trained with."""
    versions: Mapping[str, str] = Field(default_factory=dict)
    options: Mapping[str, Any] = Field(default_factory=dict)
    """The env's arguments in training, beside observation and model."""
    format: Literal["colias-policy 1"] = "colias-policy 1"
    layers: list[Any] = field(default_factory=list, compare=False, repr=False)
    """Weights (out, in) and biases (out,) of each, float32."""

    def __post_init__(self) -> None:
        check_known("env", self.env, ENVS)
        model_entry(self.model)
        if dict(self.steering) != STEERING:
            raise ValueError(f"steering must be {STEERING}, got {short(dict(self.steering))}")
        for name in self.options:
            if name not in TRAINED_UNDER:
                raise ValueError(f"a training may change {', '.join(TRAINED_UNDER)}, got {short(name)}")

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
        """Return it as a behaviour, under the arguments of its training: each episode begins with wheels at rest."""
        summary = f"a network trained for {self.steps:,} steps"
        return Behaviour(name, summary, self.env, lambda rng: self._driver(), "neural", self.model, self.options)

    def _driver(self) -> Policy:
        command = np.zeros(WHEELS, np.float32)

        def drive(seen: Response) -> Wheels:
            nonlocal command
            # As in training, a channel that the model does not answer is 0.
            observation = np.array([getattr(seen, name, 0.0) for name in NEURAL], np.float32)
            command = steer(command, self.answer(sense(observation, command)))
            return float(command[0]), float(command[1])

        return drive

    def save(self, path: Path) -> None:
        """Write it as an .npz file of float32 arrays and a JSON text."""
        from experiments.base.files import replacing  # not before: it loads polars, and listing behaviours needs none

        arrays = {"about": np.array(TypeAdapter(TrainedPolicy).dump_json(self, exclude={"layers"}).decode())}
        for place, (weights, biases) in enumerate(self.layers):
            arrays |= {f"weights{place}": weights, f"biases{place}": biases}
        with replacing(path) as partial, partial.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays)


def load_policy(path: Path) -> TrainedPolicy:
    """Read a trained policy from its file, which runs nothing that is in it; `UsageError` where it holds none."""
    try:
        with np.load(path, allow_pickle=False) as file:
            about = json.loads(str(file["about"]))
            layers = [(file[f"weights{place}"], file[f"biases{place}"]) for place in range(len(about["hidden"]) + 1)]
            return TypeAdapter(TrainedPolicy).validate_python({**about, "layers": layers})
    except (ValueError, KeyError, TypeError, OSError) as error:
        raise UsageError(f"{path}: not a policy file ({' '.join(str(error).split())[:200]})") from None


def _tanh(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return the hyperbolic tangent, by the exponential that has equal bits everywhere; to 1e-16."""
    return np.array([1.0 - 2.0 / (exp(2.0 * value) + 1.0) for value in values.flat]).reshape(values.shape)
