"""Evaluation of a policy: kept in a folder, judged against others, replayed with recordings."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from experiments.behaviours import FIXATION, OPTOMOTOR
from experiments.bench.closed_loop import policy_file
from experiments.bench.closed_loop import run as closed_loop_run
from experiments.bench.closed_loop.episode import Setting
from experiments.bench.closed_loop.policy import About, Policy
from experiments.bench.closed_loop.run import Played
from experiments.bench.run.runs import Resources
from experiments.bench.run.settings import check_counts
from experiments.bench.store.places import replacing
from experiments.bench.store.rows import known

JUDGED = 20
"""Episodes that a trained policy and each of its opponents are judged by."""

OPPONENTS: Mapping[str, tuple[str, ...]] = MappingProxyType({
    FIXATION: ("fixation-pi", "fixation", "still", "random", "oracle-target"),
    OPTOMOTOR: ("optomotor-pi", "optomotor", "still", "random", "oracle-heading"),
})  # fmt: skip
"""Env -> what a policy is held against: the PI reflex, which steers as it does, the plain one, rest, chance, truth."""


def keep(policy: Policy, curve: Sequence[Mapping[str, float]], folder: Path, name: str = "policy") -> Path:
    """Write ``NAME.npz`` and ``learning.csv``; return the path of the former."""
    file = folder / f"{name}{policy_file.ENDING}"
    policy_file.save(policy, file)
    with replacing(folder / "learning.csv") as partial, partial.open("w", newline="", encoding="utf-8") as table:
        writer = csv.DictWriter(table, ("steps", "episodes", "return"))
        writer.writeheader()
        writer.writerows({name: known(value) for name, value in row.items()} for row in curve)
    return file


def judge(files: Sequence[Path], folder: Path, resources: Resources) -> Played:
    """Play policies of one training, as read back from their files, and their opponents in the same worlds.

    Nobody was trained in these worlds. The standings begin with the policies, in their order. Eye, wheels and ranges of
    randomisation are those of the training, the draws are others.
    """
    about = policy_file.load(files[0]).about
    return _play(files, about, OPPONENTS[about.env], folder, JUDGED, 0, resources, recordings=0)


def replay(file: Path, folder: Path, episodes: int, seed: int, resources: Resources) -> Played:
    """Play the policy in worlds from ``seed`` up, and leave a recording of each."""
    check_counts(seed, episodes, "--episodes")
    about = policy_file.load(file).about
    return _play([file], about, (), folder, episodes, seed, resources, recordings=episodes)


def _play(
    files: Sequence[Path], about: About, opponents: Sequence[str], folder: Path, episodes: int, seed: int,
    resources: Resources, *, recordings: int,
) -> Played:  # fmt: skip
    options = tuple(sorted(about.options.items()))
    names = (*(str(file.resolve()) for file in files), *opponents)
    settings = tuple(Setting(name, about.env, options) for name in names)
    plan = closed_loop_run.BehaviourPlan(settings, episodes, seed, "training")
    with resources.pool() as pool:
        return closed_loop_run.run(plan, folder, pool, resources, recordings=recordings)
