"""Do the claims survive? The paper's trials again at other seeds, and with parameters and apparatus moved.

A claim is judged on the trials of the same experiment as its headline (`judged_in`), here and there.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

from experiments.bench import registry
from experiments.bench.core.batch import Batch
from experiments.bench.core.models import choose
from experiments.bench.core.settings import changed
from experiments.bench.core.store.rows import group
from experiments.bench.core.verdict import Verdict
from experiments.bench.robot import run as robot_run
from experiments.bench.robot.claims import CLAIMS, judge
from experiments.bench.robot.experiment import TrialSpec
from experiments.bench.robot.plan import Plan, describe, plan
from experiments.bench.robot.rows import FRAME_SCHEMA, TRIAL_SCHEMA, robot_contents

PAPER = ("general", "speed", "distance", "angular-approach", "angular-recession")
MECHANISM = ("ensembles", "distance-mechanism")
"""Experiments of mechanism, with the claims that compare models: run at the headline's seed, not moved."""
ROBOT_CLAIMS = tuple(claim.id for claim in CLAIMS.values() if claim.about == "direction" and not claim.models)
MODEL = "dsnn"

NETWORK_MOVES: Mapping[str, Mapping[str, str]] = {
    "N_p = 0": {"n_p": "0"},
    "N_p = 6": {"n_p": "6"},
    "d = 4": {"d": "4"},
    "N_con = 4": {"n_con": "4"},
    "tau_s = 10 for all": {"tau_s": "10,10"},
    "tau_s = 200 for all": {"tau_s": "200,200"},
    "tau_s falling, 200..10": {"tau_s": "200,10"},
    "K_sp = 3": {"k_sp": "3"},
    "T_sp = 0.16": {"t_sp": "0.16"},
    "no FDSR": {"fdsr": "false"},
}
"""Each parameter at the end of the paper's own range that the default is not at; the last is its forerunner."""

APPARATUS_MOVES: Mapping[str, Sequence[str]] = {
    "no camera noise": ("camera.shot_noise=0", "camera.read_noise=0"),
    "camera noise x 2": ("camera.shot_noise=2.56", "camera.read_noise=1.28"),
    "light x 0.7": ("scene.light=0.7",),
    "dim arena": ("scene.arena=dim",),
    "plain wall": ("scene.arena=plain",),
    "wall contrast x 2": ("scene.wall_contrast=2",),
    "sudden starts, 100 cm/s2": ("experiment.acceleration_cm_s2=100",),
}
"""The apparatus, one thing moved at a time."""


@dataclass(frozen=True, slots=True)
class Case:
    """The trials of one case of a study, a seed or a move; ``labels`` are its models' if there are several."""

    name: str
    specs: tuple[TrialSpec, ...]
    labels: tuple[str, ...] = (MODEL,)


@cache
def judged_in() -> Mapping[str, str]:
    """Claim -> the experiment whose trials answer for it: of `PAPER` and `MECHANISM` the first that declares it."""
    names = (*PAPER, *MECHANISM)
    return {claim: name for name in reversed(names) for claim in registry.load(name).claims if isinstance(claim, str)}


def seed_cases(seeds: Iterable[int], repeats: int) -> list[Case]:
    """One case per seed, with the defaults."""
    return [Case(str(seed), _specs((), repeats, seed)) for seed in seeds]


def sensitivity_cases(repeats: int, seed: int) -> list[Case]:
    """All moves of the network on one rendering, the defaults among them; then one case per move of the apparatus."""
    base = choose(MODEL)
    models = [base] + [
        dataclasses.replace(base, label=name, network=changed(MODEL, base.network, changes))
        for name, changes in NETWORK_MOVES.items()
    ]
    network = tuple(
        dataclasses.replace(spec, settings=dataclasses.replace(spec.settings, models=tuple(models)))
        for spec in _specs((), repeats, seed)
    )
    cases = [Case("network", network, tuple(model.label for model in models))]
    return cases + [Case(name, _specs(moves, repeats, seed)) for name, moves in APPARATUS_MOVES.items()]


def _specs(assignments: Sequence[str], repeats: int, seed: int) -> tuple[TrialSpec, ...]:
    specs: list[TrialSpec] = []
    for experiment in map(registry.load, PAPER):
        known = {field.name for field in dataclasses.fields(experiment.design)}  # type: ignore[arg-type]
        own = [text for text in assignments if _applies(text, known)]
        specs += plan(experiment, [MODEL], own, repeats, seed).specs()
    return tuple(specs)


def _applies(assignment: str, known: set[str]) -> bool:
    section, _, rest = assignment.partition(".")
    return section != "experiment" or rest.partition("=")[0] in known


def numbered(cases: Sequence[Case]) -> list[TrialSpec]:
    """All trials of the cases under one numbering; their seeds stay their own."""
    specs = [spec for case in cases for spec in case.specs]
    return [dataclasses.replace(spec, index=index) for index, spec in enumerate(specs)]


def batch(name: str, cases: Sequence[Case], example: Plan) -> Batch[TrialSpec]:
    """Return all trials of a study's cases as a batch. They leave neither recordings nor frames.

    ``example`` is a plan of the same run: what computes it, its seed and settings describe the study too.
    """
    specs = numbered(cases)
    listed = [{"case": case.name, "trials": len(case.specs), "settings": case.specs[0].settings} for case in cases]
    return Batch(
        name=name,
        specs=specs,
        work=partial(robot_run.work, keep=robot_run.ROWS_ONLY),
        description={**describe(example), "experiment": name, "trials": len(specs), "cases": listed},
        contents=robot_contents(specs, recordings=False, frames=False),
        schemas=(TRIAL_SCHEMA, FRAME_SCHEMA),
        size=robot_run.seconds,
    )


def pooled(cases: Sequence[Case], rows: Sequence[Mapping[str, Any]]) -> dict[str, Verdict]:
    """Claim -> its verdict on the trials of all cases together: what the claim comes to when sampling is no excuse."""
    threshold = cases[0].specs[0].settings.models[0].threshold
    return {claim: judge(claim, _answering(claim, rows), threshold) for claim in ROBOT_CLAIMS}


def _answering(claim: str, rows: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The rows of the experiment that a claim is judged in."""
    return [row for row in rows if row["experiment"] == judged_in().get(claim)]


def verdicts(cases: Sequence[Case], rows: Sequence[Mapping[str, Any]]) -> dict[str, dict[str, str]]:
    """Case (or label of its models) -> claim -> holds, fails, untested; ``rows`` are those of `numbered` trials.

    A claim some of whose trials failed is not judged on the rest of them.
    """
    found: dict[str, dict[str, str]] = {}
    by_trial = group(rows, "trial", "model")
    start = 0
    for case in cases:
        numbers = range(start, start + len(case.specs))
        start += len(case.specs)
        thresholds = {model.label: model.threshold for model in case.specs[0].settings.models}
        for label in case.labels:
            own = [row for trial in numbers for row in by_trial.get((trial, label), ())]
            there = {row["trial"] for row in own}
            lost = {s.experiment for n, s in zip(numbers, case.specs, strict=True) if n not in there}
            found[label if len(case.labels) > 1 else case.name] = {
                claim: "untested"
                if judged_in().get(claim) in lost
                else judge(claim, _answering(claim, own), thresholds[label]).verdict
                for claim in ROBOT_CLAIMS
            }
    return found
