"""Find studies: those that ship, by name, and a user's own file."""

from __future__ import annotations

import dataclasses
import importlib
from pathlib import Path

from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import beside
from experiments.bench.run.user_code import declared, is_file
from experiments.bench.studies.fitting.fit import Fit
from experiments.bench.studies.study import Study
from scenes.hints import nearest


def names() -> tuple[str, ...]:
    """Return the names of the studies that ship."""
    return tuple(importlib.import_module("experiments.studies").NAMES)


def find(name: str) -> Study:
    """Return the study called ``name``, or the one that the file ``name`` declares as ``STUDY``.

    Raises
    ------
    UsageError
        The name is not known, or the file cannot be read, has an error, or declares no study.
    """
    if name in names():
        module = importlib.import_module(f"experiments.studies.{name.replace('-', '_')}")
        study: Study = module.STUDY
        return study
    if is_file(name):
        return _of_file(Path(name))
    known = (*names(), "model-claims")
    raise UsageError(
        f"unknown study '{name}'{nearest(name, known, ' (', ')')}: known are {', '.join(known)}, or a .py file"
    )


def fits() -> tuple[str, ...]:
    """Return the names of the fits that ship."""
    return tuple(importlib.import_module("experiments.studies").FITS)


def find_fit(name: str) -> Fit:
    """Return the fit called ``name``.

    Raises
    ------
    UsageError
        None that ships is called so.
    """
    if name not in fits():
        raise UsageError(f"unknown fit '{name}'{nearest(name, fits(), ' (', ')')}: known are {', '.join(fits())}")
    fit: Fit = importlib.import_module(f"experiments.studies.{name.replace('-', '_')}").FIT
    return fit


def _of_file(path: Path) -> Study:
    study = declared(path, "STUDY")
    if not isinstance(study, Study):
        raise UsageError(f"{path}: STUDY is a {type(study).__name__}, expected an experiments.Study")
    models = tuple(beside(path, model, f"STUDY.models[{index}]") for index, model in enumerate(study.models))
    folder = path.resolve().parent
    experiments = tuple(str(folder / name) if is_file(name) else name for name in study.experiments)
    return dataclasses.replace(study, models=models, experiments=experiments, file=str(path.resolve()))
