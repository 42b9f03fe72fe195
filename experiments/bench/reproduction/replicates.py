"""Replicates of the paper's design with the robot, and what each claim comes to in them.

A claim is judged on the trials of the same experiment in every replicate (`robustness.judged_in`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from experiments.bench.judging.statistics import proportion_interval
from experiments.bench.judging.verdict import Outcome
from experiments.bench.reproduction.robustness import LOOMING_DETECTORS, MODEL, ROBOT_CLAIMS, Case, judged_in, numbered
from experiments.bench.robot.claims import find, outcome
from experiments.bench.robot.experiment import TrialSpec

Row = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Replicate:
    """The paper's design, run once at one seed.

    Parameters
    ----------
    rows
        The rows of ``trials.parquet`` of all its experiments and models.
    lost
        (experiment, model) -> how many of its trials have no row, as they failed; 0 of none.
    thresholds
        Each model's spiking threshold.
    """

    rows: tuple[Row, ...]
    lost: Mapping[tuple[str, str], int]
    thresholds: Mapping[str, float | None]

    def of(self, model: str) -> list[Row]:
        """Return the rows of one model."""
        return [row for row in self.rows if row["model"] == model]


def replicate(specs: Sequence[TrialSpec], rows: Sequence[Row]) -> Replicate:
    """Return the replicate that ``specs`` planned, from the ``rows`` that there are; those of other trials are left."""
    planned = {(spec.experiment, spec.index, model.label): model for spec in specs for model in spec.settings.models}
    own = {(row["experiment"], row["trial"], row["model"]): row for row in rows}
    lost = Counter((experiment, model) for experiment, index, model in planned.keys() - own.keys())
    thresholds = {model.label: model.threshold for model in planned.values()}
    return Replicate(tuple(own[key] for key in planned if key in own), lost, thresholds)


def studied(cases: Sequence[Case], rows: Sequence[Row]) -> list[Replicate]:
    """Return a replicate for each case of a study; ``rows`` are those of its `robustness.numbered` trials."""
    specs, found = numbered(cases), []
    for case in cases:
        own, specs = specs[: len(case.specs)], specs[len(case.specs) :]
        found.append(replicate(own, rows))
    return found


def judged(claim: str, own: Replicate) -> Outcome:
    """Judge a claim in one replicate: for the DSNN, for the models it compares, or for each looming detector."""
    if find(claim).models:
        return of_several(claim, own)
    if find(claim).about == "looming":
        return Outcome.together({name: of_model(claim, own, name) for name in LOOMING_DETECTORS})
    return of_model(claim, own, MODEL)


def of_several(claim: str, own: Replicate) -> Outcome:
    """Judge a claim that compares models in one replicate. It is not judged where any of the trials it needs failed."""
    place, asked = judged_in()[claim], find(claim)
    rows = [row for row in own.rows if row["experiment"] == place]
    found = outcome(claim, rows, own.thresholds.get(asked.spiking))
    lost = sum(own.lost.get((place, model), 0) for model in asked.models)
    return found.withheld(f"{lost} trials of {place} failed") if lost and found.verdict != "not shown" else found


def of_model(claim: str, own: Replicate, model: str) -> Outcome:
    """Judge a claim for one model in one replicate. It is not judged where any of the trials it needs failed."""
    if model not in own.thresholds:
        return Outcome.unjudged(f"{model} was not shown")
    place, shown = judged_in()[claim], own.of(model)
    rows = [row for row in shown if row["experiment"] == place]
    found = outcome(claim, rows, own.thresholds[model], shown)
    lost = own.lost.get((place, model), 0)
    return found.withheld(f"{lost} trials of {place} failed") if lost and found.verdict != "not shown" else found


def pooled(claim: str, replicates: Sequence[Replicate]) -> Outcome:
    """Judge a claim on the trials of all replicates together."""
    rows = tuple(row for each in replicates for row in each.rows)
    lost = sum((Counter(each.lost) for each in replicates), Counter[tuple[str, str]]())
    return judged(claim, Replicate(rows, lost, replicates[0].thresholds))


def rate(claim: str, whole: Outcome) -> str:
    """Say which share of all trials breaks a claim about every single one, with its exact 95 % interval.

    Parameters
    ----------
    claim
        The claim's id.
    whole
        The claim on the trials of all replicates.

    Returns
    -------
    str
        Empty where the claim is not about every single trial.
    """
    if whole.broken is None or not find(claim).of_every_trial or not whole.n:
        return ""
    low, high = proportion_interval(whole.broken, whole.n)
    return (
        f"{whole.broken} of {whole.n} trials break it, {whole.broken / whole.n:.1%} (exact 95 % interval {low:.1%} to "
        f"{high:.1%})"
    )


def survival(cases: Sequence[Case], rows: Sequence[Row], defaults: Replicate) -> dict[str, dict[str, Outcome]]:
    """Return what was moved -> claim -> its outcome in one whole replicate, the defaults first."""
    found = {MODEL: {claim: of_model(claim, defaults, MODEL) for claim in ROBOT_CLAIMS}}
    for case, own in zip(cases, studied(cases, rows), strict=True):
        for label in case.moved or (MODEL,):
            name = label if case.moved else case.name
            found[name] = {claim: of_model(claim, own, label) for claim in ROBOT_CLAIMS}
    return found
