"""Which claims and measures of which experiment a map shows, from what was typed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeVar

from experiments.bench.engine.errors import UsageError
from experiments.bench.judging.claim import Claim
from experiments.bench.judging.claim_files import PAPER, claim_ids
from experiments.bench.maps.measures import MEASURES, Measure
from experiments.bench.maps.plan import Asked

AnyClaim = TypeVar("AnyClaim", bound=Claim)
Chosen = tuple[tuple[AnyClaim, str], ...]
"""Claims, each with the name of the experiment that answers for it."""


def check_names(names: Sequence[str]) -> None:
    """Raise `UsageError` for an experiment that is there twice."""
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise UsageError(f"experiment {twice}: it is there twice")


def claims(
    experiments: Sequence[Any], asked: Asked, find: Callable[[Any], AnyClaim], refused: Callable[[AnyClaim], str]
) -> Chosen[AnyClaim]:
    """Return the claims of a map with the experiments that answer for them: of those given the first that declares it.

    Parameters
    ----------
    experiments
        Declarations of one kind.
    asked
        What was asked for. With neither claims nor measures it is all claims that are not refused.
    find
        Returns a claim of this kind by its id.
    refused
        Why a claim is not about the model judged, in words; empty if it is.

    Raises
    ------
    UsageError
        A claim is not known, not declared there, or refused, or there is none.
    """
    declared: dict[str, tuple[AnyClaim, str]] = {}
    for experiment in experiments:
        for claim in map(find, experiment.claims):
            declared.setdefault(claim.id, (claim, experiment.name))
    about = [name for name, (claim, _) in declared.items() if not refused(claim)]
    for name in asked.claims:
        if name not in declared and name not in claim_ids(PAPER):
            raise UsageError(f"--claims {name}: unknown claim; declared there are {_listed(about)}")
        if name not in declared:
            raise UsageError(f"--claims {name}: not declared by {_names(experiments)}, which declare {_listed(about)}")
        if name not in about:
            raise UsageError(f"--claims {name}: {refused(declared[name][0])}")
    chosen = list(dict.fromkeys(asked.claims or ([] if asked.measures else about)))
    if not chosen and not asked.measures:
        raise UsageError(f"{_names(experiments)}: no claim there is about {asked.model}")
    return tuple(declared[name] for name in chosen)


def measures(
    conditions: Mapping[str, Sequence[Any]], asked: Asked, kind: Literal["robot", "clips"], channels: Sequence[str]
) -> tuple[tuple[Measure, str], ...]:
    """Return the measures of a map with the experiments that answer for them: of those given the first that gives it.

    Parameters
    ----------
    conditions
        Name of an experiment -> its conditions, or its clips' parameters, without the grid's values.
    asked
        What was asked for.
    kind
        What the experiments show.
    channels
        What the model judged answers by.

    Raises
    ------
    UsageError
        A measure is not known, or none of the experiments gives it, or the model answers by no ``hs``.
    """
    chosen = []
    for name in dict.fromkeys(asked.measures):
        if name not in MEASURES:
            raise UsageError(f"--measure {name}: unknown measure; known are {', '.join(MEASURES)}")
        measure = MEASURES[name]
        if "hs" not in channels:
            raise UsageError(
                f"--measure {name}: it is about models that answer by direction, and {asked.model} does not"
            )
        giving = [each for each, own in conditions.items() if measure.kind == kind and measure.given_by(own)]
        if not giving:
            raise UsageError(f"--measure {name}: it needs {measure.needs}; {', '.join(conditions)} has none")
        chosen.append((measure, giving[0]))
    return tuple(chosen)


def check_given(found: Sequence[tuple[Measure, str]], experiment: str, conditions: Sequence[Any], where: str) -> None:
    """Raise `UsageError` for a measure that an experiment does not give at some points, which ``where`` names."""
    for measure, name in found:
        if name == experiment and not measure.given_by(conditions):
            raise UsageError(f"--measure {measure.name}: it needs {measure.needs}; {name} has none at {where}")


def _names(experiments: Sequence[Any]) -> str:
    return ", ".join(experiment.name for experiment in experiments)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) or "none"
