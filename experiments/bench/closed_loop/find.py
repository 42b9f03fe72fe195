"""Behaviours found by name: registered by name, a user's own by the path of its file."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from colias_sim.envs import ENVS
from experiments.bench.closed_loop.behaviour import Behaviour
from experiments.bench.run.errors import UsageError, check_name
from experiments.bench.run.models import beside
from experiments.bench.run.user_code import declared, is_own
from scenes.hints import nearest


def load_behaviour(source: str) -> Behaviour:
    """Find the registered behaviour called ``source``, that which the file ``source`` declares as ``BEHAVIOUR``, or the
    trained policy in a file that ends in .npz.

    Raises `UsageError` on an unknown name, a file that declares no `Behaviour`, and one that holds no policy.
    """
    if source.endswith(".npz"):
        from experiments.bench.closed_loop import policy_file

        try:
            check_name("policy", Path(source).stem)
        except ValueError as error:
            raise UsageError(f"{source}: {error}") from None
        return policy_file.load(Path(source)).behaviour(Path(source).stem)
    if not is_own(source):
        from experiments.behaviours import BEHAVIOURS, GROUPS

        if source not in BEHAVIOURS:
            known = (*GROUPS, *BEHAVIOURS)
            near = nearest(source, known, " (", ")")
            raise UsageError(
                f"no behaviour '{source}'{near}: known are {', '.join(known)}, a .py file, or a policy's .npz"
            )
        return BEHAVIOURS[source]
    entry = declared(Path(source), "BEHAVIOUR")
    if not isinstance(entry, Behaviour):
        raise UsageError(f"{source}: BEHAVIOUR is a {type(entry).__name__}, expected a Behaviour")
    if not isinstance(entry.model, str):
        raise UsageError(f"{source}: BEHAVIOUR.model is a {type(entry.model).__name__}, expected a name or a path")
    env_id(entry.env)
    return dataclasses.replace(entry, model=beside(Path(source), entry.model, "BEHAVIOUR.model"))


def members(name: str) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the behaviours that ``name`` means, and what a group of them is held against; nothing of a single one."""
    from experiments.behaviours import GROUPS, REFERENCE

    return (GROUPS[name], REFERENCE[name]) if name in GROUPS else ((name,), ())


def env_id(name: str) -> str:
    """Find the registered env's id of ``Avoidance``, ``Avoidance-v0`` or the id itself; `UsageError` otherwise."""
    for known in ENVS:
        if name in (known, known.partition("/")[2], known.partition("/")[2].partition("-")[0]):
            return known
    shorts = [known.partition("/")[2] for known in ENVS]
    raise UsageError(f"--env {name}{nearest(name, shorts, ' (', ')')}: known are {', '.join(shorts)}")
