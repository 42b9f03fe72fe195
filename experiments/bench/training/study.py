"""One training at several seeds, in one folder: what is there is checked, the rest is trained, all are judged."""

from __future__ import annotations

import importlib.metadata
import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from experiments.bench.closed_loop import policy_file
from experiments.bench.closed_loop.policy import ROLLOUT, About
from experiments.bench.engine.terminal import count, error_console, progress
from experiments.bench.run import interrupts
from experiments.bench.run.errors import UsageError
from experiments.bench.run.runs import Resources
from experiments.bench.stats.scores import Standing
from experiments.bench.store.files import Files
from experiments.bench.store.rows import Failure
from experiments.bench.training import evaluate, scores

NAME = "training.json"
"""Name of the file with a study's design."""
LEARNT_BY = ("stable-baselines3", "torch")
"""The libraries that decide what a policy becomes."""
OF_A_SEED = ("env", "options", "model", "envs", "hidden", "steering")
"""Fields that all seeds of a study share, beside the steps."""


@dataclass(frozen=True, slots=True)
class Study:
    """One training at ``runs`` seeds: that of ``first`` and those after it."""

    first: About
    runs: int

    @property
    def seeds(self) -> range:
        """The training seeds."""
        return range(self.first.seed, self.first.seed + self.runs)

    def about(self, seed: int) -> About:
        """Return what is asked of one training seed."""
        return replace(self.first, seed=seed)

    def steps(self) -> int:
        """Steps of each training, rounded up to whole rollouts as PPO does."""
        rollout = ROLLOUT * self.first.envs
        return -(-self.first.steps // rollout) * rollout

    def under(self) -> str:
        """Return the env's arguments of training and judging in words; empty where none is changed."""
        return ", ".join(f"{name}={value}" for name, value in self.first.options.items())

    def describe(self) -> dict[str, Any]:
        """Return what ``training.json`` holds, and what a study that is gone on with must be equal in."""
        shared = TypeAdapter(About).dump_python(self.first, mode="json")
        return {
            "training": "PPO", "seeds": list(self.seeds), "steps": self.first.steps,
            **{name: shared[name] for name in OF_A_SEED},
        }  # fmt: skip


@dataclass(frozen=True, slots=True)
class Studied:
    """Results of a study.

    Attributes
    ----------
    study, folder, env
        What was asked, where everything is, and the env's id.
    runs
        The policy of each training seed, as it was judged.
    standings
        The policies of all seeds together, then their opponents.
    episodes
        That each was judged by.
    versions
        Of the libraries that all policies were learnt with.
    failures
        Episodes that could not be played.
    """

    study: Study
    folder: Path
    env: str
    runs: Sequence[Standing]
    standings: Sequence[Standing]
    episodes: int
    versions: Mapping[str, str]
    failures: Sequence[Failure]


def open_folder(study: Study, folder: Path) -> list[int]:
    """Make the study's folder, or check the one in which it was begun.

    Returns
    -------
    list of int
        The training seeds that are finished.

    Raises
    ------
    FileExistsError
        There is something else in it.
    UsageError
        There is another study, or a policy in it that is not of this study.
    """
    here = study.describe()
    if not (folder / NAME).exists():
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise FileExistsError(f"--out {folder}: holds something already; choose another")
        Files(folder).write_json(NAME, here)
        return []
    there = _read(folder)
    for name in here:
        if there.get(name) != here[name]:
            raise UsageError(
                f"--out {folder}: has {name} {_said(there.get(name))}, asked for is {_said(here[name])}; choose another"
            )
    done = [seed for seed in study.seeds if _finished(study, folder, seed)]
    versions(study, folder, done)
    return done


def versions(study: Study, folder: Path, seeds: Sequence[int]) -> dict[str, str]:
    """Return the versions with which the policies of ``seeds`` were learnt with; `UsageError` if of several."""
    by_package: dict[str, str] = {}
    for seed in seeds:
        policy_versions = policy_file.load(_policy(folder, seed)).about.versions
        for name in LEARNT_BY:
            version = policy_versions.get(name, "unknown")
            if by_package.setdefault(name, version) != version:
                raise UsageError(
                    f"{_policy(folder, seed)}: learnt by {name} {version}, earlier seeds by {by_package[name]};"
                    f" remove {folder / f'seed-{seed}'} to train it anew"
                )
    return by_package


def installed() -> dict[str, str]:
    """Versions here of what decides a policy; ``PackageNotFoundError`` without the extra."""
    return {name: importlib.metadata.version(name) for name in LEARNT_BY}


def check_installed(learnt: Mapping[str, str], folder: Path) -> None:
    """Raise `UsageError` if the libraries here are not those that the study's finished seeds were learnt with."""
    here = installed()
    for name, version in learnt.items():
        if here[name] != version:
            raise UsageError(f"--out {folder}: its seeds were learnt by {name} {version}, installed is {here[name]}")


def train(study: Study, folder: Path, seed: int, resources: Resources) -> None:
    """Train one seed, with progress, and keep its policy; nothing is kept of a training that Ctrl-C ends."""
    from experiments.bench.training import ppo

    rounds, place = -(-study.first.steps // study.first.envs), study.seeds.index(seed) + 1
    name = f"training seed {seed} ({place} of {study.runs})"
    if not resources.quiet:
        error_console.print(f"{name}: starting {count(study.first.envs, 'env')}", markup=False)
    learnt = ppo.train(
        study.about(seed),
        lambda: progress(name, rounds, resources.quiet, f"steps of {count(study.first.envs, 'env')}"),
    )
    if learnt.stopped:
        hint = f"stopped in training seed {seed}; finished ones are in {folder}: --out {folder} goes on"
        error_console.print(hint, soft_wrap=True, markup=False)
        raise KeyboardInterrupt
    whole = _policy(folder, seed).parent
    with interrupts.held():
        partial = whole.with_name(f"{whole.name}.part")
        shutil.rmtree(partial, ignore_errors=True)  # of a process that was killed as it wrote
        partial.mkdir()
        evaluate.keep(learnt.policy, learnt.curve, partial, _policy(folder, seed).stem)
        partial.replace(whole)


def judge(study: Study, folder: Path, resources: Resources) -> Studied:
    """Play all policies and their opponents in the same held-out worlds; write ``policies.csv``."""
    files = [_policy(folder, seed) for seed in study.seeds]
    played = evaluate.judge(files, folder, resources)
    names = {file.stem for file in files}
    runs = [standing for standing in played.standings if standing.name in names]
    others = [standing for standing in played.standings if standing.name not in names]
    standings = [scores.together(runs, study.first.seed), *others] if runs else others
    versions_found = versions(study, folder, study.seeds)
    columns = {
        "training_seeds": f"{study.seeds[0]} to {study.seeds[-1]}", "steps": study.steps(), "envs": study.first.envs,
        "options": study.under(), **{name.replace("-", "_"): versions_found[name] for name in LEARNT_BY},
    }  # fmt: skip
    if standings:
        Files(folder).write_rows("policies.csv", scores.rows(standings, played.env, evaluate.JUDGED, columns))
    return Studied(study, folder, played.env, runs, standings, evaluate.JUDGED, versions_found, played.failures)


def _policy(folder: Path, seed: int) -> Path:
    return folder / f"seed-{seed}" / f"policy-{seed}{policy_file.ENDING}"


def _read(folder: Path) -> dict[str, Any]:
    """Return what the folder says of its study."""
    there: dict[str, Any] = json.loads((folder / NAME).read_text(encoding="utf-8"))
    return there


def _finished(study: Study, folder: Path, seed: int) -> bool:
    """Tell whether the policy of a seed is there; `UsageError` if what is there is none of this study."""
    file = _policy(folder, seed)
    if not file.parent.exists():
        return False
    about, wanted = policy_file.load(file).about, replace(study.about(seed), steps=study.steps())
    for name in ("seed", "steps", *OF_A_SEED):
        if getattr(about, name) != getattr(wanted, name):
            problem = f"has {name} {getattr(about, name)}, asked for is {getattr(wanted, name)}"
            raise UsageError(f"{file}: {problem}; remove {file.parent} to train it anew")
    return True


def _said(value: object) -> str:
    """Return a value in few words: seeds by their ends."""
    if isinstance(value, list) and len(value) > 2:
        return f"{value[0]} to {value[-1]}"
    return str(value)
