"""One episode of a behaviour in an env: played, and kept frame by frame. An episode is a pure function of its spec."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt

import colias_sim  # noqa: F401  (registers the envs)
from colias_sim import Pose
from colias_sim.envs import ENVS, State
from colias_sim.envs.base import ColiasEnv
from colias_sim.envs.options import FPS, EnvOptions
from dsnn import ResponseSeries
from dsnn.model import CHANNELS
from experiments.bench.closed_loop.behaviour import Behaviour, Policy
from experiments.bench.closed_loop.find import load_behaviour
from experiments.bench.closed_loop.seen import response
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import ConfiguredModel, choose
from experiments.bench.run.streams import stream

if TYPE_CHECKING:
    from colias_sim.obstacles import Obstacle

Floats = npt.NDArray[np.float64]
Agent = Callable[[Any], Any]
"""Agent that may drive an env: observation in, action out."""


@dataclass(frozen=True, slots=True)
class Setting:
    """Setting of an episode: who behaves, where, and what of the env is changed."""

    behaviour: str
    """A registered name, or the absolute path of a .py file."""
    env: str
    options: tuple[tuple[str, Any], ...] = ()
    steps: int | None = None
    """Number of frames after which the episode is over; otherwise the env's own number."""

    def label(self) -> str:
        """Return a label for people."""
        changed = "".join(f", {name}={value}" for name, value in self.options)
        return f"{self.behaviour} in {self.env.partition('/')[2]}{changed}"


@dataclass(frozen=True, slots=True)
class EpisodeSpec:
    """An episode: its number in the run and among those of equal setting, and the seed of all its draws."""

    index: int
    repeat: int
    seed: int
    condition: Setting

    def frame_rates(self) -> Iterable[tuple[ConfiguredModel, float]]:
        """Return its behaviour's vision model with the env's frame rate, 1/s; nothing where it senses the state."""
        behaviour = load_behaviour(self.condition.behaviour)
        return ((choose(behaviour.model), FPS),) if behaviour.senses == "neural" else ()


@dataclass(frozen=True, slots=True)
class Episode:
    """Record of an episode, a value per frame: (T,) each, but ``frames`` (T, R, C) uint8, empty where nothing was
    seen.
    """

    name: str
    env: str
    options: EnvOptions
    """The env's arguments."""
    seed: int | None
    """``None`` where the env was reset without one: its draws went on from the episode before."""
    touched: bool | None
    """Whether it ended by touching something, or by its time; ``None`` where it was left before its end."""
    time_s: Floats
    paths: Mapping[str, Floats]
    """Robot -> (T, 3): x and y in cm, heading in degrees; the observer first."""
    wheels: npt.NDArray[np.float32]
    """(T, 2): left and right, shares of the maximum."""
    model: str
    """The vision model's name; empty where nothing was seen."""
    channels: tuple[str, ...]
    """Channels that the vision model declares."""
    series: ResponseSeries | None
    rewards: Floats
    infos: Mapping[str, Floats]
    """Each numeric entry of ``info``."""
    frames: npt.NDArray[np.uint8]
    obstacles: tuple[Obstacle, ...] = ()
    """What stands in the arena."""
    thresholds: Mapping[str, float | None] = field(default_factory=dict)
    """Spiking threshold of each channel of the vision model, if it has one."""

    @property
    def steps(self) -> int:
        """Tell how many."""
        return len(self.rewards)


def play_behaviour(spec: EpisodeSpec, *, images: bool) -> Episode:
    """Return the episode of a spec."""
    setting = spec.condition
    return play_entry(
        load_behaviour(setting.behaviour), setting.env, dict(setting.options), spec.seed, setting.steps, images
    )


def play_entry(
    entry: Behaviour, env: str, options: Mapping[str, Any], seed: int, steps: int | None = None, images: bool = False
) -> Episode:
    """Return one episode of a behaviour in an env, to its end or for ``steps``.

    Raises ``ValueError`` on options that are not legal, and what the behaviour raises.
    """
    options = {**options, "observation": entry.senses}
    if entry.senses == "neural":
        options.setdefault("model", entry.model)
    # The world's draws come from the seed alone, so that behaviours meet the same worlds; these are its own.
    policy = entry.make(stream("policy", seed))
    steps = steps or ENVS[env].max_episode_steps
    with closing(gym.make(env, max_episode_steps=steps, **options)) as wrapped:
        opened = wrapped.unwrapped
        assert isinstance(opened, ColiasEnv) and wrapped.spec is not None
        act = agent(policy, entry.senses, opened.model)
        observation, _ = wrapped.reset(seed=seed)
        keep = EpisodeKeeper(opened, images)
        over = touched = False
        while not over:
            observation, reward, touched, truncated, info = wrapped.step(act(observation))
            keep.step(float(reward), info)
            over = touched or truncated
        return keep.episode(entry.name, wrapped.spec.id, seed, touched)


def start_places(env: str, options: Mapping[str, Any], seed: int) -> dict[str, tuple[float, float, float]]:
    """Return where every robot of an env stands at the start of an episode: its name -> x and y in cm, heading in deg.

    The world's draws come from the seed alone, so that these are the places of whatever behaviour plays there.
    """
    env_of_states = gym.make(env, **{**options, "observation": "state"})
    try:
        env_of_states.reset(seed=seed)
        assert isinstance(env_of_states.unwrapped, ColiasEnv)
        return {name: _readable(pose) for name, pose in env_of_states.unwrapped.poses.items()}
    finally:
        env_of_states.close()


def agent(policy: Policy, senses: str, model: Any = None) -> Agent:
    """Return a policy over a `Response`, by the env's vision ``model``, or a `State`: an agent over observations."""
    channels, name = getattr(model, "channels", CHANNELS), getattr(model, "name", "the model")

    def act(observation: Any) -> npt.NDArray[np.float32]:
        seen = response(observation, channels, name) if senses == "neural" else State.read(observation)
        return wheels(policy, seen)

    return act


def wheels(policy: Policy, seen: Any) -> npt.NDArray[np.float32]:
    """Return what a policy makes of what is sensed: the wheels' speeds, (2,), left and right, shares of the maximum."""
    return np.clip(_wheels(policy(seen)), -1.0, 1.0)


def _wheels(answer: Any) -> npt.NDArray[np.float32]:
    """Return what a policy returned, as numbers; `UsageError` for what is callable: a class given as a reflex makes
    such.
    """
    if callable(answer):
        kind = getattr(answer if isinstance(answer, type) else type(answer), "__name__", "")
        instead = f"for a reflex with memory use Behaviour(..., make={kind})"
        raise UsageError(f"the reflex returned a {kind}, not two wheel speeds; {instead}")
    return np.asarray(answer, np.float32)


class EpisodeKeeper:
    """Collects an episode of an env, step by step; ``images`` says whether what the robot sees is kept."""

    def __init__(self, env: ColiasEnv[Any], images: bool) -> None:
        self._env, self._images = env, images
        self._poses: dict[str, list[tuple[float, float, float]]] = {name: [] for name in env.poses}
        self._wheels: list[npt.NDArray[np.float32]] = []
        self._answers: list[Any] = []
        self._rewards: list[float] = []
        self._infos: dict[str, list[float]] = {}
        self._frames: list[npt.NDArray[np.uint8]] = []

    @property
    def steps(self) -> int:
        """Tell how many there are so far."""
        return len(self._rewards)

    def step(self, reward: float, info: Mapping[str, Any]) -> None:
        """Keep what is so after a step."""
        for name, pose in self._env.poses.items():
            self._poses[name].append(_readable(pose))
        self._wheels.append(self._env.wheels)
        if self._env.answer is not None:
            self._answers.append(self._env.answer)
        self._rewards.append(reward)
        for name, value in info.items():
            self._infos.setdefault(name, []).append(float(value))
        if self._images and self._env.options.observation != "state":
            self._frames.append(self._env.luma)

    def episode(self, name: str, env_id: str, seed: int | None, touched: bool | None) -> Episode:
        """Return the episode so far."""
        count, interval = len(self._rewards), self._env.options.frame_skip / 30.0
        return Episode(
            name, env_id, self._env.options, seed, touched,
            time_s=interval * np.arange(1, count + 1),
            paths={name: np.array(path) for name, path in self._poses.items()},
            wheels=np.array(self._wheels, np.float32),
            model=getattr(self._env.model, "name", ""),
            channels=tuple(getattr(self._env.model, "channels", ())),
            series=ResponseSeries.from_responses(self._answers) if self._answers else None,
            rewards=np.array(self._rewards),
            infos={name: np.array(values) for name, values in self._infos.items()},
            frames=np.stack(self._frames) if self._frames else np.zeros((0, 72, 99), np.uint8),
            obstacles=self._env.obstacles,
            thresholds=dict(getattr(self._env.model, "thresholds", {})),
        )  # fmt: skip


def _readable(pose: Pose) -> tuple[float, float, float]:
    return 100 * pose.x, 100 * pose.y, float(np.degrees(pose.heading))
