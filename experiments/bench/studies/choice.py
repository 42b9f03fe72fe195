"""Choice of the claims and measures that a study counts, and of their experiments."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeVar

from experiments.bench.run.errors import UsageError
from experiments.bench.stats.claim import PAPER, Claim, claim_ids
from experiments.bench.studies.measures import MEASURES, SPIKES, Measure, spikes_in
from experiments.bench.studies.study import Study

AnyClaim = TypeVar("AnyClaim", bound=Claim)
Chosen = tuple[tuple[AnyClaim, str], ...]
"""Claims, each with the name of the experiment that answers for it."""


def check_names(names: Sequence[str]) -> None:
    """Raise `UsageError` for an experiment that is there twice."""
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise UsageError(f"experiment {twice}: it is there twice")


def claims(
    experiments: Sequence[Any],
    study: Study,
    find: Callable[[Any], AnyClaim],
    refused: Callable[[AnyClaim], str],
    *,
    counts_spikes: bool = False,
) -> Chosen[AnyClaim]:
    """Return the claims of a study with the experiments that answer for them: the first that declares each.

    Parameters
    ----------
    experiments
        Declarations of one kind.
    study
        Says what is asked. With neither claims nor measures it is all claims that are not refused. A claim that is no
        id is judged on the experiment that declares it or one of its id, and else on the first.
    find
        Returns a claim of this kind by its id.
    refused
        Why a claim is not about the models judged, in words; empty if it is.
    counts_spikes
        Whether a study without claims and measures may count spikes.

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
    chosen: dict[str, tuple[AnyClaim, str]] = {}
    for asked in study.claims:
        name = asked.id if isinstance(asked, Claim) else asked
        if isinstance(asked, Claim):
            given = find(asked)
            chosen[name] = (given, declared[name][1] if name in declared else experiments[0].name)
        elif name not in declared and name not in claim_ids(PAPER):
            raise UsageError(f"--claims {name}: unknown claim; declared there are {_listed(about)}")
        elif name not in declared:
            by = f"{_names(experiments)}, which declare {_listed(about)}"
            raise UsageError(f"--claims {name}: not declared by {by}")
        else:
            chosen[name] = declared[name]
        if reason := refused(chosen[name][0]):
            raise UsageError(f"--claims {name}: {reason}")
    if not study.claims and not study.measures:
        chosen = {name: declared[name] for name in about}
        if not chosen and not counts_spikes:
            raise UsageError(f"{_names(experiments)}: no claim there is about {', '.join(study.models)}: name measures")
    return tuple(chosen.values())


def measures(
    conditions: Mapping[str, Sequence[Any]],
    study: Study,
    kind: Literal["robot", "clips"],
    channels: Sequence[str],
    *,
    of_spikes: bool = False,
) -> tuple[tuple[Measure, str], ...]:
    """Return the measures of a study with the experiments that answer for them: the first that gives each.

    Parameters
    ----------
    conditions
        Name of an experiment -> its conditions, or its clips' parameters, at all points.
    study
        Says what is asked.
    kind
        What the experiments show.
    channels
        What the models judged answer by.
    of_spikes
        Whether spikes are counted without being asked for, as there are neither claims nor measures.

    Raises
    ------
    UsageError
        A measure is not known, or none of the experiments gives it, or the models answer by no ``hs``.
    """
    chosen: list[tuple[Measure, str]] = []
    for name in dict.fromkeys((SPIKES,) if of_spikes else study.measures):
        if name == SPIKES and kind == "robot":
            chosen += [
                (measure, experiment) for experiment, offered in conditions.items() for measure in spikes_in(offered)
            ]
            continue
        if name not in MEASURES:
            raise UsageError(f"--measure {name}: unknown measure; known are {', '.join((*MEASURES, SPIKES))}")
        measure = MEASURES[name]
        if "hs" not in channels:
            who = f"{', '.join(study.models)} {'do' if len(study.models) > 1 else 'does'} not"
            raise UsageError(f"--measure {name}: it is about models that answer by direction, and {who}")
        giving = [
            experiment
            for experiment, offered in conditions.items()
            if measure.kind == kind and measure.given_by(offered)
        ]
        if not giving:
            raise UsageError(f"--measure {name}: it needs {measure.needs}; {', '.join(conditions)} has none")
        chosen.append((measure, giving[0]))
    return tuple(chosen)


def check_given(chosen: Sequence[tuple[Measure, str]], experiment: str, conditions: Sequence[Any], where: str) -> None:
    """Raise `UsageError` for a measure that an experiment does not give at some points, which ``where`` names."""
    for measure, name in chosen:
        if name == experiment and not measure.given_by(conditions):
            raise UsageError(f"--measure {measure.name}: it needs {measure.needs}; {name} has none at {where}")


def _names(experiments: Sequence[Any]) -> str:
    return ", ".join(experiment.name for experiment in experiments)


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) or "none"
