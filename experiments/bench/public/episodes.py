"""Score a behaviour from Python."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from experiments.bench.closed_loop import run as closed_loop_run
from experiments.bench.closed_loop.behaviour import Behaviour
from experiments.bench.closed_loop.find import load_behaviour
from experiments.bench.public.arguments import is_path, whole
from experiments.bench.run.errors import UsageError, short
from experiments.bench.stats.scores import Score


def score(
    behaviour: Behaviour | str | os.PathLike[str], *, episodes: int = 20, seed: int = 0, env: str | None = None,
    quiet: bool = False, **options: Any,
) -> Mapping[str, Score | None]:  # fmt: skip
    """Play a behaviour in this process, with progress, and score it.

    ``colias behave`` does the same on all cores, with recordings and against baselines.

    Parameters
    ----------
    behaviour
        A `Behaviour`, the name of one that ships, or the path of a .py file that declares ``BEHAVIOUR``.
    episodes
        How many to play; episode r has the seed ``seed + r``.
    seed
        Of the first episode, 0 or more.
    env
        ``Avoidance``, say, or an env's whole id; otherwise the behaviour's own.
    quiet
        Whether to show no progress.
    **options
        Arguments of the env, as ``robots=5``.

    Returns
    -------
    Mapping
        Measure -> `Score`, with its 95 % interval; ``None`` where the measure does not apply.

    Raises
    ------
    UsageError
        There is no such behaviour or env, or a number or an argument of the env is not legal. It is a ``ValueError``.

    Examples
    --------
    >>> from experiments import score
    >>> {name: str(value) for name, value in score("fixation", episodes=5).items()}
    """
    if is_path(behaviour):
        behaviour = load_behaviour(str(os.fspath(behaviour)))
    if not isinstance(behaviour, Behaviour):
        raise UsageError(f"score: {short(behaviour)}: legal is a Behaviour, a name, or the path of a .py file")
    if env is not None and not isinstance(env, str):
        raise UsageError(f"score: env={short(env)}: legal is the name of an env, Avoidance say")
    count, first = whole("episodes", episodes), whole("seed", seed)
    return closed_loop_run.score(behaviour, episodes=count, seed=first, env=env, quiet=quiet, **options)
