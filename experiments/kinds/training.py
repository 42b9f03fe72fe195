"""Train policies by stable-baselines3's PPO at one training seed or several, and judge them together.

That library and PyTorch are an extra, which is imported when a policy is trained.
"""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import gymnasium as gym
import numpy as np
import numpy.typing as npt
import polars as pl
from gymnasium import spaces
from threadpoolctl import threadpool_limits

import colias_sim  # noqa: F401  (registers the envs)
from colias_sim.reference import reference_hash
from experiments.base import interrupts
from experiments.base.console import count, progress, show_files
from experiments.base.errors import UsageError
from experiments.base.files import Files
from experiments.base.streams import stream
from experiments.declare.behaviour import (
    ENDING,
    FIXATION,
    OPTOMOTOR,
    TRAINED_UNDER,
    WHEELS,
    TrainedPolicy,
    Vector,
    load_policy,
    sense,
    steer,
)
from experiments.draw import behaviours
from experiments.judge.scores import SUMMARY
from experiments.judge.tests import Score
from experiments.kinds import episodes
from experiments.kinds.result import Kind, Run, load
from experiments.settings.settings import check_counts
from experiments.show.episodes import env_id, short_name
from experiments.show.play import one_thread
from experiments.store.asked import Asked
from experiments.store.folder import begun
from experiments.store.plan import Plan, filled
from experiments.store.provenance import versions
from experiments.store.workers import Workers, starting

if TYPE_CHECKING:
    from stable_baselines3 import PPO

OPPONENTS: Mapping[str, tuple[str, ...]] = {
    FIXATION: ("fixation-pi", "fixation", "still", "random", "oracle-target"),
    OPTOMOTOR: ("optomotor-pi", "optomotor", "still", "random", "oracle-heading"),
}
"""Env -> what a policy is compared with: the PI reflex, which steers as it does, the plain one, rest, chance, truth."""
JUDGED = 20
"""Episodes that a policy and each of its opponents are judged by, in worlds that none was trained in."""
ROLLOUT = 256
"""Steps of each env between two updates of a network in training, and the size of a minibatch."""
STEPS = 40_960
"""Steps of all envs together, where none are asked for."""
WORLDS, WORLDS_A_SEED = 2**32, 2**10
"""The first seed of the worlds that are trained in, and their number for each training seed."""
CUT, RESAMPLES = 0.25, 50_000
"""Share of the scores that is left out at either end, and resamples of the bootstrap."""
TRAINED = "PPO"
"""Name of the policies of several training seeds together."""
OF_SEEDS = f"{TRAINED}: interquartile mean over training seeds with its interval over these; fewer than 10 are few."


# --- one training -----------------------------------------------------------------------------------------------------


class Steered(gym.Wrapper[Vector, Vector, Vector, Vector]):
    """Actions add to the wheels' commands, as `steer` says, and observations end with these."""

    def __init__(self, env: gym.Env[Any, Any]) -> None:
        super().__init__(env)
        self._command = np.zeros(WHEELS, np.float32)
        inner: Any = env.observation_space
        ones = np.ones(WHEELS, np.float32)
        self.observation_space = spaces.Box(np.concatenate([inner.low, -ones]), np.concatenate([inner.high, ones]))
        self.action_space = spaces.Box(-1.0, 1.0, (WHEELS,), np.float32)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Vector, dict[str, Any]]:
        """Begin an episode, the wheels at rest."""
        observation, info = self.env.reset(seed=seed, options=options)
        self._command = np.zeros(WHEELS, np.float32)
        return sense(observation, self._command), info

    def step(self, action: Vector) -> tuple[Vector, Any, bool, bool, dict[str, Any]]:
        """Move the wheels' commands by ``action``, and the robot by them."""
        self._command = steer(self._command, action)
        observation, reward, terminated, truncated, info = self.env.step(self._command)
        return sense(observation, self._command), reward, terminated, truncated, info


def steered(policy: TrainedPolicy) -> Steered:
    """Return a new env of the kind that a policy is for, with this process kept to one thread."""
    cv2.setNumThreads(1)
    threadpool_limits(1)
    return Steered(gym.make(policy.env, observation="neural", model=policy.model, **policy.options))


def train(policy: TrainedPolicy, advance: Callable[[], None]) -> tuple[TrainedPolicy, pl.DataFrame]:
    """Train a policy.

    Parameters
    ----------
    policy
        What it is for, without layers. Steps are rounded up to whole rollouts of `ROLLOUT` steps of every env.
    advance
        Called after each step of all envs.

    Returns
    -------
    TrainedPolicy
        The policy with its layers. On one version of PyTorch, equal seeds and numbers of envs give equal ones.
    polars.DataFrame
        A row per update: ``steps`` so far, ``episodes`` that ended since the row before, and their mean ``return``.
    """
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.env_util import make_vec_env
    from stable_baselines3.common.vec_env import SubprocVecEnv

    torch.set_num_threads(1)  # the cores are the envs', and sums keep their order
    returns: list[float] = []
    curve: list[dict[str, float | None]] = []

    def after_step(of_learn: Mapping[str, Any], of_module: Mapping[str, Any]) -> bool:
        advance()
        returns.extend(info["episode"]["r"] for info in of_learn["infos"] if "episode" in info)
        steps = of_learn["self"].num_timesteps
        if steps % (ROLLOUT * policy.envs) == 0:
            mean = float(np.mean(returns)) if returns else None
            curve.append({"steps": steps, "episodes": len(returns), "return": mean})
            returns.clear()
        return True

    processes: dict[str, Any] = {"vec_env_cls": SubprocVecEnv, "vec_env_kwargs": {"start_method": "spawn"}}
    with starting():
        envs = make_vec_env(
            steered, policy.envs, env_kwargs={"policy": policy}, **(processes if policy.envs > 1 else {})
        )
    model = PPO(
        "MlpPolicy", envs, seed=policy.seed, device="cpu", n_steps=ROLLOUT, batch_size=ROLLOUT,
        # What an action does shows within a second; rewards are about 1 a step, returns to this horizon about 20.
        gamma=0.95, gae_lambda=0.9, learning_rate=1e-3,
        policy_kwargs={"net_arch": list(policy.hidden), "activation_fn": torch.nn.Tanh, "log_std_init": -0.5},
    )  # fmt: skip
    envs.seed(WORLDS + WORLDS_A_SEED * policy.seed)
    model.learn(policy.steps, callback=after_step)
    envs.close()  # after an error its processes, which are daemons, end with this one
    return exported(model, policy), pl.DataFrame(curve, infer_schema_length=None)


def exported(model: PPO, policy: TrainedPolicy) -> TrainedPolicy:
    """Return a policy with the layers of a model, as plain arrays, and as many steps as that has made."""
    import torch

    parts = [*model.policy.mlp_extractor.policy_net, model.policy.action_net]
    layers = [
        (np.ascontiguousarray(part.weight.detach().numpy(), np.float32),
         np.ascontiguousarray(part.bias.detach().numpy(), np.float32))
        for part in parts if isinstance(part, torch.nn.Linear)
    ]  # fmt: skip
    libraries = {name: importlib.metadata.version(name) for name in ("stable-baselines3", "torch")}
    return replace(policy, steps=model.num_timesteps, versions=versions() | libraries, layers=layers)


# --- several training seeds -------------------------------------------------------------------------------------------


def plan(asked: Asked) -> Plan[Any]:
    """Return the plan of a training: the policies, their steps rounded up as PPO does.

    Parameters
    ----------
    asked
        What was asked for: the env, and its arguments as values. Its options are ``steps``, ``envs`` and ``seeds``, the
        number of training seeds from the seed of the run up.

    Raises
    ------
    UsageError
        It cannot be trained so.
    """
    seeds, envs = asked.option("seeds", 1), asked.option("envs", 8)
    check_counts(asked.seed, seeds, "--seeds")
    where = env_id(asked.what[0])
    if where not in OPPONENTS:
        raise UsageError(f"--env {asked.what[0]}: a policy learns Optomotor or Fixation")
    for key, value in asked.values.items():
        if key.partition(".")[0] not in TRAINED_UNDER:
            raise UsageError(f"--set {key}={value}: a training may change {', '.join(TRAINED_UNDER)}")
    options, rollout = episodes.env_options(where, asked.values), ROLLOUT * envs
    whole = -(-asked.option("steps", STEPS) // rollout) * rollout
    policies = tuple(
        TrainedPolicy(where, one, whole, envs, options=options) for one in range(asked.seed, asked.seed + seeds)
    )
    return Plan(asked, "train", declared=policies)


def work(plan: Plan[Any], out: Path, pool: Workers) -> None:
    """Train the policies that a folder lacks, then judge all and their opponents in worlds that none was trained in.

    Eye, wheels and randomisation are those of the training. Of several training seeds `together` is written to
    ``policies.csv``.

    Raises
    ------
    UsageError
        The folder has policies of another training.
    ImportError
        The extra is not installed.
    """
    policies: Sequence[TrainedPolicy] = plan.declared
    files, first = [out / f"policy-{policy.seed}{ENDING}" for policy in policies], policies[0]
    missing = []
    for policy, file in zip(policies, files, strict=True):
        if not file.exists():
            missing.append((policy, file))
        elif replace(load_policy(file), versions={}) != policy:
            raise UsageError(f"{file}: it is of another training; choose another --out")
    if missing:
        if begun(out):
            raise UsageError(f"--out {out}: its policies are judged already; choose another")
        require_training()
    for policy, file in missing:
        name, rounds = f"training seed {policy.seed}", policy.steps // policy.envs
        with interrupts.once(), one_thread(), progress(name, rounds, pool.quiet, "steps of each env") as advance:
            trained, curve = train(policy, advance)
            out.mkdir(parents=True, exist_ok=True)
            Files(out).write_text(f"learning-{policy.seed}.csv", curve.write_csv())
            trained.save(file)
    judged = _judging(plan, files)
    with pool.running(), filled(judged, out, pool) as folder:
        episodes.conclude(judged, folder)
    report = load(out)
    if len(policies) > 1 and report.done:
        table = together(report.summary, pl.col("behaviour").is_in([file.stem for file in files]), first.seed)
        Files(out).write_rows("policies.csv", table.to_dicts())


def _judging(plan: Plan[Any], files: Sequence[Path]) -> Plan[Any]:
    """Return the plan of the episodes that judge policies, which is that of the training's folder."""
    first = plan.declared[0]
    asked = Asked(
        kind="episodes", what=(*(str(file.resolve()) for file in files), *OPPONENTS[first.env]), values=first.options,
        repeats=JUDGED, options={"env": first.env, "baselines": False},
    )  # fmt: skip
    judged = episodes.plan(asked)
    trained = {"seeds": len(plan.declared), "steps": first.steps, "envs": first.envs}
    return replace(judged, asked=plan.asked, resolved={**judged.resolved, "training": trained})


def show(run: Run) -> None:
    """Print what policies and their opponents did; of several training seeds the policies in one row."""
    if not run.done:
        return
    trained = run.description["training"]
    seeds = count(trained["seeds"], "training seed")
    title = f"{short_name(run.description['env'])}: {seeds} of {trained['steps']:,} steps, {JUDGED} episodes each"
    several = (run.folder / "policies.csv").is_file()
    table = pl.read_csv(run.folder / "policies.csv", schema=SUMMARY) if several else run.summary
    behaviours.show(table, f"{title}. {OF_SEEDS}" if several else title)
    show_files(run.folder, seeds)


def require_training() -> None:
    """Load what a training needs; `ImportError` without the extra, `GLUnavailable` where nothing can be drawn."""
    importlib.import_module("torch._dynamo")  # its Triton has to load before the renderer's LLVM: docs/install.md
    importlib.import_module("stable_baselines3")
    reference_hash()


def together(summary: pl.DataFrame, policies: pl.Expr, seed: int) -> pl.DataFrame:
    """Return a summary in which all ``policies`` are one row of each measure: their `interquartile_mean`."""
    rows = []
    for (env, measure), part in summary.filter(policies).group_by("env", "measure", maintain_order=True):
        score = interquartile_mean(part["value"], seed)
        rows.append({"env": env, "behaviour": TRAINED, "measure": measure, "episodes": part["episodes"][0],
                     "value": score.value, "ci_low": score.low, "ci_high": score.high})  # fmt: skip
    return pl.concat([pl.DataFrame(rows, SUMMARY), summary.filter(~policies)])


def interquartile_mean(scores: npt.ArrayLike, seed: int) -> Score:
    """Return the mean of the middle half of all scores, with its 95 % interval over training seeds.

    Of N scores the int(N / 4) lowest and as many highest are left out: of five, one each. The interval has the
    percentiles of resamples, drawn with replacement. It says how far the number may move when the same training begins
    with other seeds. It says nothing of other worlds: all policies are judged in the same ones. Of few scores it is too
    narrow, as no resample goes beyond the scores there are.

    Parameters
    ----------
    scores
        A score per training seed, two or more: the mean of a measure over the episodes that judged the policy.
    seed
        Seed of the stream ``bootstrap.training``, 0 or more.

    References
    ----------
    Agarwal, Schwarzer, Castro, Courville and Bellemare 2021, Deep reinforcement learning at the edge of the statistical
    precipice, NeurIPS 34: interquartile mean, and percentile intervals by bootstrap.
    """
    from scipy import stats

    values, middle = np.asarray(scores, float), partial(stats.trim_mean, proportiontocut=CUT)
    ends = stats.bootstrap(
        (values,), middle, n_resamples=RESAMPLES, method="percentile", rng=stream("bootstrap.training", seed)
    ).confidence_interval
    return Score(float(middle(values)), float(ends.low), float(ends.high), values.size)


KIND = Kind(plan, work, episodes.draw, show, renders=None)
