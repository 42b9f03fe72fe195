"""What a sweep comes to: claims and measures at every point of a grid, in replicates, from the rows of its trials.

Each measure is a short function from the rows of a point to a number. A new one is an entry of `MEASURES`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
import polars as pl

from dsnn.stimuli import ClipParams
from experiments.base.errors import UsageError, check_known
from experiments.declare.claim import POTENTIALS, Claim
from experiments.declare.conditions import CONDITION_COLUMNS, Condition
from experiments.declare.outcome import MARGIN, Outcome, together, unreadable
from experiments.declare.study import TOGETHER, Levels, Study
from experiments.judge.judge import flaws
from experiments.judge.replicates import Replicate, judged, places_of
from experiments.judge.tests import summarise
from experiments.judge.verdict import count, count_columns
from experiments.settings.grid import Point, values_of
from experiments.settings.models import ConfiguredModel
from experiments.settings.parameters import Parameters
from experiments.store.tables import finite, group

Rows = Sequence[Mapping[str, Any]]

LEAST_SPEEDS = 3
"""Fewer have no speed between the first and the last, where a peak would be one."""


Number = Mapping[str, Any]
"""A number at a point: its ``value``, ``None`` where there is none; of a mean ``n``, ``ci_low`` and ``ci_high`` too."""
Measure = tuple[str, str, Mapping[str, Any]]
"""A measure's name, the experiment that gives it, and the columns of the one condition that it is about, if it is."""


def _crossings(conditions: Sequence[Any]) -> bool:
    """Return whether the rightward crossings among conditions differ in speed alone, and have enough speeds."""
    crossings = [
        condition for condition in conditions
        if isinstance(condition, Condition) and (condition.motion, condition.direction) == ("translation", "rightward")
    ]  # fmt: skip
    others = [name for name in CONDITION_COLUMNS if name != "speed_cm_s"]
    alike = {tuple(getattr(condition, name) for name in others) for condition in crossings}
    return len(alike) == 1 and len({condition.speed_cm_s for condition in crossings}) >= LEAST_SPEEDS


def peak_speed(rows: Rows, *, column: str) -> Number:
    """Find the speed among those shown at which the mean of a column over trials is largest.

    Parameters
    ----------
    rows
        Of ``trials.parquet``, of one model; rightward crossings count.
    column
        What is averaged over the trials of a speed.

    Returns
    -------
    Number
        In cm/s; of equal means the lowest speed. None where no mean is above 0, and where trials are not what their
        conditions have. At an end of the speeds shown the true peak may lie beyond.
    """
    crossings = [row for row in rows if (row["motion"], row["direction"]) == ("translation", "rightward")]
    if not crossings or unreadable(crossings, [column]) or flaws(crossings):
        return {"value": None}
    by_speed = sorted(group(crossings, "speed_cm_s").items())
    means = {speed: float(np.mean([row[column] for row in of_speed])) for (speed,), of_speed in by_speed}
    highest = max(means, key=means.__getitem__)
    return {"value": highest if means[highest] > 0.0 else None}


def _rightward(clips: Sequence[Any]) -> bool:
    """Return whether a clip shows an object that moves rightward."""
    return any(
        isinstance(params, ClipParams) and getattr(params, "motion", "") == "rightward"
        and getattr(params, "object", "") != "absent"
        for params in clips
    )  # fmt: skip


def least_peak(rows: Rows) -> Number:
    """Find the largest HS of a rightward crossing: of several crossings the lowest of their peaks.

    Parameters
    ----------
    rows
        Of ``trials.parquet`` of clips, of one model; rightward crossings of an object count.

    Returns
    -------
    Number
        The potential. None where there is no crossing, or a potential is not a number.
    """
    crossings = [row for row in rows if row["motion"] == "rightward" and row["object"] != "absent"]
    if not crossings or unreadable(crossings, POTENTIALS):
        return {"value": None}
    return {"value": min(float(row["peak_hs"]) for row in crossings)}


def mean_of(rows: Rows, *, column: str, within: Sequence[float] = ()) -> Number:
    """Compute the mean of a column over trials, and its 95 % interval.

    Parameters
    ----------
    rows
        Of ``trials.parquet``, of one model; of spikes also of one condition.
    column
        What is averaged.
    within
        Its least possible value, and its largest.

    Returns
    -------
    Number
        None where no trial has a value, as spikes of a model that does not spike.
    """
    values = [row[column] for row in rows if row[column] is not None]
    if not values:
        return {"value": None, "n": len(rows)}
    score = summarise(values, *within)
    ends = {"ci_low": finite(score.low), "ci_high": finite(score.high)}
    return {"value": score.value, "n": len(rows), **ends}


def gain_slope(rows: Rows) -> Number:
    """Compute how the gain against the true flow changes with the stimulus's speed: a line by least squares.

    Parameters
    ----------
    rows
        Of ``trials.parquet``, of one model.

    Returns
    -------
    Number
        In 1/px per cm/s. None with fewer than two speeds.
    """
    pairs = [(row["speed_cm_s"], row["true_gain"]) for row in rows if row["true_gain"] is not None]
    if len({speed for speed, _ in pairs}) < 2:
        return {"value": None}
    table = np.array(pairs, np.float64)
    return {"value": float(np.polyfit(table[:, 0], table[:, 1], 1)[0])}


def _with_robot(shown: Sequence[Any]) -> bool:
    """Return whether what is shown are trials with the robot."""
    return isinstance(shown[0], Condition)


TRUE = "true-"
"""Beginning of the measures whose trials need truth."""
SPIKES = "spikes"
"""The measure that is one of each condition: the mean number of spikes in a trial."""


class Quantity(NamedTuple):
    """What a measure is: its function of the rows of a point, the experiments that give it, and its unit."""

    of: Callable[[Rows], Number]
    given_by: Callable[[Sequence[Any]], bool]
    """Whether an experiment's conditions, or its clips, give it."""
    unit: str = ""


MEASURES: Mapping[str, Quantity] = {
    "peak-speed-potential": Quantity(partial(peak_speed, column="mean_hs_near_axis"), _crossings, "cm/s"),
    "peak-speed-count": Quantity(partial(peak_speed, column="spikes"), _crossings, "cm/s"),
    "peak-hs": Quantity(least_peak, _rightward),
    SPIKES: Quantity(partial(mean_of, column="spikes", within=(0.0,)), _with_robot),
    "true-r": Quantity(partial(mean_of, column="true_hs_flow_r", within=(-1.0, 1.0)), _with_robot),
    "true-view-r": Quantity(partial(mean_of, column="true_hs_view_r", within=(-1.0, 1.0)), _with_robot),
    "true-vs-r": Quantity(partial(mean_of, column="true_vs_flow_r", within=(-1.0, 1.0)), _with_robot),
    "true-vs-view-r": Quantity(partial(mean_of, column="true_vs_view_r", within=(-1.0, 1.0)), _with_robot),
    "true-sign": Quantity(partial(mean_of, column="true_sign", within=(0.0, 1.0)), _with_robot),
    "true-gain": Quantity(partial(mean_of, column="true_gain"), _with_robot, "1/px"),
    "true-gain-slope": Quantity(gain_slope, _with_robot, "1/px per cm/s"),
}
"""Name after ``--measure`` -> what it is."""


def quantity(name: str) -> Quantity:
    """Return the quantity of a measure, which may be one of a condition: ``spikes: speed_cm_s=2``."""
    return MEASURES[name.partition(":")[0]]


def measured(name: str, condition: Mapping[str, Any], rows: Rows) -> Number:
    """Return a measure at a point from its rows: those with the columns of ``condition`` count."""
    own = [row for row in rows if all(row[column] == value for column, value in condition.items())]
    return quantity(name).of(own)


def by_condition(conditions: Sequence[Condition]) -> dict[str, dict[str, Any]]:
    """Return a measure for each condition, the mean number of spikes in its trials, with the condition's columns.

    Each is called by the columns in which conditions differ.
    """
    every = [{name: getattr(condition, name) for name in CONDITION_COLUMNS} for condition in dict.fromkeys(conditions)]
    varied = [name for name in CONDITION_COLUMNS if len({columns[name] for columns in every}) > 1]
    measures = {}
    for columns in every:
        values = {name: columns[name] for name in varied}
        texts = [f"{name}={value:g}" if isinstance(value, float | int) else f"{name}={value}"
                 for name, value in values.items()]  # fmt: skip
        measures[f"{SPIKES}: {', '.join(texts)}" if texts else SPIKES] = columns
    return measures


def chosen(
    wanted: Sequence[str], conditions: Mapping[str, Sequence[Sequence[Any]]], models: Sequence[ConfiguredModel]
) -> list[Measure]:
    """Return measures by their names, each with the first experiment that gives it.

    Parameters
    ----------
    wanted
        Names of `MEASURES`.
    conditions
        Name of an experiment -> its conditions, or its clips' parameters, wherever a point changes them.
    models
        The models judged.

    Raises
    ------
    UsageError
        A measure is not known, none of the experiments gives it at all points, or no model responds by ``hs``.
    """
    found: list[Measure] = []
    giving: Sequence[Measure]
    for name in dict.fromkeys(wanted):
        check_known("--measure", name, MEASURES)
        places = [place for place, shown in conditions.items() if all(map(MEASURES[name].given_by, shown))]
        if name == SPIKES:
            every = {place: [one for some in conditions[place] for one in some] for place in places}
            giving = [(measure, place, columns) for place, of_it in every.items()
                      for measure, columns in by_condition(of_it).items()]  # fmt: skip
        else:
            if not any("hs" in model.channels for model in models):
                raise UsageError(f"--measure {name}: it is about models that respond by direction")
            giving = [(name, place, {}) for place in places[:1]]
        if not giving:
            raise UsageError(f"--measure {name}: none of {', '.join(conditions)} shows what it is of at every point")
        found += giving
    return found


MOST_SLACK = 100.0
"""Slack at which each claim is clipped, in smallest differences."""


Share = tuple[range, Mapping[str, ConfiguredModel]]
"""Numbers of trials, and the models that see them at a point by their names without the grid's values."""
ClaimAt = Callable[[Claim, Mapping[str, str]], Claim]
Tables = Mapping[str, list[dict[str, Any]]]
Fewer = Callable[[Mapping[str, str]], int]
Play = Callable[[Study, int], "Sweep"]
"""Plays a study at a seed, in a folder of its name within that of a sweep."""
Then = Callable[["Sweep", Play], Tables]


def slack(outcome: Outcome) -> float | None:
    """Return how far inside its bounds a claim lies in one replicate, in smallest differences.

    That is slack over the smallest difference a claim may rest on: of potentials where the reading has no unit,
    otherwise 1 of the unit. It is the least over its checks, from -`MOST_SLACK` to `MOST_SLACK`; ``None`` where the
    claim could not be judged.
    """
    if not outcome.judged or not outcome.checks:
        return None
    shares = [check.slack / MARGIN["spikes" if check.unit else "potential"] for check in outcome.checks]
    return float(np.clip(min(-MOST_SLACK if math.isnan(share) else share for share in shares), -MOST_SLACK, MOST_SLACK))


@dataclass(frozen=True)
class Sweep:
    """A sweep, checked; of one that was played the replicates too, and the tables of what they come to.

    Parameters
    ----------
    study
        What was asked for.
    claims, measures
        Claims and measures, each with the name of the experiment that it is judged on.
    axes
        Name of each axis -> its levels; the last axis goes fastest.
    judged
        Points, each with the name of a model that is judged there.
    seed
        Of replicate 0.
    specs
        Every trial, one replicate after the other.
    shares
        (point, model, experiment, replicate) -> the trials that count there.
    repeats
        Trials of each condition in a replicate, of each experiment.
    fixed
        Points with the experiments in which nothing is random there: replicate 0 alone is run, and stands for all.
    resolved
        What ``run.json`` has of it.
    parameters
        The parameters that have columns in ``trials.parquet``.
    replicates
        Point and model -> its replicates; empty before it is played.
    failures
        What failed.
    claim_at
        Makes the claim that is judged at a point, from the claim and the point's levels by axis.
    further
        Makes further tables of a sweep that was played: a list of rows by title.
    fewer
        Number of replicates at a point, by its levels, where that may be less than the study's.
    then
        Makes further tables that need further sweeps, which it plays.
    """

    study: Study
    claims: tuple[tuple[Claim, str], ...]
    measures: tuple[Measure, ...]
    axes: Mapping[str, Levels]
    judged: tuple[tuple[Point, str], ...]
    seed: int
    specs: tuple[Any, ...]
    shares: Mapping[tuple[Point, str, str, int], Share]
    repeats: Sequence[int]
    fixed: frozenset[tuple[Point, str]]
    resolved: Mapping[str, Any]
    parameters: Parameters
    replicates: Mapping[tuple[Point, str], Sequence[Replicate]] = field(default_factory=dict)
    failures: Sequence[Mapping[str, Any]] = ()
    claim_at: ClaimAt | None = None
    further: Callable[[Sweep], Tables] | None = None
    fewer: Fewer | None = None
    then: Then | None = None

    @property
    def experiments(self) -> tuple[str, ...]:
        """The names of the experiments whose trials it runs."""
        return tuple(dict.fromkeys(experiment for _, _, experiment, _ in self.shares))

    def replicates_at(self, point: Point) -> int:
        """Return the number of replicates at a point."""
        return min(self.study.replicates, self.fewer(dict(point)) if self.fewer else self.study.replicates)

    @cached_property
    def outcomes(self) -> dict[tuple[Point, str, str], tuple[Outcome, ...]]:
        """Point, model and claim -> the outcome in each replicate; of a grid of keys also that of all claims."""
        found: dict[tuple[Point, str, str], tuple[Outcome, ...]] = {}
        for (point, model), every in self.replicates.items():
            for claim, experiment in self.claims:
                asked = self.claim_at(claim, dict(point)) if self.claim_at else claim
                found[point, model, claim.id] = tuple(judged(asked, part, experiment, model) for part in every)
            if len(self.claims) > 1 and self.study.over:
                columns = zip(*(found[point, model, claim.id] for claim, _ in self.claims), strict=True)
                found[point, model, TOGETHER] = tuple(
                    Outcome(together([outcome.verdict for outcome in column]), "") for column in columns
                )
        return found

    @cached_property
    def table(self) -> pl.DataFrame:
        """A row for each point, model, claim and replicate: verdict, slack, what decided and what was measured.

        There is one replicate where nothing that the claim is judged on is random.
        """
        names = ("verdict", "decided", "measured", "effect", "n")
        on = {claim.id: experiment for claim, experiment in self.claims}
        rows = [
            {**self._at(point, model), "claim": claim, "experiment": on.get(claim, ""), "replicate": number,
             "seed": self.seed + number, **{name: getattr(outcome, name) for name in names},
             "slack": slack(outcome)}
            for (point, model, claim), outcomes in self.outcomes.items()
            for number, outcome in enumerate(outcomes[: None if self.is_random(point, claim) else 1])
        ]  # fmt: skip
        return pl.DataFrame(rows, infer_schema_length=None)

    def is_random(self, point: Point, claim: str) -> bool:
        """Return whether anything that a claim, or all of them, is judged on differs between replicates at a point."""
        asked = [(one, place) for one, place in self.claims if claim in (one.id, TOGETHER)]
        places = {name for one, place in asked for name in places_of(one, place, self.experiments)}
        return any((point, name) not in self.fixed for name in places)

    @cached_property
    def counts(self) -> pl.DataFrame:
        """A row for each point, model and claim: its counts, the exact 95 % interval and the verdict.

        ``decided`` and ``measured`` are those of replicate 0.
        """
        on, rows = {claim.id: experiment for claim, experiment in self.claims}, []
        for (point, model, claim), outcomes in self.outcomes.items():
            random, first = self.is_random(point, claim), outcomes[0]
            counted = count([one.verdict for one in outcomes[: None if random else 1]], random=random)
            rows.append({
                **self._at(point, model), "claim": claim, "experiment": on.get(claim, ""), **count_columns(counted),
                "decided": first.decided, "measured": first.measured,
            })  # fmt: skip
        return pl.DataFrame(rows, infer_schema_length=None)

    def _at(self, point: Point, model: str) -> dict[str, Any]:
        """Return the columns of a point and a model."""
        return {**{name: values_of(self.axes[name])[level] for name, level in point}, "model": model}

    @cached_property
    def numbers(self) -> pl.DataFrame:
        """A row for each point, model and measure, of the trials of all replicates together.

        ``lowest`` and ``highest`` are the ends of the values of replicates; ``n``, ``ci_low`` and ``ci_high`` are those
        of a mean.
        """
        rows = []
        for (point, model), every in self.replicates.items():
            for measure, experiment, condition in self.measures:
                whole = [
                    [row for row in part.of(model) if row["experiment"] == experiment]
                    if condition or not part.lost.get((experiment, model))
                    else []
                    for part in every[: 1 if (point, experiment) in self.fixed else None]
                ]
                each = [measured(measure, condition, part)["value"] for part in whole]
                known = [value for value in each if value is not None]
                rows.append({
                    **self._at(point, model), "measure": measure, "experiment": experiment,
                    **measured(measure, condition, [row for part in whole for row in part]),
                    "unit": quantity(measure).unit, "lowest": min(known, default=None),
                    "highest": max(known, default=None), "replicates": len(each),
                    "not shown": len(each) - len(known), **condition,
                })  # fmt: skip
        return pl.DataFrame(rows, infer_schema_length=None)

    def rows(self, point: Point, model: str) -> pl.DataFrame:
        """Return the rows of the trials of a point and a model in all replicates, with the column ``replicate``."""
        every = enumerate(self.replicates[point, model])
        rows = [{**row, "replicate": number} for number, part in every for row in part.rows
                if not number or (point, row["experiment"]) not in self.fixed]  # fmt: skip
        return pl.DataFrame(rows, infer_schema_length=None)

    @cached_property
    def tables(self) -> Tables:
        """The study's further tables."""
        return self.further(self) if self.further else {}

    def described(self) -> dict[str, Any]:
        """Return the contents of ``NAME.json``, of which figures and pages are made: counts and measures."""
        study = self.study
        why = {key[2]: outcomes[0].deciding for key, outcomes in self.outcomes.items()
               if not any(one.judged or one.verdict == "unknown constants" for one in outcomes)}  # fmt: skip
        return {
            "study": study.name, "summary": study.summary, "replicates": study.replicates, "repeats": self.repeats,
            "seed": self.seed, "axes": {name: list(levels) for name, levels in self.axes.items()},
            "named": not self.axes or bool(study.axes),  # its levels, by words and not by values
            "titles": {claim.id: claim.title for claim, _ in self.claims},
            "counts": self.counts.to_dicts(), "numbers": self.numbers.to_dicts(),
            "unjudged": {claim: text for claim, text in why.items() if claim != TOGETHER},
            "troubles": {claim: one.trouble for (_, _, claim), outcomes in self.outcomes.items() for one in outcomes
                         if one.trouble},
            "tables": self.tables, "failures": self.failures,
        }  # fmt: skip


def read(sweep: Sweep, rows: Sequence[Mapping[str, Any]], failures: Sequence[Mapping[str, Any]] = ()) -> Sweep:
    """Return a sweep with what it comes to, from the rows of ``trials.parquet`` that there are.

    Models go by their names without the grid's values.
    """
    by_trial = group(rows, "trial", "model")
    found: dict[tuple[Point, str], list[Replicate]] = {}
    for point, judge in sweep.judged:
        for number in range(sweep.replicates_at(point)):
            own: list[Mapping[str, Any]] = []
            lost = Counter[tuple[str, str]]()
            models: dict[str, Any] = {}
            for experiment in sweep.experiments:
                played = 0 if (point, experiment) in sweep.fixed else number
                numbers, seen = sweep.shares.get((point, judge, experiment, played), (range(0), {}))
                models |= seen
                for trial in numbers:
                    for name, model in seen.items():
                        there = by_trial.get((trial, model.label), ())
                        own += ({**row, "model": name} for row in there)
                        lost[experiment, name] += not there
            thresholds = {name: model.thresholds for name, model in models.items()}
            found.setdefault((point, judge), []).append(Replicate(tuple(own), lost, thresholds))
    return replace(sweep, replicates=found, failures=failures)
