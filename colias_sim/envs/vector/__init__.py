"""Many envs at once, several in each process: ``gymnasium.make_vec("colias_sim/Fixation-v0", num_envs=8)``."""

from __future__ import annotations

from collections.abc import Callable

from colias_sim.envs.registry import ENVS
from colias_sim.envs.vector.env import ColiasVectorEnv
from colias_sim.envs.vector.factories import factory

__all__ = ["ColiasVectorEnv"]


def __getattr__(name: str) -> Callable[..., ColiasVectorEnv]:
    """Find the factory of a registered env, which `gymnasium.make_vec` calls: ``avoidance``, ``fixation`` and so on."""
    for entry in ENVS.values():
        if entry.vector_entry_point == f"{__name__}:{name}":
            return factory(entry.entry_point)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
