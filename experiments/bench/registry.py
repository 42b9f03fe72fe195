"""Find experiments: registered names, or the path of a user's own file."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from experiments import NAMES, OFFLINE
from experiments.bench.run.errors import UsageError, check_known
from experiments.bench.run.models import named_model
from experiments.bench.run.user_code import declared, is_file, named_file
from experiments.bench.sources.clips import OfflineExperiment
from experiments.bench.sources.experiment import Experiment
from experiments.bench.stats.claim import Claim, claims_on
from scenes import is_arena_file
from scenes.hints import nearest


def load(name: str) -> Experiment:
    """Return the experiment with the robot called ``name``; see `find`. Raises `UsageError` for an off-line one."""
    experiment = find(name)
    if isinstance(experiment, OfflineExperiment):
        raise UsageError(f"{name}: it shows clips, without a robot; see colias list parameters STIMULUS")
    return experiment


def find(name: str | Experiment | OfflineExperiment) -> Experiment | OfflineExperiment:
    """Return the experiment called ``name``, the one that the file ``name`` declares as ``EXPERIMENT``, or it itself.

    Raises `UsageError` on an unknown name, and on a file that cannot be read, has an error, or declares none.
    """
    experiment: Experiment | OfflineExperiment
    if not isinstance(name, str):
        experiment, name = name, f"experiment {name.name}"
    elif name in NAMES:
        experiment = importlib.import_module(f"experiments.{name.replace('-', '_')}").EXPERIMENT
    elif name in OFFLINE:
        clips = importlib.import_module("experiments.clips").EXPERIMENTS
        experiment = next(entry for entry in clips if entry.name == name)
    elif is_file(name):
        experiment = _of_file(Path(name))
    else:
        near = nearest(name, (*NAMES, *OFFLINE), " (", ")")
        raise UsageError(f"unknown experiment '{name}'{near}; colias list experiments names all; a .py file is one too")
    check_claims(experiment, name)
    return experiment


@cache
def answering() -> Mapping[str, str]:
    """Claim of the paper -> the experiment with the robot that tests it: the first that declares it."""
    return {claim: name for name in reversed(NAMES) for claim in load(name).claims if isinstance(claim, str)}


@cache
def paper_experiments() -> tuple[str, ...]:
    """Return the experiments with the robot that declare claims of the paper, in the registry's order."""
    return tuple(name for name in NAMES if any(isinstance(claim, str) for claim in load(name).claims))


def _of_file(path: Path) -> Experiment | OfflineExperiment:
    """Return what a user's file declares, with the file's path; a relative path of a model starts at its folder."""
    experiment: Experiment | OfflineExperiment = declared(path, "EXPERIMENT", Experiment, OfflineExperiment)
    models = tuple(named_model(path, model, f"EXPERIMENT.models[{i}]") for i, model in enumerate(experiment.models))
    if isinstance(experiment, Experiment) and is_arena_file(experiment.arena):
        arena = named_file(path, experiment.arena, "EXPERIMENT.arena")
        experiment = dataclasses.replace(experiment, arena=str(arena.resolve()))
    return dataclasses.replace(experiment, file=str(path.resolve()), models=models)


def check_claims(experiment: Experiment | OfflineExperiment, name: str) -> None:
    """Raise `UsageError` for an unknown claim, or one that trials of this kind cannot test.

    Parameters
    ----------
    experiment
        The experiment.
    name
        What it was asked for by.
    """
    on = "clips" if isinstance(experiment, OfflineExperiment) else "robot"
    for claim in experiment.claims:
        if isinstance(claim, Claim):
            if claim.on != on:
                raise UsageError(f"{name}: claim {claim.id} is on {claim.on}: expected on='{on}' here")
        else:
            check_known(f"{name}: claim", claim, claims_on(on))
