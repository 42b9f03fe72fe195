"""Episodes of behaviours in envs: played, kept frame by frame, tabulated and recorded."""

import math
import os
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt
import polars as pl

import colias_sim  # noqa: F401  (registers the envs)
from colias_sim.config import SceneConfig
from colias_sim.envs import ENVS, NEURAL, State
from colias_sim.envs.base import ColiasEnv
from colias_sim.envs.options import FPS
from colias_sim.envs.senses import Model, Response, build_model
from colias_sim.events import Events
from colias_sim.simulation import TRIAL_ROBOTS
from dsnn import ResponseSeries
from dsnn.model import CHANNELS, SPIKING
from experiments.base.errors import UsageError, check_known
from experiments.base.files import Files
from experiments.base.streams import stream
from experiments.declare.behaviour import Behaviour, Policy
from experiments.settings.models import CONTROL
from experiments.show import record as rerun
from experiments.show.play import FIELDS, FRAMES, NO_IMAGE, Trial
from experiments.store.tables import JOB, OBSERVER

COLUMNS = {name: ends for env in ENVS.values() for name, ends in env.columns.items()}
"""Every column that an env declares -> its least and largest possible value."""

EPISODES = pl.Schema(
    {
        **JOB, "robot": str, "env": str, "frames": int, "seconds": float, "touched": bool, "driven_m": float,
        "reward": float, **dict.fromkeys(COLUMNS, float),
    }
)  # fmt: skip
"""Columns of ``trials.parquet``: a row per episode, ``model`` being the behaviour. Null where an env has no such."""
STEPS = FRAMES | pl.Schema(
    {"robot": str}
    | dict.fromkeys(("time_s", "x_cm", "y_cm", "heading_deg", "left_wheel", "right_wheel", "reward"), float)
)
"""Columns of ``frames.parquet``: a row per frame of an episode; responses are null where nothing is seen."""
WHEELS = "world/observer/wheels"
FROZEN = f"{CONTROL}frozen"
"""End of the name of a behaviour that plays with a `FrozenView`."""

Place = tuple[float, float, float]
"""x and y in cm, heading in degrees."""


class EpisodeTrial(Trial):
    """An episode. Its condition is a behaviour's name or the absolute path of a file, its model what that sees by."""

    def label(self) -> str:
        """Return the behaviour's name or path."""
        return str(self.condition)

    @property
    def fps(self) -> float:
        """The env's frame rate, 1/s."""
        return FPS


def short_name(env: str) -> str:
    """Return an env's id without its package: ``Avoidance-v0``."""
    return env.partition("/")[2]


def env_id(name: str) -> str:
    """Find the registered env's id of ``Avoidance``, ``Avoidance-v0`` or the id itself; `UsageError` otherwise."""
    ids = {form: env for env in ENVS for form in (short_name(env).partition("-")[0], short_name(env), env)}
    check_known("--env", name, ids)
    return ids[name]


# --- what a reflex sees and does --------------------------------------------------------------------------------------


def response(observation: npt.NDArray[np.float32], channels: Sequence[str] = CHANNELS) -> Any:
    """Return the `Response` that a neural observation (7,) is of, by a model that declares these channels.

    To read a channel that the model does not declare is an ``AttributeError``.
    """
    values = dict(zip(NEURAL, observation.tolist(), strict=True))
    values |= {name: int(value) for name, value in values.items() if name.endswith("_spikes")}
    spikes = (f"{channel}_spikes" for channel in channels if channel in SPIKING)
    return SimpleNamespace(maps=None, **{name: values[name] for name in (*channels, *spikes) if name in values})


def wheels(policy: Policy, seen: Any) -> npt.NDArray[np.float32]:
    """Return what a policy makes of what is sensed: the wheels' speeds, (2,), left and right, shares of the maximum."""
    return np.clip(np.asarray(policy(seen), np.float32), -1.0, 1.0)


# --- playing ----------------------------------------------------------------------------------------------------------


class Episode:
    """What happens in an env, kept after each step, whoever drives it.

    Parameters
    ----------
    env
        The env, which is reset.
    name
        Who drives.
    seed
        That of the reset; ``None``: its draws went on from the episode before.
    images
        Whether what the robot sees is kept.

    Attributes
    ----------
    touched
        Whether it ended by touching something, or by its time; ``None`` where it was left before its end.
    poses
        Robot -> its places; the observer first.
    wheels, rewards, responses, images, events
        Of each step: left and right as shares of the maximum; the vision model's responses and what it saw, if any.
    infos
        Numeric entry of ``info`` -> its values.
    """

    def __init__(self, env: ColiasEnv[Any], name: str, seed: int | None, *, images: bool = False) -> None:
        assert env.spec is not None
        self._env, self.name, self.seed, self.env_id = env, name, seed, env.spec.id
        self.obstacles, self.camera, self.robot = env.obstacles, env.options.camera, env.options.robot
        self._images = images and env.options.observation != "state"
        self.touched: bool | None = None
        self.poses: dict[str, list[Place]] = {robot: [] for robot in env.poses}
        self.wheels: list[npt.NDArray[np.float32]] = []
        self.rewards: list[float] = []
        self.responses: list[Any] = []
        self.images: list[npt.NDArray[np.uint8]] = []
        self.events: list[Events] = []
        self.infos: dict[str, list[float]] = {}

    def add(self, reward: float, info: Mapping[str, Any]) -> None:
        """Keep what is so after a step."""
        env = self._env
        for name, pose in env.poses.items():
            self.poses[name].append((100 * pose.x, 100 * pose.y, math.degrees(pose.heading)))
        self.wheels.append(env.wheels)
        self.rewards.append(reward)
        if env.response is not None:
            self.responses.append(env.response)
        if self._images:
            self.images.append(env.luma)
            self.events.append(env.events)
        for name, value in info.items():
            self.infos.setdefault(name, []).append(float(value))

    @property
    def time_s(self) -> npt.NDArray[np.float64]:
        """Time of each step's last frame, s, (T,)."""
        interval_s: float = self._env.options.frames_per_step / FPS
        return interval_s * np.arange(1.0, len(self.rewards) + 1.0)

    @property
    def model(self) -> rerun.RecordedModel:
        """The vision model as recordings have it, where there are responses."""
        model: Any = self._env.model
        return rerun.RecordedModel(model.name, tuple(model.channels), tuple(model.thresholds.items()))

    def row(self) -> dict[str, Any]:
        """Return the episode as a row of `EPISODES`, without its number."""
        infos = {name: np.array(values) for name, values in self.infos.items()}
        return {
            "experiment": "behave", "seed": self.seed, "model": self.name, "robot": OBSERVER, "env": self.env_id,
            "frames": len(self.rewards), "seconds": float(self.time_s[-1]), "touched": self.touched,
            "driven_m": float(infos["driven_cm"].sum()) / 100, "reward": float(np.array(self.rewards).sum()),
            **dict.fromkeys(COLUMNS), **self._env.measured(infos),
        }  # fmt: skip

    def steps(self, index: int) -> pl.DataFrame:
        """Return the steps of episode ``index`` of a run as rows of `STEPS`."""
        (x_cm, y_cm, heading_deg), (left, right) = np.array(next(iter(self.poses.values()))).T, np.array(self.wheels).T
        series = ResponseSeries.from_responses(self.responses) if self.responses else None
        return pl.DataFrame(
            {
                "trial": index, "model": self.name, "frame": range(len(self.rewards)), "robot": OBSERVER,
                "time_s": self.time_s, "x_cm": x_cm, "y_cm": y_cm, "heading_deg": heading_deg, "left_wheel": left,
                "right_wheel": right, "reward": self.rewards,
                **{name: getattr(series, name, None) for name in FIELDS},
            }
        ).select(STEPS.names()).cast(STEPS)  # fmt: skip


class FrozenView:
    """A vision model (see `colias_sim.envs.senses.Model`) that is shown its first frame throughout."""

    def __init__(self, model: Model) -> None:
        self._model, self._first = model, NO_IMAGE

    def step(self, frame: npt.NDArray[np.uint8]) -> Response:
        """Answer the first frame (R, C) once more."""
        self._first = self._first if self._first.size else frame
        return self._model.step(self._first)

    def reset(self) -> None:
        """Forget every frame."""
        self._model.reset()
        self._first = NO_IMAGE


def play(
    behaviour: Behaviour,
    env: str,
    options: Mapping[str, Any],
    seed: int,
    steps: int | None = None,
    *,
    images: bool = False,
    frozen: bool = False,
) -> Episode:
    """Play an episode of a behaviour in an env, to its end or for ``steps``; ``frozen`` shows its model one frame.

    Raises ``ValueError`` on options that are not legal, and what the behaviour raises.
    """
    options = {**options, "observation": behaviour.senses}
    if behaviour.senses == "neural":
        model = options.setdefault("model", behaviour.model)
        options["model"] = (lambda shape: FrozenView(build_model(model, shape))) if frozen else model
    # The world's draws come from the seed alone, so that behaviours meet the same worlds; these are its own.
    policy, neural = behaviour.make(stream("policy", seed)), behaviour.senses == "neural"
    with closing(gym.make(env, max_episode_steps=steps or ENVS[env].max_episode_steps, **options)) as wrapped:
        inner: Any = wrapped.unwrapped
        observation, _ = wrapped.reset(seed=seed)
        full_turn = inner.options.robot.full_turn
        name = behaviour.name + FROZEN * frozen
        episode, over = Episode(inner, name, seed, images=images), False
        while not over:
            seen = response(observation, inner.model.channels) if neural else State.read(observation, full_turn)
            observation, reward, touched, truncated, info = wrapped.step(wheels(policy, seen))
            episode.add(float(reward), info)
            episode.touched, over = touched, touched or truncated
        return episode


# --- recording --------------------------------------------------------------------------------------------------------


def record(episode: Episode, title: str = "") -> bytes:
    """Return the recording of an episode of one step or more, as the bytes of an .rrd file. Frames are JPEG.

    An episode with a ``title`` cannot be played again by its behaviour's name and its seed, so it is like no other.
    """
    name, env = episode.name, short_name(episode.env_id)
    outcome = {
        "behaviour": name, "env": episode.env_id,
        "reset seed": "none" if episode.seed is None else str(episode.seed),  # which may be any whole number
        "ended by": {True: "touched something", False: "time", None: "left"}[episode.touched],
        "return": float(np.array(episode.rewards).sum()),
    }  # fmt: skip
    of_top = f"wheels, shares of {episode.robot.max_speed_cm_s:g} cm/s"
    headings: list[tuple[str, tuple[str, ...], str]] = [(WHEELS, ("left", "right"), of_top)]
    plots = {WHEELS: np.array(episode.wheels)}
    if terms := [name for name in episode.infos if name.startswith("reward_")]:
        headings.append(("reward", tuple(term.removeprefix("reward_") for term in terms), "terms of the reward"))
        plots["reward"] = np.column_stack([episode.infos[term] for term in terms])
    model = episode.model if episode.responses else None
    responses = {model.label: ResponseSeries.from_responses(episode.responses)} if model else {}
    camera = episode.camera if episode.images else None
    content = rerun.Content(
        models=(model,) if model else (), eyes=("",) if camera else (), camera=camera, scene=SceneConfig(),
        robots=tuple((robot, _variant(robot)) for robot in episode.poses), above=True, plots=tuple(headings),
        obstacles=rerun.outlines(episode.obstacles),
    )  # fmt: skip
    frames = rerun.Frames(
        episode.time_s, np.arange(len(episode.rewards)), responses,
        {"": rerun.jpegs(episode.images)} if camera else {},
        {robot: np.array(way) for robot, way in episode.poses.items()}, plots=plots,
        events={"": episode.events},
    )  # fmt: skip
    identity = None if title else f"{name}-{env}-{episode.seed}"
    title = title or f"{name} in {env}, seed {episode.seed}"
    held, about = {"episode": rerun.properties(outcome)}, rerun.note(outcome)
    return rerun.write(content, frames, title, identity, held, about=about)


def _variant(robot: str) -> str:
    """Return what a robot of an env looks like."""
    return "colias_parked" if robot.startswith("parked") else TRIAL_ROBOTS.get(robot, TRIAL_ROBOTS["stimulus"])


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
        each episode is, in a file with its number, from 0. Other braces stay as they are. A file that is there is
        replaced.
    episode_trigger
        Says of an episode's number whether it is recorded, as that of Gymnasium's ``RecordVideo`` does.

    Attributes
    ----------
    recorded
        The files that were written, in order.

    Raises
    ------
    UsageError
        The env is none of colias_sim's. It is a ``ValueError``.

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
            raise UsageError(f"RecordRerun: {type(inner).__name__} is no env of colias_sim")
        super().__init__(env)
        self._inner, self._path = inner, str(path)
        self._several = self._place(0) != self._place(1)
        self._trigger = episode_trigger or (lambda number: self._several or number == 0)
        self._number = -1
        self._episode: Episode | None = None
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
        self._write()
        begun = self.env.reset(seed=seed, options=options)
        self._number += 1
        if self._trigger(self._number):
            self._episode = Episode(self._inner, "agent", seed, images=True)
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
        if self._episode is not None:
            terms = {name: value for name, value in info.items() if name.startswith("reward_")}
            self._episode.add(float(reward), terms)
            if terminated or truncated:
                self._episode.touched = terminated
                self._write()
        return taken

    def close(self) -> None:
        """Write what an episode has that did not end, and close the env.

        Raises
        ------
        OSError
            The recording cannot be written.
        """
        self._write()
        self.env.close()

    def _place(self, number: int) -> Path:
        return Path(re.sub(r"\{episode(?::(.*?))?\}", lambda found: format(number, found[1] or ""), self._path))

    def _write(self) -> None:
        episode, self._episode = self._episode, None
        if episode is None or not episode.rewards:
            return
        data = record(episode, f"episode {self._number} in {short_name(episode.env_id)}")
        place = self._place(self._number)
        place.parent.mkdir(parents=True, exist_ok=True)
        Files(place.parent).write_bytes(place, data)
        self.recorded.append(place)
