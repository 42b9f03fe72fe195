"""Behaviours: policies over the answers of the network, or of a privileged sense."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from colias_sim.envs import State
from dsnn import Response
from experiments.bench.run.errors import check_name

Wheels = tuple[float, float]
"""A type: speeds of the wheels, left and right, as shares of the maximum; beyond -1 and 1 they are cut."""

Policy = Callable[[Any], Wheels]
"""Function from what is sensed to what to do next: a `dsnn.Response`, or a `colias_sim.envs.State`."""


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
        The env that it was written for: ``Avoidance``, say.
    make
        Builds one episode's policy: a function of what is sensed that returns the wheels' speeds, left and right, as
        shares of the maximum, once a frame. ``make`` gets the episode's random generator.
    senses
        ``neural``: the policy gets a `dsnn.Response`. ``state``: it gets a `colias_sim.envs.State`, which is
        privileged.
    model
        The vision model on its camera, if its senses are neural: a name, or the path of a .py file.

    Raises
    ------
    ValueError
        A value is not legal.

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

    def __post_init__(self) -> None:
        check_name("behaviour", self.name)
        if self.senses not in ("neural", "state"):
            raise ValueError(f"behaviour {self.name}: senses={self.senses!r}: legal is neural or state")
        if not callable(self.make) or not isinstance(self.summary, str):
            raise ValueError(f"behaviour {self.name}: legal are a text for summary and a callable for make")

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

    @classmethod
    def oracle(cls, name: str, summary: str, env: str, policy: Callable[[State], Wheels]) -> Behaviour:
        """Make a privileged behaviour, which is given the state of the world.

        Parameters
        ----------
        name, summary, env
            As of `Behaviour`.
        policy
            A function of a `colias_sim.envs.State` that returns the wheels' speeds, left and right, as shares of the
            maximum.

        Returns
        -------
        Behaviour
            The behaviour.

        Raises
        ------
        ValueError
            A value is not legal.
        """
        return cls(name, summary, env, lambda rng: policy, senses="state")


def by_name(entries: Iterable[Behaviour]) -> Mapping[str, Behaviour]:
    """Return the entries by name; ``ValueError`` if two share one."""
    listed = list(entries)
    table = {entry.name: entry for entry in listed}
    if len(table) != len(listed):
        raise ValueError(f"two behaviours share a name in {[entry.name for entry in listed]}")
    return MappingProxyType(table)
