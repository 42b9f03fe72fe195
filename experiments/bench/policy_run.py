"""What becomes of a policy: kept in a folder, judged against others, replayed with recordings."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from experiments.bench import behave, behave_figure, console_behave, policy_file
from experiments.bench.console import Means
from experiments.bench.episodes import Setting
from experiments.bench.policy import Policy
from experiments.bench.results import known
from experiments.bench.settings import check_counts

JUDGED = 20
"""Episodes that a trained policy and each of its opponents are judged by."""

REFLEX: Mapping[str, str] = MappingProxyType(
    {"colias_sim/Fixation-v0": "fixation", "colias_sim/Optomotor-v0": "optomotor"}
)
"""Env -> the hand-written reflex that a policy is held against, beside chance and rest."""


def keep(policy: Policy, curve: Sequence[Mapping[str, float]], folder: Path) -> Path:
    """Write ``policy.npz`` and ``learning.csv``; return the path of the former."""
    file = folder / f"policy{policy_file.ENDING}"
    policy_file.save(policy, file)
    with (folder / "learning.csv").open("x", newline="", encoding="utf-8") as table:
        writer = csv.DictWriter(table, ("steps", "episodes", "return"))
        writer.writeheader()
        writer.writerows({name: known(value) for name, value in row.items()} for row in curve)
    return file


def judge(file: Path, folder: Path, means: Means) -> bool:
    """Play the policy, as read back from its file, and its opponents in the same worlds, none of them trained in.

    Returns whether episodes failed.
    """
    env = policy_file.load(file).about.env
    return _play(file, env, ("random", "still", REFLEX[env]), folder, JUDGED, 0, means, recordings=False)


def replay(file: Path, folder: Path, episodes: int, seed: int, means: Means) -> bool:
    """Play the policy in worlds from ``seed`` up, leaving a recording of each; returns whether episodes failed."""
    check_counts(seed, episodes)
    return _play(file, policy_file.load(file).about.env, (), folder, episodes, seed, means, recordings=True)


def _play(
    file: Path, env: str, opponents: Sequence[str], folder: Path, episodes: int, seed: int, means: Means,
    *, recordings: bool,
) -> bool:  # fmt: skip
    settings = tuple(Setting(name, env) for name in (str(file.resolve()), *opponents))
    played = behave.run(behave.BehaviourPlan(settings, episodes, seed), folder, means, recordings)
    behave_figure.write(played)
    if not means.quiet:
        console_behave.show(played, recordings)
    return bool(played.failures)
