"""The trials of a reproduction's two studies: the design again at other seeds, and with one thing moved at a time."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from experiments import NAMES
from experiments.bench import registry
from experiments.bench.engine.batch import Batch, Resources
from experiments.bench.engine.models import ConfiguredModel, choose
from experiments.bench.engine.settings import changed
from experiments.bench.reproduction.onboard import series
from experiments.bench.reproduction.onboard.formats import BEST
from experiments.bench.robot import run as robot_run
from experiments.bench.robot.claims import find, paper_claims
from experiments.bench.robot.experiment import TrialSpec
from experiments.bench.robot.plan import Plan, describe, plan
from experiments.bench.robot.rows import FRAME_SCHEMA, TRIAL_SCHEMA, robot_contents
from experiments.bench.store.places import inside
from experiments.bench.store.rows import Failure

SHOWN = ("distance-mechanism", "approach-mechanism", "recession-mechanism")
"""Experiments without claims that the report shows, at the headline's seed alone."""
ROBOT_CLAIMS = tuple(claim.id for claim in paper_claims().values() if claim.about == "direction" and not claim.models)
MODEL = "dsnn"
LOOMING_DETECTORS = ("lgmd1", "lgmd2")

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
    "soft starts, 10 cm/s2": ("experiment.acceleration_cm_s2=10",),
}
"""The apparatus, one thing moved at a time."""


@dataclass(frozen=True, slots=True)
class Case:
    """The trials of one case of a study: the whole design at a seed, or with something moved.

    ``moved`` are the labels of models that are moves of the network, all on the same frames.
    """

    name: str
    specs: tuple[TrialSpec, ...]
    moved: tuple[str, ...] = ()


@cache
def paper() -> tuple[str, ...]:
    """Return the experiments with the robot that declare claims of the paper, in the order of the registry."""
    return tuple(name for name in NAMES if any(isinstance(claim, str) for claim in registry.load(name).claims))


def moved() -> tuple[str, ...]:
    """Return those of `paper` that the study of sensitivity moves: not those that compare moves of the network."""
    return tuple(name for name in paper() if len(registry.load(name).models) == 1)


@cache
def judged_in() -> Mapping[str, str]:
    """Claim -> the experiment whose trials answer for it: of `paper` the first that declares it."""
    return {claim: name for name in reversed(paper()) for claim in registry.load(name).claims if isinstance(claim, str)}


def asked_models(experiment: str) -> tuple[str, ...]:
    """Return the models that an experiment's claims are about: its own, with looming detectors where a claim is."""
    declared = registry.load(experiment)
    looming = any(find(claim).about == "looming" for claim in declared.claims)
    return (*declared.models, *LOOMING_DETECTORS) if looming else declared.models


def replicate_cases(
    seeds: Iterable[int], repeats: int, among: Collection[str] | None = None, beside: Sequence[str] = ()
) -> list[Case]:
    """One case per seed, with the defaults.

    ``among`` are the models to be shown, otherwise all that claims need; ``beside`` are shown in `moved` too.
    """
    return [Case(str(seed), specs((), repeats, seed, among, beside=beside)) for seed in seeds]


def sensitivity_cases(repeats: int, seed: int) -> list[Case]:
    """All moves of the network on one rendering, in float and on board, then one case per move of the apparatus.

    The network as it is by default watches its moves too, so that the on-board one can be held against it; it is not
    among the ``moved``, as at the same seed it is replicate 0.
    """
    base, onboard = choose(MODEL), choose(BEST.label)
    models = [
        *_moves(base, {name: name for name in NETWORK_MOVES}), onboard,
        *_moves(onboard, {name: f"{onboard.label}, {name}" for name in NETWORK_MOVES}),
    ]  # fmt: skip
    network = tuple(
        dataclasses.replace(spec, settings=dataclasses.replace(spec.settings, models=(base, *models)))
        for spec in specs((), repeats, seed, (MODEL,), moved())
    )
    cases = [Case("network", network, tuple(model.label for model in models))]
    return cases + [
        Case(name, specs(moves, repeats, seed, (MODEL,), moved())) for name, moves in APPARATUS_MOVES.items()
    ]


def _moves(base: ConfiguredModel, labels: Mapping[str, str]) -> list[ConfiguredModel]:
    """A network under each of `NETWORK_MOVES`, by the label that ``labels`` give it."""
    return [
        dataclasses.replace(base, label=label, network=changed(base.label, base.network, NETWORK_MOVES[name]))
        for name, label in labels.items()
    ]


def specs(
    assignments: Sequence[str], repeats: int, seed: int, among: Collection[str] | None, names: Sequence[str] = (),
    beside: Sequence[str] = (),
) -> tuple[TrialSpec, ...]:  # fmt: skip
    """Return one replicate's trials of the experiments called ``names``, or of all of `paper`.

    Parameters
    ----------
    assignments
        ``--set`` texts; those of a design that an experiment does not have are left out there.
    repeats, seed
        Trials of each condition, and the replicate's seed.
    among
        Models to be shown; ``None``: all that the experiments' claims are about.
    names
        Names of experiments.
    beside
        Models that are shown in those of `moved` too.
    """
    found: list[TrialSpec] = []
    for name in names or paper():
        experiment = registry.load(name)
        known = {field.name for field in dataclasses.fields(experiment.design)}  # type: ignore[arg-type]
        own = [text for text in assignments if _applies(text, known)]
        models = [model for model in asked_models(name) if among is None or model in among]
        models += beside if name in moved() else ()
        found += plan(experiment, models, own, repeats, seed).specs()
    return tuple(found)


def _applies(assignment: str, known: set[str]) -> bool:
    section, _, rest = assignment.partition(".")
    return section != "experiment" or rest.partition("=")[0] in known


def numbered(cases: Sequence[Case]) -> list[TrialSpec]:
    """All trials of the cases under one numbering; their seeds stay their own."""
    specs = [spec for case in cases for spec in case.specs]
    return [dataclasses.replace(spec, index=index) for index, spec in enumerate(specs)]


def batch(name: str, cases: Sequence[Case], example: Plan, kept: Collection[str] = ()) -> Batch[TrialSpec]:
    """Return all trials of a study's cases as a batch. They leave neither recordings nor frames.

    Parameters
    ----------
    name, cases
        What the study is called, and what it is of.
    example
        A plan of the same run: what computes it, its seed and settings describe the study too.
    kept
        Labels of models whose HS and spikes in every frame are kept in their rows.
    """
    specs = numbered(cases)
    listed = [{"case": case.name, "trials": len(case.specs), "settings": case.specs[0].settings} for case in cases]
    plain = robot_contents(specs, recordings=False, frames=False)
    return Batch(
        name=name,
        specs=specs,
        work=partial(series.work, labels=tuple(kept)) if kept else partial(robot_run.work, keep=robot_run.ROWS_ONLY),
        description={**describe(example), "experiment": name, "trials": len(specs), "cases": listed},
        contents=series.contents(plain) if kept else plain,
        schemas=(series.SCHEMA if kept else TRIAL_SCHEMA, FRAME_SCHEMA),
        size=robot_run.seconds,
    )


def played(
    cases: Sequence[list[Case]], batch: Callable[[int, list[Case]], Batch[Any]], folder: Path, resources: Resources
) -> Iterator[tuple[list[Case], list[dict[str, Any]], tuple[Failure, ...]]]:
    """Do what is missing of a study's replicates, one after the other, each in a folder of its own.

    Parameters
    ----------
    cases
        The trials of each replicate.
    batch
        Makes the batch of a replicate, of its number and its trials.
    folder
        That of the study, made if need be. Replicate r has the folder ``replicate-r`` in it.
    resources
        Workers, or a cluster.

    Yields
    ------
    tuple
        The cases of a replicate, the rows of their trials, and what failed so far, in earlier replicates too.
    """
    folder.mkdir(parents=True, exist_ok=True)
    failures: list[Failure] = []
    with resources.pool() as pool:
        for number, own in enumerate(cases):
            each = batch(number, own)
            with closing(each.open(inside(folder, f"replicate-{number}"), resources)) as done:
                failures += each.fill(done, pool, resources)
                rows = done.rows()
            yield own, rows, tuple(failures)
