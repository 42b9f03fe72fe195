"""Find experiments: registered names, or the path of a user's own file."""

from __future__ import annotations

import difflib
import importlib
import importlib.util
import sys
import traceback
from pathlib import Path

from pydantic import ValidationError

from experiments import NAMES
from experiments.bench.declaration import Experiment
from experiments.bench.paper import claim_texts
from experiments.bench.settings import UsageError, explain


def load(name: str) -> Experiment:
    """The experiment called ``name``, or the one that the file ``name`` declares as ``EXPERIMENT``.

    Raises `UsageError` on an unknown name, and on a file that cannot be read, has an error, or declares none.
    """
    if name in NAMES:
        experiment = importlib.import_module(f"experiments.{name}").EXPERIMENT
    elif name.endswith(".py") or "/" in name:
        experiment = _load_file(Path(name))
    else:
        near = difflib.get_close_matches(name, NAMES, n=1, cutoff=0.0)[0]
        raise UsageError(f"unknown experiment '{name}': known are {', '.join(NAMES)} (nearest: {near}), or a .py file")
    if not isinstance(experiment, Experiment):
        raise UsageError(f"{name}: EXPERIMENT is a {type(experiment).__name__}, expected an Experiment")
    unknown = [claim for claim in experiment.claims if claim not in claim_texts()]
    if unknown:
        raise UsageError(f"{name}: unknown claim '{unknown[0]}': known are {', '.join(claim_texts())}")
    return experiment


def _load_file(path: Path) -> object:
    """Run the user's own file, which they asked for by name, and take its ``EXPERIMENT``.

    Modules beside it can be imported, and what it defines can be found again by name, as dataclasses need.
    """
    if not path.is_file():
        raise UsageError(f"{path}: no such experiment file")
    spec = importlib.util.spec_from_file_location(f"colias_experiment_{path.stem}", path)
    if spec is None or spec.loader is None:
        raise UsageError(f"{path}: an experiment file's name ends in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    sys.path.append(str(path.resolve().parent))
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        raise UsageError(f"{path}, line {error.lineno}: {error.msg}") from None
    except (Exception, SystemExit) as error:
        frames = traceback.extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in frames if Path(frame.filename).resolve() == path.resolve()]
        where = f", line {lines[-1]}" if lines else ""
        said = explain(error) if isinstance(error, ValidationError) else f"{type(error).__name__}: {error}"
        raise UsageError(f"{path}{where}: {' '.join(said.split())}") from None
    if not hasattr(module, "EXPERIMENT"):
        raise UsageError(f"{path}: declares no EXPERIMENT")
    return module.EXPERIMENT
