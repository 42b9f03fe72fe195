"""Checks of a vector env's own arguments. Each raises ``ValueError`` that names the value and what is legal."""

from __future__ import annotations

import operator
import os
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode

from colias_sim.envs.flags import is_flag
from colias_sim.envs.vector.launch import POSSIBLE

Flags = npt.NDArray[np.bool_]


def env_count(num_envs: Any) -> int:
    """The number of worlds for the argument ``num_envs``."""
    count = _whole(num_envs)
    if count is None or count < 1:
        raise ValueError(f"num_envs={num_envs!r}: expected a whole number, 1 or more")
    return count


def autoreset(mode: AutoresetMode | str) -> AutoresetMode:
    """When an env that has ended is reset, for the argument ``autoreset_mode``."""
    try:
        return AutoresetMode(mode)
    except ValueError:
        names = ", ".join(each.value for each in AutoresetMode)
        raise ValueError(f"autoreset_mode={mode!r}: legal is {names}") from None


def reset_entries(options: Any) -> dict[str, Any]:
    """A copy of the argument ``options`` of a reset; empty for ``None``."""
    if options is None:
        return {}
    if not isinstance(options, Mapping):
        raise ValueError(f"reset(options={_one_line(options)}): expected a mapping from names to values")
    return dict(options)


def worker_count(workers: int | None, num_envs: int) -> int:
    """The number of processes for the argument ``workers``: 0 for this process alone, ``None`` for one a core."""
    if not POSSIBLE and workers:
        raise ValueError(f"workers={workers}: other processes need POSIX, give 0 (all in this process)")
    if not POSSIBLE:
        return 0
    if workers is None:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        return min(cores, num_envs)
    count = _whole(workers)
    if count is None or not 0 <= count <= num_envs:
        raise ValueError(f"workers={workers!r}: expected 0 (all in this process) .. num_envs={num_envs}")
    return count


def shares(num_envs: int, parts: int) -> list[tuple[int, int]]:
    """Divide the envs among ``parts`` processes as evenly as possible: (first env, number of envs) of each."""
    ends = [num_envs * k // parts for k in range(parts + 1)]
    return [(first, end - first) for first, end in pairwise(ends)]


def step_limit(steps: int | None) -> int | None:
    """The limit for the argument ``max_episode_steps``; ``None`` for none, as -1 is to `gymnasium.make`."""
    if steps is None or steps == -1:
        return None
    count = _whole(steps)
    if count is None or count < 1:
        raise ValueError(f"max_episode_steps={steps!r}: expected a whole number, 1 or more, or -1 for no limit")
    return count


def reset_mask(mask: Any, num_envs: int) -> Flags:
    """The envs to be reset, (num_envs,) bool, for the option ``reset_mask``; all for ``None``."""
    if mask is None:
        return np.ones(num_envs, np.bool_)
    chosen = np.asarray(mask)
    if chosen.shape != (num_envs,) or chosen.dtype != np.bool_ or not chosen.any():
        raise ValueError(f"reset_mask={_one_line(mask)}: expected ({num_envs},) booleans, at least one of them true")
    return chosen


def reset_seeds(seed: Any, num_envs: int) -> list[int | None]:
    """A seed for each env: an integer counts up from env to env, ``None`` is ``None`` for all."""
    try:
        seeds = list(seed) if isinstance(seed, Sequence | np.ndarray) else [seed] * num_envs
        whole = [None if s is None else -1 if is_flag(s) else operator.index(s) for s in seeds]
    except TypeError:
        whole = [-1]
    if len(whole) != num_envs or any(s is not None and s < 0 for s in whole):
        raise ValueError(f"seed={_one_line(seed)}: expected a whole number from 0, or {num_envs} of them, or None")
    if isinstance(seed, Sequence | np.ndarray):
        return whole
    return [None if s is None else s + i for i, s in enumerate(whole)]


def _whole(value: Any) -> int | None:
    """A whole number as an ``int``; ``None`` for anything else, a truth value too."""
    try:
        return None if is_flag(value) else operator.index(value)
    except TypeError:
        return None


def _one_line(value: Any) -> str:
    """The text of a value in one line of at most 80 characters; that of a long array has several."""
    return " ".join(repr(value).split())[:80]
