"""What a reproduction is to do: how much of it, which trials, clips and episodes; and how its numbers tell of that."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from experiments import OFFLINE
from experiments.bench import registry
from experiments.bench.clips import claims as clips_claims
from experiments.bench.clips import plan as clips_plan
from experiments.bench.clips.experiment import OfflineExperiment
from experiments.bench.clips.plan import OfflinePlan
from experiments.bench.closed_loop import claims as closed_loop_claims
from experiments.bench.closed_loop.run import BehaviourPlan
from experiments.bench.core.errors import UsageError
from experiments.bench.core.store import provenance
from experiments.bench.core.store.description import to_json
from experiments.bench.core.verdict import claim_texts
from experiments.bench.footage import claims as footage_claims
from experiments.bench.reproduction import robustness
from experiments.bench.robot.claims import CLAIMS, PATH_TOLERANCE_MM, SPEED_TOLERANCE, find
from experiments.bench.robot.plan import Plan, describe, plan


@dataclass(frozen=True, slots=True)
class Scale:
    """How much to run: repeats of the experiments, number of seeds with repeats at each, repeats for sensitivity.

    Fewer repeats than a claim's ``least`` leave a claim untested; with 0 for sensitivity nothing is moved.
    """

    repeats: int
    seeds: int
    seed_repeats: int
    sensitivity_repeats: int
    offline_repeats: int | None
    """Seeds of the off-line experiments; otherwise each one's own number."""
    episodes: int
    """Of each behaviour."""
    steps: int | None = None
    """Frames of an episode at most; otherwise the env's own number."""
    offline: tuple[str, ...] = OFFLINE
    """The off-line experiments to run."""


SHORT = ("clean", "blocked", "clutter-depth", "clutter-translation", "edges", "apparent", "background-alone")
"""The off-line experiments without grids of long clips."""
SEEDS, SENSITIVITY = "seeds", "sensitivity"
BESIDE = ("dsn2017",)
"""The models shown beside the DSNN unless others are named."""
LOOMING_DETECTORS = ("lgmd1", "lgmd2")
ENOUGH = max(claim.least for claim in CLAIMS.values())
"""Repeats at which every claim of the robot is judged."""
QUICK = Scale(
    ENOUGH, seeds=2, seed_repeats=ENOUGH, sensitivity_repeats=0, offline_repeats=1, episodes=1, steps=150,
    offline=SHORT,
)  # fmt: skip
USUAL = Scale(
    10, seeds=10, seed_repeats=ENOUGH, sensitivity_repeats=ENOUGH, offline_repeats=None, episodes=20, steps=900
)
FULL = Scale(10, seeds=20, seed_repeats=10, sensitivity_repeats=10, offline_repeats=5, episodes=60)


@dataclass(frozen=True, slots=True)
class Planned:
    """All that a reproduction runs, checked."""

    scale: Scale
    seed: int
    plans: list[Plan]
    """The paper's experiments with the robot, then those of the user."""
    offline: list[OfflinePlan]
    loops: list[BehaviourPlan]
    seeds: list[robustness.Case]
    moves: list[robustness.Case]


def planned(
    scale: Scale, seed: int, models: Sequence[str] = BESIDE, extra: Sequence[str] = (), robot_only: bool = False,
    only: bool = False,
) -> Planned:  # fmt: skip
    """What `experiments.bench.reproduction.reproduce.reproduce` runs; `UsageError` for what cannot be run."""
    shown = [robustness.MODEL, *(name for name in models if name != robustness.MODEL)]
    plans = [
        plan(registry.load(name), shown if only else _models(name, shown), (), scale.repeats, seed)
        for name in (*robustness.PAPER, *extra)
    ]
    _check_names(plans)
    return Planned(
        scale, seed, plans,
        offline=[_offline_plan(name, scale, seed) for name in scale.offline if not robot_only],
        loops=[] if robot_only else closed_loop_claims.plans(scale.episodes, seed, scale.steps),
        seeds=robustness.seed_cases(range(seed, seed + scale.seeds), scale.seed_repeats),
        moves=robustness.sensitivity_cases(scale.sensitivity_repeats, seed) if scale.sensitivity_repeats else [],
    )  # fmt: skip


def design(made: Planned) -> dict[str, Any]:
    """What ``design.json`` holds: scale and seed, the versions, and a digest of all that decides the numbers.

    The digest is of every experiment, parameter, seed and number of repeats, and of the claims' words and bounds; not
    of versions and code. Two reproductions with one digest should differ in no number.
    """
    robot, clips, loops = (
        map(describe, made.plans), (each.describe() for each in made.offline), (each.describe() for each in made.loops)
    )  # fmt: skip
    runs, computes = [*robot, *clips, *loops], (*provenance.KEYS, "form")
    parts = {
        "runs": [{name: value for name, value in run.items() if name not in computes} for run in runs],
        "studies": [(case.name, case.labels, case.specs) for case in (*made.seeds, *made.moves)],
        "claims": claim_texts(),
        "least": [{claim.id: claim.least for claim in CLAIMS.values()}, clips_claims.CONDITIONS,
                  clips_claims.LEAST_GREYS, footage_claims.LEAST_SECONDS, closed_loop_claims.LEAST_SEEDS],
        "bounds": [SPEED_TOLERANCE, PATH_TOLERANCE_MM],
    }  # fmt: skip
    digest = hashlib.sha256(to_json(parts).encode()).hexdigest()
    return {
        "seed": made.seed,
        "scale": dataclasses.asdict(made.scale),
        "digest": digest,
        "versions": provenance.versions(),
    }


def _models(experiment: str, shown: Sequence[str]) -> list[str]:
    """The models of one experiment: those of all, and where a claim is about them the looming detectors."""
    extra = LOOMING_DETECTORS if any(find(c).about == "looming" for c in registry.load(experiment).claims) else ()
    return [*shown, *(name for name in extra if name not in shown)]


def _offline_plan(name: str, scale: Scale, seed: int) -> OfflinePlan:
    experiment = registry.find(name)
    assert isinstance(experiment, OfflineExperiment)
    # Where one repeat says it all, nothing in the clips is random.
    repeats = scale.offline_repeats if experiment.repeats > 1 else None
    return clips_plan.plan(experiment, (), (), repeats, seed)


def _check_names(plans: Sequence[Plan]) -> None:
    """Every experiment has a folder of its own."""
    names = [each.experiment.name for each in plans]
    for name in names:
        if names.count(name) > 1 or name in (SEEDS, SENSITIVITY, *OFFLINE):
            raise UsageError(f"--experiment {name}: that name is taken in a reproduction; give it another")
