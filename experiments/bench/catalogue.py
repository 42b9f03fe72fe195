"""Find experiments: registered names, or the path of a user's own file."""

from __future__ import annotations

import difflib
import importlib
from pathlib import Path

from experiments import NAMES, OFFLINE
from experiments.bench.declaration import Experiment
from experiments.bench.files import UsageError, declared, is_file
from experiments.bench.offline import OfflineExperiment
from experiments.bench.offline_claims import JUDGES
from experiments.bench.paper import claim_texts


def load(name: str) -> Experiment:
    """The experiment with the robot called ``name``; see `find`. Raises `UsageError` for an off-line one."""
    experiment = find(name)
    if isinstance(experiment, OfflineExperiment):
        raise UsageError(f"{name}: an off-line experiment has no robot: colias run shows its clips")
    return experiment


def find(name: str) -> Experiment | OfflineExperiment:
    """The experiment called ``name``, or the one that the file ``name`` declares as ``EXPERIMENT``.

    Raises `UsageError` on an unknown name, and on a file that cannot be read, has an error, or declares none.
    """
    known = (*NAMES, *OFFLINE)
    if name in known:
        experiment = importlib.import_module(f"experiments.{name.replace('-', '_')}").EXPERIMENT
    elif is_file(name):
        experiment = declared(Path(name), "EXPERIMENT")
    else:
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.0)[0]
        raise UsageError(f"unknown experiment '{name}': known are {', '.join(known)} (nearest: {near}), or a .py file")
    if not isinstance(experiment, Experiment | OfflineExperiment):
        raise UsageError(f"{name}: EXPERIMENT is a {type(experiment).__name__}, expected an Experiment")
    unknown = [claim for claim in experiment.claims if claim not in claim_texts()]
    if unknown:
        raise UsageError(f"{name}: unknown claim '{unknown[0]}': known are {', '.join(claim_texts())}")
    if isinstance(experiment, OfflineExperiment):
        others = [claim for claim in experiment.claims if claim not in JUDGES]
        if others:
            raise UsageError(f"{name}: no clips answer for claim '{others[0]}': those of clips are {', '.join(JUDGES)}")
    return experiment
