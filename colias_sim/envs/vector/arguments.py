"""Checks of a vector env's own arguments. Each raises ``ValueError`` that names the value and what is legal."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode

from colias_sim.envs.flags import one_line, whole
from colias_sim.envs.vector.launch import POSSIBLE

Flags = npt.NDArray[np.bool_]


def env_count(num_envs: Any) -> int:
    """Return the number of worlds for the argument ``num_envs``."""
    count = whole(num_envs)
    if count is None or count < 1:
        raise ValueError(f"num_envs={num_envs!r}: expected a whole number, 1 or more")
    return count


def autoreset(mode: AutoresetMode | str) -> AutoresetMode:
    """Tell when an env that has ended is reset, for the argument ``autoreset_mode``."""
    try:
        return AutoresetMode(mode)
    except ValueError:
        names = ", ".join(member.value for member in AutoresetMode)
        raise ValueError(f"autoreset_mode={mode!r}: legal is {names}") from None


def reset_entries(options: Any) -> dict[str, Any]:
    """Return a copy of the argument ``options`` of a reset; empty for ``None``."""
    if options is None:
        return {}
    if not isinstance(options, Mapping):
        raise ValueError(f"reset(options={one_line(options)}): expected a mapping from names to values")
    return dict(options)


def worker_count(workers: int | None, num_envs: int) -> int:
    """Tell the number of processes for the argument ``workers``: 0 for this process alone, ``None`` for one a core."""
    if not POSSIBLE and workers:
        raise ValueError(f"workers={workers}: other processes need POSIX, give 0 (all in this process)")
    if not POSSIBLE:
        return 0
    if workers is None:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        return min(cores, num_envs)
    count = whole(workers)
    if count is None or not 0 <= count <= num_envs:
        raise ValueError(f"workers={workers!r}: expected 0 (all in this process) .. num_envs={num_envs}")
    return count


def shares(num_envs: int, parts: int) -> list[tuple[int, int]]:
    """Divide the envs among ``parts`` processes as evenly as possible: (first env, number of envs) of each."""
    ends = [num_envs * k // parts for k in range(parts + 1)]
    return [(first, end - first) for first, end in pairwise(ends)]


def step_limit(steps: int | None) -> int | None:
    """Return the limit for the argument ``max_episode_steps``; ``None`` for none, as -1 is to `gymnasium.make`."""
    if steps is None or steps == -1:
        return None
    count = whole(steps)
    if count is None or count < 1:
        raise ValueError(f"max_episode_steps={steps!r}: expected a whole number, 1 or more, or -1 for no limit")
    return count


def reset_mask(mask: Any, num_envs: int) -> Flags:
    """Return the envs to be reset, (num_envs,) bool, for the option ``reset_mask``; all for ``None``."""
    if mask is None:
        return np.ones(num_envs, np.bool_)
    try:
        chosen = np.asarray(mask)
    except ValueError:  # rows of different lengths
        chosen = np.empty(0)
    if chosen.shape != (num_envs,) or chosen.dtype != np.bool_ or not chosen.any():
        raise ValueError(f"reset_mask={one_line(mask)}: expected ({num_envs},) booleans, at least one of them true")
    return chosen


def reset_seeds(seed: Any, num_envs: int) -> list[int | None]:
    """Return a seed for each env: an integer counts up from env to env, ``None`` is ``None`` for all."""
    listed = isinstance(seed, Sequence | np.ndarray) and not isinstance(seed, str | bytes)
    several = listed and getattr(seed, "ndim", 1) > 0
    given = list(seed) if several else [seed] * num_envs
    seeds = [
        None if seed_given is None else -1 if (number := whole(seed_given)) is None else number for seed_given in given
    ]
    if len(seeds) != num_envs or any(s is not None and s < 0 for s in seeds):
        raise ValueError(f"seed={one_line(seed)}: expected a whole number from 0, or {num_envs} of them, or None")
    return seeds if several else [None if s is None else s + i for i, s in enumerate(seeds)]
