"""Counts of a study, from its trials: in how many replicates each claim holds at each point, and the measures."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

from experiments.bench.sources.clip_claims import ClipClaim
from experiments.bench.sources.robot_claims import RobotClaim
from experiments.bench.stats.claim import Claim
from experiments.bench.stats.count import REASONS, Count, Reason, count
from experiments.bench.stats.verdict import Outcome, together
from experiments.bench.store.rows import Failure, group
from experiments.bench.studies.grid import Point
from experiments.bench.studies.measures import Measure
from experiments.bench.studies.plan import EVERY_MODEL, Share, StudyPlan
from experiments.bench.studies.replicates import Replicate, judged, of_clips, of_model
from experiments.bench.studies.study import Tables

Rows = Sequence[Mapping[str, Any]]
FORM = 1
"""Version of the form of ``NAME.json``."""

TOGETHER = "all"
"""Id of all claims of a map together, where there are several."""
SILENT, HALF = "v", "h"
SIGNS = {
    SILENT: "bounds kept in some replicate that does not count: the model answers no translation either",
    HALF: "the DSNN's half; the rest hangs on another model's constants, which are not known",
}
"""Sign after the count in a cell -> its meaning."""


@dataclass(frozen=True, slots=True)
class ClaimCell:
    """One claim of one model at one point, or all claims together there.

    Parameters
    ----------
    point, model
        The point and the model judged; `EVERY_MODEL` where the claim names its models.
    claim
        Id of the claim, or `TOGETHER`.
    experiment
        The experiment whose trials answer for it; empty of all claims together.
    outcomes
        The outcome of the claim in each replicate. All claims together hold in a replicate if each of them does.
    """

    point: Point
    model: str
    claim: str
    experiment: str
    outcomes: tuple[Outcome, ...]

    @property
    def count(self) -> Count:
        """The count of replicates in which it holds, fails, or could not be judged."""
        return count(outcome.verdict for outcome in self.outcomes)

    @property
    def drawn(self) -> Count:
        """The count that figure and table show: of a claim that hangs on unknown constants that of the DSNN's half."""
        return self.count.half or self.count

    @property
    def holds(self) -> bool:
        """Return whether what is shown of it holds in every replicate."""
        return self.drawn.holds == len(self.outcomes)

    @property
    def trouble(self) -> str:
        """Return what went wrong in a user's own judge, in any replicate; empty if nothing did."""
        return next((outcome.trouble for outcome in self.outcomes if outcome.trouble), "")

    def text(self) -> str:
        """Return the count as figure and table show it, with its `signs`."""
        return f"{self.drawn.holds}/{len(self.outcomes)}{''.join(self.signs)}"

    @property
    def signs(self) -> list[str]:
        """The signs of the cell, of `SIGNS`."""
        silent, half = self.count.unjudged.get("silent model"), self.count.half
        return [sign for sign, there in ((SILENT, silent), (HALF, half)) if there]

    @property
    def unjudged(self) -> tuple[Reason, ...]:
        """Why what is shown of it could not be judged in some replicate; a silent model has a sign instead."""
        return tuple(reason for reason in self.drawn.unjudged if reason != "silent model")


def in_digits(value: float) -> str:
    """Return a measure's value in three digits, from 100 on in four: 122.5 spikes are neither 122 nor 123."""
    return f"{value:.{4 if abs(value) >= 100 else 3}g}"


@dataclass(frozen=True, slots=True)
class Number:
    """One measure of one model at one point.

    Parameters
    ----------
    point, model
        The point and the model.
    measure
        The measure.
    experiment
        The experiment whose trials it is measured on.
    value
        Of the trials of all replicates together; ``None`` where there is none.
    lowest, highest
        Of the replicates' own values; ``None`` where there are none.
    mark
        What is to be known of the value, in a few words; empty if nothing is.
    unmeasured, replicates
        Replicates without a value, and all of them.
    words
        What the value was found from, or why there is none.
    n, low, high
        Of a mean: the number of trials, and its 95 % interval.
    """

    point: Point
    model: str
    measure: Measure
    experiment: str
    value: float | None
    lowest: float | None
    highest: float | None
    mark: str
    unmeasured: int
    replicates: int
    words: str
    n: int | None = None
    low: float | None = None
    high: float | None = None

    def text(self) -> str:
        """Return the value as figure and table show it."""
        return "-" if self.value is None else in_digits(self.value)


@dataclass(frozen=True)
class Counts:
    """The result of a study: counts and measures.

    Parameters
    ----------
    plan
        What was planned.
    rows
        The rows of its ``trials.parquet``.
    failures
        Trials that failed, and models that failed in a trial.
    given
        Replicates that were run for something else too, in place of the rows: (point, model) -> each of them.
    """

    plan: StudyPlan
    rows: Rows = ()
    failures: Sequence[Failure] = ()
    given: Mapping[tuple[Point, str], Sequence[Replicate]] = field(default_factory=dict)

    @cached_property
    def _by_trial(self) -> Mapping[tuple[Any, ...], Rows]:
        return group(self.rows, "trial", "model")

    @cached_property
    def _replicates(self) -> dict[tuple[Share, ...], Replicate]:
        return {}

    def replicate(self, point: Point, model: str, number: int) -> Replicate:
        """Return the trials of a point and a model in one replicate; the models go by their names without the grid."""
        shares = tuple(
            self.plan.shares[point, model, experiment, number]
            for experiment in self.plan.experiments
            if (point, model, experiment, number) in self.plan.shares
        )
        if shares not in self._replicates:  # points may have their trials in common
            self._replicates[shares] = self._of(shares)
        return self._replicates[shares]

    def replicates(self, point: Point, model: str) -> list[Replicate]:
        """Return all replicates of a point and a model."""
        if self.given:
            return list(self.given[point, model])
        return [self.replicate(point, model, number) for number in range(self.plan.replicates)]

    def _of(self, shares: Sequence[Share]) -> Replicate:
        rows: list[Mapping[str, Any]] = []
        lost: Counter[tuple[str, str]] = Counter()
        for share in shares:
            for trial in share.trials:
                for watcher in share.watchers:
                    trial_rows = self._by_trial.get((trial, watcher.label), ())
                    lost[share.experiment, watcher.name] += not trial_rows
                    rows += ({**row, "model": watcher.name} for row in trial_rows)
        watchers = [watcher for share in shares for watcher in share.watchers]
        return Replicate(
            tuple(rows), {key: number for key, number in lost.items() if number},
            {watcher.name: watcher.threshold for watcher in watchers},
            {watcher.name: watcher.looming for watcher in watchers},
        )  # fmt: skip

    @cached_property
    def cells(self) -> list[ClaimCell]:
        """The counts of every claim, at every point and of every model; of a map then of all claims together."""
        plan, cells = self.plan, []
        seen: dict[tuple[int, str, str], Outcome] = {}
        for point, model in plan.judged:
            point_cells: list[ClaimCell] = []
            for claim, experiment in plan.claims:
                asked = plan.study.claim_at(claim, dict(point.values)) if plan.study.claim_at else claim
                outcomes = []
                for replicate in self.replicates(point, model):
                    key = (id(replicate), claim.id, model)
                    if key not in seen or plan.study.claim_at:
                        seen[key] = _outcome(asked, replicate, model, experiment)
                    outcomes.append(seen[key])
                point_cells.append(ClaimCell(point, model, claim.id, experiment, tuple(outcomes)))
            cells += point_cells
            if len(point_cells) > 1 and plan.study.over:
                whole = tuple(
                    Outcome(together([outcome.verdict for outcome in column]), "")
                    for column in zip(*(cell.outcomes for cell in point_cells), strict=True)
                )
                cells.append(ClaimCell(point, model, TOGETHER, "", whole))
        return cells

    @cached_property
    def numbers(self) -> list[Number]:
        """The measures at every point, of every model."""
        return [
            self._number(measure, experiment, point, model)
            for point, model in self.plan.judged
            for measure, experiment in self.plan.measures
        ]

    def values(self, measure: Measure, experiment: str, point: Point, model: str) -> list[float | None]:
        """Return the value of a measure in each replicate; ``None`` where trials are lost, or it has none there."""
        rows, _ = self._measurable(measure, experiment, point, model)
        threshold = self.replicates(point, model)[0].thresholds[model]
        return [None if part is None else measure.of(part, threshold).value for part in rows]

    def _measurable(
        self, measure: Measure, experiment: str, point: Point, model: str
    ) -> tuple[list[list[Mapping[str, Any]] | None], str]:
        """Return the rows of each replicate that a measure is taken of; and what is lost, in words, the last."""
        whole: list[list[Mapping[str, Any]] | None] = []
        why = ""
        for number, replicate in enumerate(self.replicates(point, model)):
            lost = replicate.lost.get((experiment, model), 0)
            if lost:
                of = len(self.plan.shares[point, model, experiment, number].trials)
                why = f"{lost} of {of} {self.plan.things} have no rows"
            known = not lost or bool(measure.conditions)
            rows = [row for row in replicate.of(model) if row["experiment"] == experiment] if known else None
            whole.append(rows)
        return whole, why

    def _number(self, measure: Measure, experiment: str, point: Point, model: str) -> Number:
        """Compute one measure at one point, on the replicates of which no trial is lost."""
        parts, why = self._measurable(measure, experiment, point, model)
        threshold = self.replicates(point, model)[0].thresholds[model]
        values = [value for value in self.values(measure, experiment, point, model) if value is not None]
        whole = [row for part in parts if part for row in part]
        pooled = measure.of(whole, threshold) if whole else None
        words = "; ".join(filter(None, (why, pooled.words if pooled else "")))
        lowest, highest = (min(values), max(values)) if values else (None, None)
        number_of = Number(
            point, model, measure, experiment, pooled.value if pooled else None, lowest, highest,
            pooled.mark if pooled else "", len(parts) - len(values), len(parts), words,
        )  # fmt: skip
        return replace(number_of, n=pooled.n, low=pooled.low, high=pooled.high) if pooled else number_of

    def cell(self, claim: str, model: str = "", **levels: str) -> ClaimCell:
        """Return the cell of a claim; ``model`` and ``levels`` where there are several of these."""
        return next(
            cell
            for cell in self.cells
            if cell.claim == claim
            and (not model or cell.model == model)
            and all(dict(cell.point.values)[axis] == label for axis, label in levels.items())
        )

    @cached_property
    def tables(self) -> Tables:
        """The study's further tables."""
        return self.plan.study.tables(self) if self.plan.study.tables else {}

    def table(self) -> list[dict[str, Any]]:
        """Return the rows of ``counts.csv``: the values of the axes, and a claim's counts or a measure's number."""
        several = {"model": True} if len({model for _, model in self.plan.judged}) > 1 else {}
        of_claims = [
            {
                **self._values(cell.point), **({"model": cell.model} if several else {}), "claim": cell.claim,
                "experiment": cell.experiment, **count_columns(cell.count), "decided": cell.outcomes[0].decided,
                "measured": cell.outcomes[0].measured,
            }
            for cell in self.cells
        ]  # fmt: skip
        of_measures = [
            {
                **self._values(number.point), **({"model": number.model} if several else {}),
                "measure": number.measure.name, "experiment": number.experiment, "value": number.value,
                "unit": number.measure.unit, "lowest": number.lowest, "highest": number.highest,
                **({} if number.n is None else {"n": number.n, "ci_low": number.low, "ci_high": number.high}),
                "mark": number.mark, "replicates": number.replicates, "not shown": number.unmeasured,
                "measured": number.words,
                **dict(number.measure.conditions),
            }
            for number in self.numbers
        ]  # fmt: skip
        rows: list[dict[str, Any]] = [*of_claims, *of_measures]
        names = list(dict.fromkeys(name for row in rows for name in row))
        return [{name: row.get(name) for name in names} for row in rows]

    def described(self) -> dict[str, Any]:
        """Return what ``NAME.json`` holds, which the report shows: the counts, and further tables."""
        study = self.plan.study
        return {
            "form": FORM,
            "study": study.name,
            "summary": study.summary,
            "axes": [axis.name for axis in self.plan.axes],
            "models": [model.label for model in self.plan.models],
            "claims": [claim.id for claim, _ in self.plan.claims],
            "replicates": self.plan.replicates,
            "repeats": list(self.plan.repeats),
            "seed": self.plan.seed,
            "counts": [
                {
                    "point": dict(cell.point.values), "model": cell.model, "claim": cell.claim,
                    "experiment": cell.experiment, **count_columns(cell.count), "decided": cell.outcomes[0].decided,
                    "measured": cell.outcomes[0].measured,
                }
                for cell in self.cells
            ],
            "tables": self.tables,
            "failures": self.failures,
        }  # fmt: skip

    def _values(self, point: Point) -> dict[str, float | str]:
        """Return the values of the axes at a point."""
        return {axis.name: axis.value(label) for axis, (_, label) in zip(self.plan.axes, point.values, strict=True)}


def count_columns(counted: Count) -> dict[str, Any]:
    """Return a count as columns: ``holds``, ``fails``, each reason, all replicates, the interval and the word."""
    low, high = counted.interval or (None, None)
    reasons = {str(reason): counted.unjudged.get(reason, 0) for reason in REASONS}
    return {"holds": counted.holds, "fails": counted.fails, **reasons, "replicates": counted.replicates, "low": low,
            "high": high, "word": counted.word}  # fmt: skip


def count_of(columns: Mapping[str, Any]) -> Count:
    """Return the count whose columns these are: see `count_columns`."""
    unjudged = {reason: columns[reason] for reason in REASONS if columns.get(reason)}
    return Count(columns["holds"], columns["fails"], unjudged)


def _outcome(claim: Claim, replicate: Replicate, model: str, experiment: str) -> Outcome:
    """Judge one claim for one model in one replicate."""
    if model == EVERY_MODEL:
        return judged(claim, replicate, experiment)
    if isinstance(claim, ClipClaim):
        return of_clips(claim, replicate, experiment)
    assert isinstance(claim, RobotClaim)
    return of_model(claim, replicate, model, experiment)


def regions(cells: Sequence[ClaimCell]) -> list[str]:
    """Return how much of the grid each claim holds on, and all together, a line each."""
    lines = []
    for title, chosen in by_claim(cells).items():
        whole = sum(cell.holds for cell in chosen)
        share = f"at {whole} of {len(chosen)} points ({whole / len(chosen):.0%})"
        unjudged = sum(bool(cell.unjudged) for cell in chosen)
        silent = sum("silent model" in cell.count.unjudged for cell in chosen)
        also = f"; not judged in every replicate at {unjudged}" if unjudged else ""
        also += f"; kept by a silent model in a replicate at {silent}" if silent else ""
        of = len(chosen[0].outcomes)
        every = f"in {of} of {of} replicates" if of > 1 else "in the one replicate"
        who = "all claims together hold" if chosen[0].claim == TOGETHER else f"{title} holds"
        lines.append(f"{who} {every} {share}{also}")
    return lines


def by_claim(cells: Sequence[ClaimCell]) -> dict[str, list[ClaimCell]]:
    """Return the cells of each claim, in order; of several models those of each under a title that names it."""
    several = len({cell.model for cell in cells}) > 1
    groups: dict[str, list[ClaimCell]] = {}
    for cell in cells:
        groups.setdefault(f"{cell.claim}, {cell.model}" if several else cell.claim, []).append(cell)
    return groups


def reaches(numbers: Sequence[Number]) -> list[str]:
    """Return from where to where each measure goes over the grid, and at how many points what is to be known."""
    lines = []
    for name, chosen in by_measure(numbers).items():
        values = [number.value for number in chosen if number.value is not None]
        unit = f" {chosen[0].measure.unit}" if chosen[0].measure.unit else ""
        parts = [f"{name} is {min(values):.3g} to {max(values):.3g}{unit}" if values else f"{name} has no value"]
        marks = [number.mark for number in chosen if number.mark]
        parts += [f"{mark} at {marks.count(mark)} of {len(chosen)} points" for mark in dict.fromkeys(marks)]
        without = sum(number.value is None for number in chosen)
        parts += [f"no value at {without} of {len(chosen)}"] if without and values else []
        lines.append("; ".join(parts))
    return lines


def by_measure(numbers: Sequence[Number]) -> dict[str, list[Number]]:
    """Return the numbers of each measure, in order; of several models those of each under a title that names it."""
    several = len({number.model for number in numbers}) > 1
    groups: dict[str, list[Number]] = {}
    for number in numbers:
        groups.setdefault(f"{number.measure.name}, {number.model}" if several else number.measure.name, []).append(
            number
        )
    return groups
