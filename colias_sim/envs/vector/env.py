"""The vector env: many worlds of one env behind Gymnasium's `VectorEnv`."""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
from gymnasium import error
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from colias_sim.envs.actions import batch_of
from colias_sim.envs.options import checked
from colias_sim.envs.spaces import spaces_of
from colias_sim.envs.vector.arguments import (
    Flags,
    autoreset,
    env_count,
    reset_entries,
    reset_mask,
    reset_seeds,
    shares,
    step_limit,
    worker_count,
)
from colias_sim.envs.vector.calls import CallingVectorEnv
from colias_sim.envs.vector.host import Task, env_class
from colias_sim.envs.vector.info import merge_infos
from colias_sim.envs.vector.processes import InProcess, Processes

Floats = npt.NDArray[np.float64]


class ColiasVectorEnv(CallingVectorEnv):
    """Many worlds of one env, in this process or in several others.

    Observations and rewards are those of single envs with the same seeds and actions, whatever ``workers`` is. After
    an error in a process, and after Ctrl-C in the middle of a step, everything is closed.

    The processes do not run the script that makes them, which may be any file, standard input or a notebook, with or
    without ``if __name__ == "__main__":``. They find modules where this process does (``sys.path``). Functions and
    classes of the script are sent by cloudpickle, with the global names that they use. They are copies: a process that
    changes a global of the script changes its own copy only, and does not see changes that are made here later.

    Parameters
    ----------
    entry_point
        The env's class, as ``module:name``. `gymnasium.make_vec` fills this in.
    num_envs
        The number of worlds.
    workers
        The number of processes, at most ``num_envs``. 0: all is done in this process, as always without POSIX (on
        Windows). ``None``: one process for each core that this process may use.
    autoreset_mode
        When an env that has ended is reset.
    max_episode_steps
        After how many steps an episode is truncated; -1 or ``None`` for no limit.
    **options
        The keyword arguments of the env. The factories that `gymnasium.make_vec` calls have them in their signature,
        for example ``inspect.signature(colias_sim.envs.vector.fixation)``.

    Raises
    ------
    ValueError
        For arguments out of range, and, with processes, for a global of the script that does not pickle (a lock, an
        open file, an env).
    RuntimeError
        If a process dies.
    Exception
        Whatever a process raises.

    Examples
    --------
    >>> import colias_sim  # registers the envs
    >>> import gymnasium as gym
    >>> envs = gym.make_vec("colias_sim/Fixation-v0", num_envs=2, workers=0, observation="state")
    >>> observations, infos = envs.reset(seed=0)
    >>> observations.shape
    (2, 12)
    >>> envs.close()
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
        num_envs = env_count(num_envs)
        settings = checked(env_class(entry_point).options_type, options)
        self.num_envs, self.render_mode = num_envs, settings.render_mode
        self.single_observation_space, self.single_action_space = observed, acted = spaces_of(settings)
        self.observation_space, self.action_space = batch_space(observed, num_envs), batch_space(acted, num_envs)
        self._mode, limit = autoreset(autoreset_mode), step_limit(max_episode_steps)
        self._begun = np.zeros(num_envs, np.bool_)
        number = worker_count(workers, num_envs)
        self._tasks = [
            Task(entry_point, first, count, num_envs, limit, self._mode)
            for first, count in shares(num_envs, max(number, 1))
        ]
        self._processes = (
            InProcess(self._tasks[0], options, observed, acted)
            if number == 0
            else Processes(self._tasks, options, observed, acted)
        )
        self.metadata = {**self._processes.metadata, "autoreset_mode": self._mode}
        # At exit processes must be ended; an OpenGL context in this process is gone by then.
        weakref.finalize(self, self._processes.close).atexit = number != 0

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode in every env, or in some.

        Parameters
        ----------
        seed
            An integer seeds env i with seed + i. A sequence has a seed, or ``None``, for each env.
        options
            ``reset_mask``, (num_envs,) bool: the envs to reset. All other entries are options of a single env's
            reset, and hold for each env that is reset now. Episodes that autoreset begins later have none.

        Returns
        -------
        observations : ndarray or dict of str to ndarray
            (num_envs, ...), or a dict of such arrays.
        infos : dict
            For each key an array, and a mask ``_key`` of the envs that have it.

        Raises
        ------
        ValueError
            For a seed or option that is not legal. Everything stays open.
        gymnasium.error.ResetNeeded
            For a mask at the first reset.
        gymnasium.error.ClosedEnvironmentError
            After ``close()``.
        """
        self._check_open()
        rest = reset_entries(options)
        chosen = reset_mask(rest.pop("reset_mask", None), self.num_envs)
        if rest:
            self.call("check_reset_options", rest)
        seeds = reset_seeds(seed, self.num_envs)
        if not (self._begun | chosen).all():
            raise error.ResetNeeded("the first reset must be of all envs: without a reset_mask")
        tables = self._ask("reset", [(seeds[task.rows], chosen[task.rows].tolist(), rest) for task in self._tasks])
        self._begun[:] = True
        return self._processes.buffers.copy_observations(), merge_infos(tables, self.num_envs)

    def step(self, actions: Any) -> tuple[Any, Floats, Flags, Flags, dict[str, Any]]:
        """Step every env.

        Parameters
        ----------
        actions
            One action for each env.

        Returns
        -------
        observations : ndarray or dict of str to ndarray
            (num_envs, ...), or a dict of such arrays.
        rewards : ndarray
            (num_envs,) float64.
        terminated, truncated : ndarray
            (num_envs,) bool.
        infos : dict
            As of `reset`.

        Raises
        ------
        gymnasium.error.InvalidAction
            If an action is not legal. The message names the env; none has moved.
        gymnasium.error.ResetNeeded
            Before the first reset, and with autoreset disabled after an end.
        gymnasium.error.ClosedEnvironmentError
            After ``close()``.
        """
        self._check_open()
        if not self._begun.all():
            raise error.ResetNeeded("step() before reset(): call reset() first")
        buffers = self._processes.buffers
        ended = buffers.terminated | buffers.truncated
        if self._mode is AutoresetMode.DISABLED and ended.any():
            raise error.ResetNeeded(f"envs {np.flatnonzero(ended).tolist()} have ended: reset them with a reset_mask")
        buffers.actions[:] = batch_of(self.single_action_space, actions, self.num_envs)
        infos = merge_infos(self._ask("step"), self.num_envs)
        rewards, terminated, truncated = buffers.rewards.copy(), buffers.terminated.copy(), buffers.truncated.copy()
        return buffers.copy_observations(), rewards, terminated, truncated, infos

    def render(self) -> tuple[Any, ...] | None:
        """Show every env.

        Returns
        -------
        tuple or None
            The return value of each env's ``render()``: with ``render_mode="rgb_array"`` a picture (H, W, 3) uint8.
            ``None`` without a ``render_mode``.

        Raises
        ------
        gymnasium.error.ResetNeeded
            Before the first reset.
        gymnasium.error.ClosedEnvironmentError
            After ``close()``.
        """
        self._check_open()
        if self.render_mode is None:
            gym.logger.warn("render() without a render_mode: give one to gym.make_vec, for example 'rgb_array'")
            return None
        if not self._begun.all():
            raise error.ResetNeeded("render() before reset(): call reset() first")
        return tuple(self._ask("render"))

    def close_extras(self, **kwargs: Any) -> None:
        """End the processes, or close the envs in this one; Gymnasium's ``close()`` calls this.

        Parameters
        ----------
        **kwargs
            What ``close()`` was given; it is not used.
        """
        self._processes.close()

    def _ask(self, method: str, arguments: Sequence[tuple[Any, ...]] | None = None) -> list[Any]:
        try:
            return [part for answer in self._processes.ask(method, arguments) for part in answer]
        except BaseException:  # Ctrl-C too: a late answer would be taken for that to the next request
            self.close()
            raise
