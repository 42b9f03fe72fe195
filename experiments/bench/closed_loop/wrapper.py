"""Record what an env does for Rerun, whoever drives it: a wrapper."""

from __future__ import annotations

import os
import string
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium as gym

from colias_sim.envs.base import ColiasEnv
from experiments.bench.closed_loop.episode import EpisodeKeeper
from experiments.bench.run.errors import UsageError, short
from experiments.bench.store.places import part

NUMBER = "episode"
"""The field of a path that is replaced with the number of the episode."""


class RecordRerun(gym.Wrapper[Any, Any, Any, Any], gym.utils.RecordConstructorArgs):
    """Record an env's episodes for Rerun's viewer: each is a file, written when it ends.

    A recording has what the robot sees, the arena from above with the robots' tracks, what the vision model answers,
    the wheels, and the terms of the reward. Observations, rewards and draws are those of the env without the wrapper.

    Parameters
    ----------
    env
        One of colias_sim's envs, or wrappers around one. Envs of a vector env are wrapped one by one.
    path
        The .rrd file: the first episode is recorded. With ``{episode}`` in it, such as ``"runs/{episode:03d}.rrd"``,
        each episode is, in a file with its number, from 0. A file that is there is replaced.
    episode_trigger
        Says of an episode's number whether it is recorded, as that of Gymnasium's ``RecordVideo`` does.

    Attributes
    ----------
    recorded
        The files that were written, in order.

    Raises
    ------
    UsageError
        The env is none of colias_sim's, or the path is not legal; in one line. It is a ``ValueError``.

    Examples
    --------
    >>> import gymnasium as gym
    >>> import colias_sim, experiments
    >>> env = experiments.RecordRerun(gym.make("colias_sim/Pursuit-v0", observation="neural"), "episode.rrd")
    """

    def __init__(
        self, env: gym.Env[Any, Any], path: str | os.PathLike[str],
        episode_trigger: Callable[[int], bool] | None = None,
    ) -> None:  # fmt: skip
        gym.utils.RecordConstructorArgs.__init__(self, path=path, episode_trigger=episode_trigger)
        inner = getattr(env, "unwrapped", env)
        if not isinstance(inner, ColiasEnv):
            hint = "; wrap each of its envs" if isinstance(env, gym.vector.VectorEnv) else ""
            raise UsageError(f"RecordRerun: {type(inner).__name__} is no env of colias_sim{hint}")
        super().__init__(env)
        self._inner = inner
        self._path, self._several = _checked(path)
        self._trigger = episode_trigger or (lambda number: self._several or number == 0)
        self._number = -1
        self._seed: int | None = None
        self._keep: EpisodeKeeper | None = None
        self.recorded: list[Path] = []

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; one that was begun before and has not ended is written as far as it got.

        Parameters
        ----------
        seed, options
            Those of the env.

        Returns
        -------
        observation
            The env's.
        info : dict
            The env's.

        Raises
        ------
        OSError
            The recording of the episode before cannot be written.
        """
        self._write(touched=None)
        begun = self.env.reset(seed=seed, options=options)
        self._number, self._seed = self._number + 1, seed
        self._keep = EpisodeKeeper(self._inner, images=True) if self._trigger(self._number) else None
        return begun

    def step(self, action: Any) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Take a step of the env; the last one of an episode writes its recording.

        Parameters
        ----------
        action
            An element of the env's action space.

        Returns
        -------
        observation
            The env's.
        reward
            The env's.
        terminated, truncated : bool
            The env's.
        info : dict
            The env's.

        Raises
        ------
        OSError
            The recording cannot be written.
        """
        taken = self.env.step(action)
        _, reward, terminated, truncated, info = taken
        if self._keep is not None:
            terms = {name: value for name, value in info.items() if name.startswith("reward_")}
            self._keep.step(float(reward), terms)
            if terminated or truncated:
                self._write(touched=terminated)
        return taken

    def close(self) -> None:
        """Write what an episode has that did not end, and close the env.

        Raises
        ------
        OSError
            The recording cannot be written; the env is closed.
        """
        try:
            self._write(touched=None)
        finally:
            self.env.close()

    def _write(self, *, touched: bool | None) -> None:
        keep, self._keep = self._keep, None
        if keep is None or not keep.steps:
            return
        from experiments.bench.closed_loop.recording import record  # not before: Rerun takes its time to load

        assert self._inner.spec is not None
        episode = keep.episode("agent", self._inner.spec.id, self._seed, touched)
        data = record(episode, f"episode {self._number} in {episode.env.partition('/')[2]}")
        place = Path(self._path.format(**{NUMBER: self._number}) if self._several else self._path)
        place.parent.mkdir(parents=True, exist_ok=True)
        whole = part(place)
        whole.write_bytes(data)
        whole.replace(place)
        self.recorded.append(place)


def _checked(path: Any) -> tuple[str, bool]:
    """Return a path, and whether it has a place for the number of the episode; `UsageError` where it is not legal."""
    text, fields = os.fspath(path) if isinstance(path, str | os.PathLike) else path, []
    legal = f"RecordRerun: {short(path)}: legal is a path that ends in .rrd, with {{{NUMBER}}} in it for each episode"
    if not isinstance(text, str) or not text.endswith(".rrd"):
        raise UsageError(legal)
    try:
        fields = [name for _, name, _, _ in string.Formatter().parse(text) if name is not None]
        text.format(**{NUMBER: 0})
    except (KeyError, IndexError, ValueError, AttributeError):
        raise UsageError(legal) from None
    return text, bool(fields)
