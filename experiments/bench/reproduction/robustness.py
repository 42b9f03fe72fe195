"""The paper's experiments with the robot: which there are, which models they show, and what answers for each claim."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from functools import cache

from experiments import NAMES
from experiments.bench import registry
from experiments.bench.robot.claims import find
from experiments.bench.studies.replicates import LOOMING_DETECTORS

SHOWN = ("distance-mechanism", "approach-mechanism", "recession-mechanism")
"""Experiments without claims that the report shows, at the headline's seed alone."""


@cache
def paper() -> tuple[str, ...]:
    """Return the experiments with the robot that declare claims of the paper, in the order of the registry."""
    return tuple(name for name in NAMES if any(isinstance(claim, str) for claim in registry.load(name).claims))


def moved() -> tuple[str, ...]:
    """Return those of `paper` that show one model: not those that compare moves of the network."""
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


def models_in(among: Collection[str] | None = None, beside: Sequence[str] = ()) -> dict[str, list[str]]:
    """Return each of `paper` with the models shown there in every replicate.

    Parameters
    ----------
    among
        Models to be shown; ``None``: all that claims need, and `MODEL`.
    beside
        Models that are shown in those of `moved` too.
    """
    return {
        name: [
            *(model for model in asked_models(name) if among is None or model in among),
            *(beside if name in moved() else ()),
        ]
        for name in paper()
    }
