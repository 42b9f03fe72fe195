"""Find experiments: registered names, or the path of a user's own file."""

from __future__ import annotations

import difflib
import importlib
from pathlib import Path

from experiments import NAMES
from experiments.bench.declaration import Experiment
from experiments.bench.files import UsageError, declared, is_file
from experiments.bench.paper import claim_texts


def load(name: str) -> Experiment:
    """The experiment called ``name``, or the one that the file ``name`` declares as ``EXPERIMENT``.

    Raises `UsageError` on an unknown name, and on a file that cannot be read, has an error, or declares none.
    """
    if name in NAMES:
        experiment = importlib.import_module(f"experiments.{name.replace('-', '_')}").EXPERIMENT
    elif is_file(name):
        experiment = declared(Path(name), "EXPERIMENT")
    else:
        near = difflib.get_close_matches(name, NAMES, n=1, cutoff=0.0)[0]
        raise UsageError(f"unknown experiment '{name}': known are {', '.join(NAMES)} (nearest: {near}), or a .py file")
    if not isinstance(experiment, Experiment):
        raise UsageError(f"{name}: EXPERIMENT is a {type(experiment).__name__}, expected an Experiment")
    unknown = [claim for claim in experiment.claims if claim not in claim_texts()]
    if unknown:
        raise UsageError(f"{name}: unknown claim '{unknown[0]}': known are {', '.join(claim_texts())}")
    return experiment
