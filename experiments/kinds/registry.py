"""Find what ships by its name, and what a user's own file declares: experiments, studies, claims."""

import dataclasses
import os
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, cast

from experiments.base.errors import UsageError, check_known, short
from experiments.base.user_code import declared, declares, is_file, named_file
from experiments.declare.claim import LOOMING_DETECTORS, SHIPPED, Claim, claim_ids
from experiments.declare.clip import OfflineExperiment
from experiments.declare.conditions import Hand
from experiments.declare.experiment import Experiment, visit
from experiments.declare.study import Study, tuple_of
from experiments.kinds.tables import CLAIMS, EXPERIMENTS, NAMES, OFFLINE, STUDIES, shipped
from experiments.settings.models import ConfiguredModel, named_model
from experiments.store.asked import Asked
from scenes import is_arena_file
from scenes.hints import nearest


def load(name: str) -> Experiment:
    """Return the experiment with the robot called ``name``; see `find`. Raises `UsageError` for an off-line one."""
    experiment = find(name)
    if isinstance(experiment, OfflineExperiment):
        raise UsageError(f"{name}: it shows clips, without a robot; see colias list parameters STIMULUS")
    return experiment


def declaration(asked: Asked) -> Any:
    """Return the experiment that was asked for: by name, by file, by hand, or as a caller gave it.

    Raises
    ------
    UsageError
        There is no such experiment, or it was an object of a script, which no file has.
    """
    if asked.declared is not None:
        return find(asked.declared)
    if hand := asked.option("hand"):
        return visit(Hand(**hand))
    if not asked.what:
        raise UsageError("a script gave experiments.run an Experiment of its own: run the script")
    return find(asked.what[0])


def find(name: str | Experiment | OfflineExperiment) -> Experiment | OfflineExperiment:
    """Return the experiment called ``name``, the one that the file ``name`` declares as ``EXPERIMENT``, or it itself.

    Raises `UsageError` on an unknown name, and on a file that cannot be read, has an error, or declares none.
    """
    experiment: Experiment | OfflineExperiment
    if not isinstance(name, str):
        experiment, name = name, f"experiment {name.name}"
    elif name in NAMES:
        experiment = shipped(EXPERIMENTS[name])
    elif name in OFFLINE:
        experiment = next(entry for entry in shipped(EXPERIMENTS[name]) if entry.name == name)
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
    experiment = cast(Experiment | OfflineExperiment, declared(path, "EXPERIMENT", Experiment, OfflineExperiment))
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


def shipped_study(name: str) -> Any:
    """Return the study that ships under a name; `UsageError` where there is none."""
    check_known("study", name, STUDIES)
    return shipped(STUDIES[name])


def called(name: str) -> Study | None:
    """Return the study that ships under a name, or that a user's file declares as ``STUDY``; ``None`` without one.

    Files of models and experiments are looked for beside the user's file.
    """
    if "," in name or not is_file(name):
        return shipped_study(name) if name in STUDIES else None
    path = Path(name)
    if not declares(path, "STUDY"):
        return None
    study = declared(path, "STUDY", Study)
    models = tuple(named_model(path, model, f"STUDY.models[{index}]") for index, model in enumerate(study.models))
    folder = path.resolve().parent
    own = study.experiments
    experiments = tuple(str(folder / name) if isinstance(name, str) and is_file(name) else name for name in own)
    return dataclasses.replace(study, models=models, experiments=experiments, file=str(path.resolve()))


def typed(
    experiment: str | os.PathLike[str] | Experiment | OfflineExperiment | Study,
    over: Iterable[str] | Mapping[str, Any] = (), **given: Any,
) -> Study:  # fmt: skip
    """Return a study by its name or file, or a sweep of experiments joined by commas that no file declares.

    ``given`` are fields of `Study` in place of its own, but for those that are ``None``; assignments follow its own.
    """
    over = tuple_of(over, "over")
    text = os.fspath(experiment) if isinstance(experiment, str | os.PathLike) else ""
    names: tuple[Any, ...] = tuple(name for name in text.split(",") if name)
    study = experiment if isinstance(experiment, Study) else None if over or not text else called(text)
    if study is None:
        if isinstance(experiment, Experiment | OfflineExperiment):
            names, text = (experiment,), experiment.name
        if not names:
            raise UsageError(f"experiment must be a name, a file, a study or an experiment, got {short(experiment)}")
        summary = f"{text} over {', '.join(key.partition('=')[0] for key in over) or 'no parameter'}"
        study = Study("sweep", summary, experiments=names, over=over, repeats=None, replicates=1)
    asked = {name: value for name, value in given.items() if value is not None}
    if over and isinstance(experiment, Study):
        asked["over"] = over
    asked["assignments"] = (*study.assignments, *tuple_of(asked.get("assignments", ()), "assignments"))
    return dataclasses.replace(study, **asked)


def claims_on(on: str) -> Mapping[str, Claim]:
    """Return id -> claim, of those that ship and are judged on ``robot``, ``clips``, ``footage`` or ``behaviours``."""
    shipped(CLAIMS[on])
    return {claim: SHIPPED[on][claim] for claim in claim_ids() if claim in SHIPPED[on]}


def find_claim(claim: Claim | str, on: str) -> Claim:
    """Return a claim by its id and what it is judged on, or ``KeyError``; a user's own claim stands for itself."""
    return claim if isinstance(claim, Claim) else claims_on(on)[claim]


def asked_models(experiment: Experiment) -> tuple[str, ...]:
    """Return the models that an experiment's claims are about: its own, with looming detectors where a claim is."""
    looming = any(find_claim(claim, "robot").about == "looming" for claim in experiment.claims)
    return (*experiment.models, *LOOMING_DETECTORS) if looming else experiment.models


def answering_for(claims: Sequence[str | Claim]) -> list[str]:
    """Return the paper's experiments with the robot that answer for claims: of each claim the first that declares it.

    Raises `UsageError` for a claim that none of them declares.
    """
    ids, known = [claim.id if isinstance(claim, Claim) else claim for claim in claims], answering()
    if unknown := next((name for name in ids if name not in known), ""):
        near = nearest(unknown, known, " (", ")")
        raise UsageError(f"claim {unknown!r}{near}: no experiment with the robot declares it; name the experiment")
    return [name for name in NAMES if name in {known[claim] for claim in ids}]


def claims_of(
    experiments: Sequence[Any], study: Study, models: Sequence[ConfiguredModel]
) -> tuple[tuple[Claim, str], ...]:
    """Return the claims of a study, each with the first experiment that declares it.

    Raises `UsageError` for one that is not declared there, or is about none of the ``models``, where there are some.
    """
    on: Any = "robot" if isinstance(experiments[0], Experiment) else "clips"
    declared: dict[str, tuple[Claim, str]] = {}
    for experiment in experiments:
        for claim in (find_claim(claim, on) for claim in experiment.claims):
            declared.setdefault(claim.id, (claim, experiment.name))
    about = [name for name, (claim, _) in declared.items() if _is_about(claim, models)]
    chosen: dict[str, tuple[Claim, str]] = {}
    for asked in study.claims or (() if study.measures else about):
        name = asked.id if isinstance(asked, Claim) else asked
        if isinstance(asked, str) and asked not in declared:
            raise UsageError(f"--claims {name}: the experiments declare {', '.join(declared) or 'none'}")
        claim = asked if isinstance(asked, Claim) else declared[name][0]
        if not _is_about(claim, models):
            labels = ", ".join(model.label for model in models)
            raise UsageError(f"--claims {name}: it is about other models than {labels}, or compares models")
        chosen[name] = (claim, declared.get(name, (claim, experiments[0].name))[1])
    return tuple(chosen.values())


def _is_about(claim: Any, models: Sequence[ConfiguredModel]) -> bool:
    """Tell whether a claim is about one of the models judged, or none are named; clips have just one."""
    labels = {model.label for model in models}
    if claim.on == "clips":
        return bool(labels <= claim.models)
    channel = "looming" if claim.about == "looming" else "hs"
    responds = any(channel in model.channels for model in models)
    return not models or (responds and all(claim.models <= {label} for label in labels))
