"""What a behaviour is, and how to find one: registered by name, a user's own by the path of its file."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

from colias_sim.envs import ENVS, State
from dsnn import Response
from experiments.bench.files import UsageError, check_name, declared, is_file

Wheels = tuple[float, float]
"""Speeds of the wheels, left and right, as shares of the maximum; beyond -1 and 1 they are cut."""

Policy = Callable[[Any], Wheels]
"""What to do next, from what is sensed: a `dsnn.Response`, or a `colias_sim.envs.State`."""


@dataclass(frozen=True, slots=True)
class Behaviour:
    """A behaviour by name: ``make`` builds one episode's policy, and may draw from the generator it is given."""

    name: str
    summary: str
    env: str
    """The env it was written for."""
    make: Callable[[np.random.Generator], Policy]
    senses: Literal["neural", "state"] = "neural"
    model: str = "hybrid"
    """The vision model on its camera, if its senses are neural: a name, or the path of a .py file."""

    def __post_init__(self) -> None:
        check_name("behaviour", self.name)
        if self.senses not in ("neural", "state"):
            raise ValueError(f"behaviour {self.name}: senses={self.senses!r}: legal is neural or state")
        if not callable(self.make) or not isinstance(self.summary, str):
            raise ValueError(f"behaviour {self.name}: legal are a text for summary and a callable for make")

    @classmethod
    def reflex(cls, name: str, summary: str, env: str, reflex: Callable[[Response], Wheels]) -> Behaviour:
        """One without memory: a function of a `dsnn.Response`."""
        return cls(name, summary, env, lambda rng: reflex)

    @classmethod
    def told(cls, name: str, summary: str, env: str, policy: Callable[[State], Wheels]) -> Behaviour:
        """A privileged one: a function of a `colias_sim.envs.State`."""
        return cls(name, summary, env, lambda rng: policy, senses="state")


def in_file(source: str) -> bool:
    """Whether ``source`` means a file rather than something registered."""
    return is_file(source) or source.endswith(".npz")


def by_name(entries: Iterable[Behaviour]) -> Mapping[str, Behaviour]:
    """The entries by name; ``ValueError`` if two share one."""
    listed = list(entries)
    table = {entry.name: entry for entry in listed}
    if len(table) != len(listed):
        raise ValueError(f"two behaviours share a name in {[entry.name for entry in listed]}")
    return MappingProxyType(table)


def load_behaviour(source: str) -> Behaviour:
    """The registered behaviour called ``source``, that which the file ``source`` declares as ``BEHAVIOUR``, or the
    trained policy in a file that ends in .npz.

    Raises `UsageError` on an unknown name, a file that declares no `Behaviour`, and one that holds no policy.
    """
    if source.endswith(".npz"):
        from experiments.bench import policy_file

        try:
            check_name("policy", Path(source).stem)
        except ValueError as error:
            raise UsageError(f"{source}: {error}") from None
        return policy_file.load(Path(source)).behaviour(Path(source).stem)
    if not in_file(source):
        from experiments.behaviours import BEHAVIOURS

        if source not in BEHAVIOURS:
            near = difflib.get_close_matches(source, BEHAVIOURS, n=1, cutoff=0.0)[0]
            raise UsageError(f"no behaviour '{source}': known are {', '.join(BEHAVIOURS)}, a .py file, or a policy's"
                             f" .npz (nearest: {near})")  # fmt: skip
        return BEHAVIOURS[source]
    entry = declared(Path(source), "BEHAVIOUR")
    if not isinstance(entry, Behaviour):
        raise UsageError(f"{source}: BEHAVIOUR is a {type(entry).__name__}, expected a Behaviour")
    env_id(entry.env)
    return entry


def env_id(name: str) -> str:
    """The registered env's whole id of ``Avoidance``, ``Avoidance-v0`` or the id itself; `UsageError` otherwise."""
    for known in ENVS:
        if name in (known, known.partition("/")[2], known.partition("/")[2].partition("-")[0]):
            return known
    shorts = [known.partition("/")[2] for known in ENVS]
    near = difflib.get_close_matches(name, shorts, n=1, cutoff=0.0)[0]
    raise UsageError(f"--env {name}: known are {', '.join(shorts)} (nearest: {near})")
