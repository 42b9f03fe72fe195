"""Train a policy by stable-baselines3's PPO. With its tests the only importer of that and of PyTorch: an extra."""

from __future__ import annotations

import contextlib
import importlib.metadata
import signal
import types
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import SubprocVecEnv, VecEnv

from experiments.bench.closed_loop.policy import ROLLOUT, About, Layer, Policy
from experiments.bench.run.workers import without_interrupts
from experiments.bench.store.provenance import versions
from experiments.bench.training.env import steered

WORLDS = 2**32
"""The first seed of the worlds that are trained in; those that are judged in, ``--seed`` and up, are others."""
WORLDS_A_SEED = 2**10


@dataclass(frozen=True, slots=True)
class Learnt:
    """A policy, how the mean return grew, and whether it was stopped before its time."""

    policy: Policy
    curve: list[dict[str, float]]
    """A row per update: steps so far, episodes that ended since the last row, their mean return (NaN for none)."""
    stopped: bool


Progress = Callable[[], contextlib.AbstractContextManager[Callable[[], None]]]
"""Opens a display of progress, which is then told of each step of all envs."""


def train(about: About, progress: Progress) -> Learnt:
    """Train as ``about`` says; ``progress`` is opened as soon as the envs are there.

    Steps are rounded up to whole rollouts of `ROLLOUT` steps of every env. On one version of PyTorch, equal seeds and
    numbers of envs give equal policies. After Ctrl-C the policy is that learnt so far. Raises ``OSError`` if the
    process of an env dies.
    """
    torch.set_num_threads(1)  # the cores are the envs', and sums keep their order
    with _envs(about) as envs, _asked_to_stop() as asked, progress() as on_step:
        model = PPO(
            "MlpPolicy", envs, seed=about.seed, device="cpu", n_steps=ROLLOUT, batch_size=ROLLOUT,
            # What an action does shows within a second; rewards are about 1 a step, returns to this horizon about 20.
            gamma=0.95, gae_lambda=0.9, learning_rate=1e-3,
            policy_kwargs={"net_arch": list(about.hidden), "activation_fn": torch.nn.Tanh, "log_std_init": -0.5},
        )  # fmt: skip
        envs.seed(WORLDS + WORLDS_A_SEED * about.seed)
        watcher = _Watcher(on_step, asked)
        try:
            model.learn(about.steps, callback=watcher)
        except (EOFError, ConnectionError):
            raise OSError("the process of an env died: see above for why") from None
        return Learnt(exported(model, about), watcher.curve, asked())


def exported(model: PPO, about: About) -> Policy:
    """Return the policy of a model, as plain arrays; it is about as many steps as the model has made."""
    net = model.policy.mlp_extractor.policy_net
    linear = [*(part for part in net if isinstance(part, torch.nn.Linear)), model.policy.action_net]
    layers: list[Layer] = [(_array(part.weight), _array(part.bias)) for part in linear]
    libraries = {name: importlib.metadata.version(name) for name in ("stable-baselines3", "torch")}
    values = {name: getattr(about, name) for name in ("env", "options", "model", "seed", "envs", "hidden", "steering")}
    return Policy(About(**values, steps=model.num_timesteps, versions=versions() | libraries), layers)


def _array(tensor: torch.Tensor) -> np.ndarray[Any, np.dtype[np.float32]]:
    return np.ascontiguousarray(tensor.detach().numpy(), np.float32)


class _Watcher:
    """Callback of PPO after each step: it tells of it, collects the returns of episodes, ends the training when
    asked.
    """

    def __init__(self, on_step: Callable[[], None], asked: Callable[[], bool]) -> None:
        self._tell, self._asked = on_step, asked
        self._calls = 0
        self._returns: list[float] = []
        self.curve: list[dict[str, float]] = []

    def __call__(self, of_learn: Mapping[str, Any], of_module: Mapping[str, Any]) -> bool:
        self._tell()
        self._calls += 1
        self._returns += [info["episode"]["r"] for info in of_learn["infos"] if "episode" in info]
        if self._calls % ROLLOUT == 0:
            self._note(of_learn["self"].num_timesteps)
        return not self._asked()

    def _note(self, steps: int) -> None:
        mean = float(np.mean(self._returns)) if self._returns else float("nan")
        self.curve.append({"steps": steps, "episodes": len(self._returns), "return": mean})
        self._returns = []


@contextlib.contextmanager
def _envs(about: About) -> Iterator[VecEnv]:
    """Yield one env in this process, several in one each; their processes are gone afterwards."""
    given: dict[str, Any] = {"env_kwargs": {"about": about}}
    if about.envs > 1:
        given |= {"vec_env_cls": SubprocVecEnv, "vec_env_kwargs": {"start_method": "spawn"}}
    with without_interrupts():
        envs: VecEnv = make_vec_env(steered, about.envs, **given)
    try:
        yield envs
    except BaseException:
        # Closing in good order would wait for answers that may never come.
        for process in getattr(envs, "processes", ()):
            process.terminate()
        raise
    envs.close()


@contextlib.contextmanager
def _asked_to_stop() -> Iterator[Callable[[], bool]]:
    """Yield a function that tells whether Ctrl-C was pressed: once, and the training ends after the step; twice,
    and it is left at once.
    """
    asked = False

    def ask(number: int, frame: types.FrameType | None) -> None:
        nonlocal asked
        asked = True
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, ask)
    try:
        yield lambda: asked
    finally:
        signal.signal(signal.SIGINT, before)
