"""The factories of vector envs, which `gymnasium.make_vec` calls."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import partial

from colias_sim.envs.vector.env import ColiasVectorEnv
from colias_sim.envs.vector.host import env_class


def factory(entry_point: str) -> Callable[..., ColiasVectorEnv]:
    """Make the factory of an env's vector env.

    Parameters
    ----------
    entry_point
        The env's class, as ``module:name``.

    Returns
    -------
    callable
        `ColiasVectorEnv` for this env. Its signature spells out the env's keyword arguments.
    """
    make = partial(ColiasVectorEnv, entry_point)
    _, *parameters = inspect.signature(ColiasVectorEnv).parameters.values()
    options = inspect.signature(env_class(entry_point)).parameters.values()
    make.__signature__ = inspect.Signature([*parameters[:-1], *options], return_annotation=ColiasVectorEnv)  # type: ignore[attr-defined]
    return make
