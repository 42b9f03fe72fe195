"""Many envs at once, several to a process: ``gymnasium.make_vec("colias_sim/Fixation-v0", num_envs=8)``."""

from __future__ import annotations

import operator
import os
import weakref
from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import error
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from colias_sim.envs.actions import batch_of
from colias_sim.envs.base import check_reset_options, spaces_of
from colias_sim.envs.crew import Crew, Here
from colias_sim.envs.hosting import Task, env_class
from colias_sim.envs.infos import merged
from colias_sim.envs.launching import POSSIBLE
from colias_sim.envs.options import checked
from colias_sim.envs.registry import ENVS

_OWN = ("reset", "step", "close")
Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]


class ColiasVectorEnv(VectorEnv[Any, Any, npt.NDArray[Any]]):
    """``num_envs`` worlds of one env, with the env's own keyword arguments, in ``workers`` processes.

    What they observe, and are rewarded, is that of single envs of the same seeds and actions, however many processes
    there are: by default one for each core this process may use; with 0 all is done in this one. Whatever a process
    raises is raised here, ``RuntimeError`` if it died; then, and after Ctrl-C in the middle of a step, everything is
    closed. Also raises ``ValueError`` for arguments out of range.

    The processes do not run the script that makes them, which may be any file, standard input or a notebook, with or
    without ``if __name__ == "__main__":``. They find modules where this process does (``sys.path``). Functions and
    classes of the script are sent by cloudpickle, with the global names that they use: a global that does not pickle
    (a lock, an open file, an env) is a ``ValueError``. They are copies: what a process does to a global of the script
    is not seen here, nor the other way about. Without POSIX (on Windows) all is done in this process.
    """

    def __init__(
        self,
        entry_point: str,
        num_envs: int = 1,
        *,
        workers: int | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        max_episode_steps: int | None = None,
        **options: Any,
    ) -> None:
        if num_envs < 1:
            raise ValueError(f"num_envs={num_envs}: expected 1 or more")
        own = checked(env_class(entry_point).options_type, options)
        self.num_envs, self.render_mode = num_envs, own.render_mode
        self.single_observation_space, self.single_action_space = seen, acted = spaces_of(own)
        self.observation_space, self.action_space = batch_space(seen, num_envs), batch_space(acted, num_envs)
        self._mode, limit = AutoresetMode(autoreset_mode), _limit(max_episode_steps)
        self._begun = np.zeros(num_envs, np.bool_)
        number = _processes(workers, num_envs)
        self._tasks = [
            Task(entry_point, first, count, num_envs, limit, self._mode)
            for first, count in _shares(num_envs, max(number, 1))
        ]
        self._crew: Crew | Here = (
            Here(self._tasks[0], options, seen, acted) if number == 0 else Crew(self._tasks, options, seen, acted)
        )
        self.metadata = {**self._crew.metadata, "autoreset_mode": self._mode}
        # OpenGL in this process is gone by the time of atexit; processes are not.
        weakref.finalize(self, self._crew.close).atexit = number != 0

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode in every env, or in those of ``options["reset_mask"]``, (num_envs,) bool.

        An integer seeds env i with seed + i; otherwise a seed for each, or ``None``.
        """
        self._check_open()
        rest = dict(options or {})
        chosen = _mask(rest.pop("reset_mask", None), self.num_envs)
        check_reset_options(rest)
        seeds = _seeds(seed, self.num_envs)
        if not (self._begun | chosen).all():
            raise error.ResetNeeded("the first reset must be of all envs: without a reset_mask")
        groups = self._ask("reset", [(seeds[task.rows], chosen[task.rows].tolist()) for task in self._tasks])
        self._begun[:] = True
        return self._crew.board.copied(), merged(groups, self.num_envs, self._add_info)

    def step(self, actions: Any) -> tuple[Any, Floats, Flags, Flags, dict[str, Any]]:
        """Observations (num_envs, ...), rewards, terminated, truncated (num_envs,), and infos after one action each.

        Raises `gymnasium.error.InvalidAction` naming the env, before any has moved; `gymnasium.error.ResetNeeded`
        before the first reset, and where autoreset is disabled after an end.
        """
        self._check_open()
        if not self._begun.all():
            raise error.ResetNeeded("step() before reset(): call reset() first")
        board = self._crew.board
        ended = board.terminated | board.truncated
        if self._mode is AutoresetMode.DISABLED and ended.any():
            raise error.ResetNeeded(f"envs {np.flatnonzero(ended).tolist()} have ended: reset them with a reset_mask")
        board.actions[:] = batch_of(self.single_action_space, actions, self.num_envs)
        infos = merged(self._ask("step"), self.num_envs, self._add_info)
        return board.copied(), board.rewards.copy(), board.terminated.copy(), board.truncated.copy(), infos

    def render(self) -> tuple[Any, ...] | None:
        """What each env's ``render()`` gives: with ``render_mode="rgb_array"`` a picture (H, W, 3) uint8."""
        self._check_open()
        if self.render_mode is None:
            gym.logger.warn("render() without a render_mode: give one to gym.make_vec, for example 'rgb_array'")
            return None
        if not self._begun.all():
            raise error.ResetNeeded("render() before reset(): call reset() first")
        return tuple(self._ask("render"))

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """What each env's method ``name`` gives, or its attribute of that name: for example ``call("render")``.

        From other processes come copies; what does not pickle, either way, is a ``ValueError``. That, and what the
        method itself raises, of the first env whose does, leaves everything open. Raises ``ValueError`` for
        ``reset``, ``step`` and ``close``, which this class has for all envs at once.
        """
        self._check_open()
        if name in _OWN:
            raise ValueError(f"Trying to call function `{name}` with `call`, use `{name}` directly instead.")
        return tuple(self._call("call", [(name, args, kwargs)] * len(self._tasks)))

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """The attribute ``name`` of each env; of a function, what it gives, as by `call`."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set the attribute ``name`` of each env: to its own of a list or tuple of values, or all to the same one.

        Raises ``ValueError`` for a list or tuple of another length. Errors leave everything open, as with `call`.
        """
        self._check_open()
        each = list(values) if isinstance(values, list | tuple) else [values] * self.num_envs
        if len(each) != self.num_envs:
            raise ValueError(
                "Values must be a list or tuple with length equal to the number of environments. "
                f"Got `{len(each)}` values for {self.num_envs} environments."
            )
        self._call("assign", [(name, each[task.rows]) for task in self._tasks])

    @property  # type: ignore[misc]
    def np_random(self) -> tuple[np.random.Generator, ...]:  # type: ignore[override]
        """The random number generator of each env; from other processes come copies."""
        return self.get_attr("np_random")

    @property
    def np_random_seed(self) -> tuple[int, ...]:  # type: ignore[override]
        """The seed of each env."""
        return self.get_attr("np_random_seed")

    def close_extras(self, **kwargs: Any) -> None:
        """End the processes, or close the envs in this one."""
        self._crew.close()

    def _call(self, what: str, arguments: Sequence[tuple[Any, ...]]) -> list[Any]:
        try:
            replies = self._crew.call(what, arguments)
        except BaseException:  # a process died, or Ctrl-C, as in `_ask`
            self.close()
            raise
        for reply in replies:
            if isinstance(reply, Exception):
                raise reply
        return [given for reply in replies if isinstance(reply, list) for given in reply]

    def _ask(self, what: str, arguments: Sequence[tuple[Any, ...]] | None = None) -> list[Any]:
        try:
            return [part for answer in self._crew.ask(what, arguments) for part in answer]
        except BaseException:  # Ctrl-C too: what is under way would be taken for the answer to the next question
            self.close()
            raise

    def _check_open(self) -> None:
        if self.closed:
            raise error.ClosedEnvironmentError("this vector env is closed: make a new one")


def __getattr__(name: str) -> Callable[..., ColiasVectorEnv]:
    """``fixation``, ``pursuit`` and so on: what `gymnasium.make_vec` calls, for every env of `ENVS`."""
    for entry in ENVS.values():
        if entry.vector_entry_point == f"{__name__}:{name}":
            return partial(ColiasVectorEnv, entry.entry_point)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _processes(workers: int | None, num_envs: int) -> int:
    """How many; 0 for none but this one."""
    if not POSSIBLE and workers:
        raise ValueError(f"workers={workers}: other processes need POSIX, give 0 (all in this process)")
    if not POSSIBLE:
        return 0
    if workers is None:
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        return min(cores, num_envs)
    if not 0 <= workers <= num_envs:
        raise ValueError(f"workers={workers}: expected 0 (all in this process) .. num_envs={num_envs}")
    return workers


def _shares(num_envs: int, parts: int) -> list[tuple[int, int]]:
    """(first, count) of each part, as even as they can be."""
    ends = [num_envs * k // parts for k in range(parts + 1)]
    return [(first, end - first) for first, end in pairwise(ends)]


def _limit(steps: int | None) -> int | None:
    if steps is None or steps == -1:  # gymnasium.make's word for none
        return None
    if steps < 1:
        raise ValueError(f"max_episode_steps={steps}: expected 1 or more, or -1 for no limit")
    return steps


def _mask(mask: Any, num_envs: int) -> Flags:
    if mask is None:
        return np.ones(num_envs, np.bool_)
    chosen = np.asarray(mask)
    if chosen.shape != (num_envs,) or chosen.dtype != np.bool_ or not chosen.any():
        raise ValueError(f"reset_mask={mask!r}: expected ({num_envs},) booleans, at least one of them true")
    return chosen


def _seeds(seed: Any, num_envs: int) -> list[int | None]:
    try:
        seeds = list(seed) if isinstance(seed, Sequence | np.ndarray) else [seed] * num_envs
        whole = [None if s is None else operator.index(s) for s in seeds]
    except TypeError:
        whole = [-1]
    if len(whole) != num_envs or any(s is not None and s < 0 for s in whole):
        raise ValueError(f"seed={seed!r}: expected a whole number from 0, or {num_envs} of them, or None")
    if isinstance(seed, Sequence | np.ndarray):
        return whole
    return [None if s is None else s + i for i, s in enumerate(whole)]
