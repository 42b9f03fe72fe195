"""What ships, by name: the only strings that name modules of ours. Each is ``module:NAME``, imported when asked for.

So machinery below `experiments.paper` finds what stands above it, and `colias list` imports no more than it shows.
"""

import importlib
from collections.abc import Mapping
from typing import Any

KINDS: Mapping[str, str] = {
    "trials": "experiments.kinds.trials:KIND",
    "clips": "experiments.kinds.clips:KIND",
    "episodes": "experiments.kinds.episodes:KIND",
    "watch": "experiments.kinds.footage:KIND",
    "measured": "experiments.kinds.log:KIND",
    "tuning": "experiments.kinds.tuning:KIND",
    "sweep": "experiments.kinds.sweep:KIND",
    "fit": "experiments.kinds.fit:KIND",
    "training": "experiments.kinds.training:KIND",
    "benchmark": "experiments.paper.benchmark.entry:KIND",
    "leaderboard": "experiments.paper.boards:KIND",
    "reproduction": "experiments.paper.reproduce:KIND",
}
"""Kind of run, as ``run.json`` has it -> its `experiments.kinds.result.Kind`."""

NAMES = (
    "general", "speed", "distance", "angular-approach", "angular-recession", "contrast", "clutter", "egomotion",
    "ensembles", "distance-mechanism", "approach-mechanism", "recession-mechanism", "speed-steps",
)  # fmt: skip
"""The experiments with the robot."""

OFFLINE = (
    "clean", "blocked", "clutter-depth", "clutter-translation", "clutter-speed", "clutter-frames", "clutter-contrast",
    "street", "edges", "apparent", "background-alone", "background", "constants-2017", "constants-emd",
)  # fmt: skip
"""The experiments with clips of stimuli."""

EXPERIMENTS: Mapping[str, str] = {
    **{name: f"experiments.{name.replace('-', '_')}:EXPERIMENT" for name in NAMES},
    **dict.fromkeys(OFFLINE, "experiments.paper.clips:EXPERIMENTS"),
}
"""Experiment -> its declaration; those with clips are listed in one file."""

BEHAVIOURS: Mapping[str, str] = {
    "behaviours": "experiments.paper.behaviours:BEHAVIOURS",
    "groups": "experiments.paper.behaviours:GROUPS",
    "references": "experiments.paper.behaviours:REFERENCE",
}
"""What is listed of behaviours -> the list: all by name, groups of them, and what a group is compared with."""

CLAIMS: Mapping[str, str] = {
    "robot": "experiments.paper.claims.robot",
    "clips": "experiments.paper.claims.clips",
    "footage": "experiments.paper.claims.footage",
    "behaviours": "experiments.paper.claims.behaviours",
}
"""What claims are judged on -> the module whose judges they have: importing it declares them."""

STUDIES: Mapping[str, str] = {
    "fidelity": "experiments.paper.studies.robot:FIDELITY",
    "why": "experiments.paper.studies.why:STUDY",
    "plausible": "experiments.paper.studies.plausible:STUDY",
    "plausible-pilot": "experiments.paper.studies.plausible:PILOT",
    "detectors": "experiments.paper.studies.detectors:STUDY",
    "onboard": "experiments.paper.studies.onboard:STUDY",
    "sensitivity": "experiments.paper.studies.robot:SENSITIVITY",
    "sensitivity-clips": "experiments.paper.studies.clips:SENSITIVITY",
    "background": "experiments.paper.studies.clips:BACKGROUND",
    "constants-2017": "experiments.paper.studies.clips:CONSTANTS_2017",
    "constants-emd": "experiments.paper.studies.clips:CONSTANTS_EMD",
}
"""Study -> its declaration. Missing is ``model-claims``, whose claims are each about a model."""

PLANS: Mapping[str, str] = {"studies": "experiments.paper.studies.plans:PLANS"}
"""What plans the studies of which a `Study` does not say all: study -> function of it and of what was asked."""


def kind_of(name: str) -> Any:
    """Return a kind of run, a `experiments.kinds.result.Kind`, by its name in ``run.json``."""
    return shipped(KINDS[name])


def shipped(place: str) -> Any:
    """Import what ``module:NAME`` names, or the module alone.

    Parameters
    ----------
    place
        A value of one of the tables here.

    Returns
    -------
    object
        The declaration.
    """
    module, colon, name = place.partition(":")
    imported = importlib.import_module(module)
    return getattr(imported, name) if colon else imported
