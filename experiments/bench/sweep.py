"""Sweeps: claims and measures at every point of a grid, in replicates of experiments with the robot or of clips."""

from __future__ import annotations

import dataclasses
import os
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import polars as pl

from experiments.bench import offline, trials
from experiments.bench.grid import Point
from experiments.bench.measures import Measure
from experiments.bench.replicates import Replicate, judged, of_clips, of_model
from experiments.bench.run.description import check_own
from experiments.bench.run.errors import UsageError
from experiments.bench.run.files import Files, new_folder
from experiments.bench.run.play import FRAMES, Trial, show, tabulate
from experiments.bench.run.rows import Failure, TrialRecord, drawn_here, group
from experiments.bench.run.runs import Batch, Resources, worker_count
from experiments.bench.sources import clips
from experiments.bench.sources.clip_claims import ClipClaim
from experiments.bench.sources.robot_claims import RobotClaim
from experiments.bench.sources.rows import FRAME_SCHEMA, TRIAL_SCHEMA
from experiments.bench.stats.count import count, count_columns
from experiments.bench.stats.verdict import Outcome, together
from experiments.bench.study import Study, called
from experiments.bench.sweep_plan import EVERY_MODEL, Plan, Share, planned

TOGETHER = "all"
"""Id of all claims of a grid of parameters together, where there are several."""
NAME = "sweep"
"""Name of a sweep that is no study."""
Rows = Sequence[Mapping[str, Any]]


def typed(
    experiments: str, over: Sequence[str], claims: Sequence[str], measures: Sequence[str], models: Sequence[str],
    assignments: Sequence[str], repeats: int | None, replicates: int,
) -> Study:  # fmt: skip
    """Return the study of experiments, joined by commas, that no file declares; the rest is as of `Study`."""
    names = tuple(name for name in experiments.split(",") if name)
    if not names:
        raise UsageError("EXPERIMENT: expected one name or more, joined by commas, for example general,speed")
    return Study(
        NAME, "claims and numbers over a grid of parameters", tuple(claims), tuple(measures), names, over=tuple(over),
        models=tuple(dict.fromkeys(models)), assignments=tuple(assignments), repeats=repeats, replicates=replicates,
        every_trial=False,
    )  # fmt: skip


@dataclass(frozen=True)
class Sweep:
    """The result of a sweep.

    Parameters
    ----------
    plan
        What was planned.
    rows
        The rows of its ``trials.parquet``.
    failures
        Trials that failed, and models that failed in a trial.
    given
        Replicates that were run for something else, in place of the rows: (point, model) -> each of them.
    """

    plan: Plan
    rows: Rows = ()
    failures: Sequence[Failure] = ()
    given: Mapping[tuple[Point, str], Sequence[Replicate]] = field(default_factory=dict)

    @cached_property
    def _by_trial(self) -> Mapping[tuple[Any, ...], Rows]:
        return group(self.rows, "trial", "model")

    @cached_property
    def _known(self) -> dict[Any, Any]:
        """Replicates by their trials, and outcomes by replicate: points may have both in common."""
        return {}

    def replicates(self, point: Point, model: str) -> list[Replicate]:
        """Return all replicates of a point and a model; the models go by their names without the grid."""
        if self.given:
            return list(self.given[point, model])
        found = []
        for number in range(self.plan.replicates):
            keys = [(point, model, experiment, number) for experiment in self.plan.experiments]
            shares = [self.plan.shares[key] for key in keys if key in self.plan.shares]
            known = tuple(
                (share.trials, tuple((name, shown.label) for name, shown in share.models.items())) for share in shares
            )
            if known not in self._known:
                self._known[known] = self._replicate(shares)
            found.append(self._known[known])
        return found

    def _replicate(self, shares: Sequence[Share]) -> Replicate:
        rows: list[Mapping[str, Any]] = []
        lost: Counter[tuple[str, str]] = Counter()
        for share in shares:
            for trial in share.trials:
                for name, model in share.models.items():
                    found = self._by_trial.get((trial, model.label), ())
                    lost[share.experiment, name] += not found
                    rows += ({**row, "model": name} for row in found)
        models = {name: model for share in shares for name, model in share.models.items()}
        return Replicate(
            tuple(rows), {key: number for key, number in lost.items() if number},
            {name: model.threshold for name, model in models.items()},
            {name: model.thresholds.get("looming") for name, model in models.items()},
        )  # fmt: skip

    @cached_property
    def outcomes(self) -> dict[tuple[Point, str, str], tuple[Outcome, ...]]:
        """Point, model and claim -> the outcome in each replicate; of a grid of keys also that of all claims."""
        plan, outcomes = self.plan, {}
        for point, model in plan.judged:
            for claim, experiment in plan.claims:
                outcomes[point, model, claim.id] = tuple(
                    self._outcome(claim, replicate, point, model, experiment)
                    for replicate in self.replicates(point, model)
                )
            if len(plan.claims) > 1 and plan.study.over:
                columns = zip(*(outcomes[point, model, claim.id] for claim, _ in plan.claims), strict=True)
                outcomes[point, model, TOGETHER] = tuple(
                    Outcome(together([outcome.verdict for outcome in column]), "") for column in columns
                )
        return outcomes

    def _outcome(self, claim: Any, replicate: Replicate, point: Point, model: str, experiment: str) -> Outcome:
        at = self.plan.study.claim_at
        key = (id(replicate), claim.id, model, point if at else ())
        if key not in self._known:
            asked = at(claim, dict(point)) if at else claim
            if model == EVERY_MODEL:
                self._known[key] = judged(asked, replicate, experiment)
            elif isinstance(asked, ClipClaim):
                self._known[key] = of_clips(asked, replicate, experiment)
            else:
                assert isinstance(asked, RobotClaim)
                self._known[key] = of_model(asked, replicate, model, experiment)
        outcome: Outcome = self._known[key]
        return outcome

    def _values(self, point: Point, model: str) -> dict[str, Any]:
        """Return the columns of a point and a model."""
        levels = zip(self.plan.axes, point, strict=True)
        return {**{axis.name: axis.value(label) for axis, (_, label) in levels}, "model": model}

    def _claimed(self, columns: Callable[[Sequence[Outcome]], list[dict[str, Any]]]) -> pl.DataFrame:
        """Return rows of each point, model and claim, from its outcomes in all replicates."""
        on = {claim.id: experiment for claim, experiment in self.plan.claims}
        rows = [
            {**self._values(point, model), "claim": claim, "experiment": on.get(claim, ""), **row}
            for (point, model, claim), outcomes in self.outcomes.items()
            for row in columns(outcomes)
        ]
        return pl.DataFrame(rows, infer_schema_length=None)

    @cached_property
    def table(self) -> pl.DataFrame:
        """The outcomes: a row for each point, model, claim and replicate, with what decided and what was measured."""
        names = ("verdict", "decided", "measured", "effect", "n")
        return self._claimed(lambda outcomes: [
            {"replicate": number, "seed": self.plan.seed + number, **{name: getattr(outcome, name) for name in names}}
            for number, outcome in enumerate(outcomes)
        ])  # fmt: skip

    @cached_property
    def counts(self) -> pl.DataFrame:
        """The counts: a row for each point, model and claim, with the exact 95 % interval and the word.

        ``decided`` and ``measured`` are those of replicate 0.
        """
        return self._claimed(lambda outcomes: [
            {**count_columns(count(outcome.verdict for outcome in outcomes)), "decided": outcomes[0].decided,
             "measured": outcomes[0].measured}
        ])  # fmt: skip

    def values(self, measure: Measure, experiment: str, point: Point, model: str) -> list[float | None]:
        """Return the value of a measure in each replicate; ``None`` where trials are lost, or it has none there."""
        threshold = self.replicates(point, model)[0].thresholds[model]
        parts = self._measured(measure, experiment, point, model)
        return [None if rows is None else measure.of(rows, threshold)["value"] for rows in parts]

    def _measured(self, measure: Measure, experiment: str, point: Point, model: str) -> list[Any]:
        """Return the rows of each replicate that a measure is taken of; ``None`` where trials are lost."""
        return [
            None if replicate.lost.get((experiment, model)) and not measure.conditions
            else [row for row in replicate.of(model) if row["experiment"] == experiment]
            for replicate in self.replicates(point, model)
        ]  # fmt: skip

    @cached_property
    def numbers(self) -> pl.DataFrame:
        """The measures: a row for each point, model and measure, of the trials of all replicates together.

        ``lowest`` and ``highest`` are of the replicates' own values, ``n``, ``ci_low`` and ``ci_high`` those of a mean.
        """
        rows = []
        for point, model in self.plan.judged:
            threshold = self.replicates(point, model)[0].thresholds.get(model)
            for measure, experiment in self.plan.measures:
                each = self.values(measure, experiment, point, model)
                known = [value for value in each if value is not None]
                parts = self._measured(measure, experiment, point, model)
                pooled = measure.of([row for part in parts if part for row in part], threshold)
                lost = sum(replicate.lost.get((experiment, model), 0) for replicate in self.replicates(point, model))
                why = f"{lost} {self.plan.things} have no rows" if lost else ""
                rows.append({
                    **self._values(point, model), "measure": measure.name, "experiment": experiment, **pooled,
                    "unit": measure.unit, "lowest": min(known, default=None), "highest": max(known, default=None),
                    "replicates": len(each), "not shown": len(each) - len(known),
                    "threshold": threshold if measure.has_threshold else None,
                    "measured": "; ".join(filter(None, (why, pooled["measured"]))), **dict(measure.conditions),
                })  # fmt: skip
        return pl.DataFrame(rows, infer_schema_length=None)

    @cached_property
    def tables(self) -> Mapping[str, list[dict[str, Any]]]:
        """The study's further tables."""
        return self.plan.study.tables(self) if self.plan.study.tables else {}

    def troubles(self) -> list[tuple[str, str]]:
        """Return the claims, each with what went wrong in a user's own judge."""
        return [(key[2], outcome.trouble) for key, outcomes in self.outcomes.items() for outcome in outcomes]

    def described(self) -> dict[str, Any]:
        """Return the contents of ``NAME.json``, which a reproduction's page reads: the counts, and further tables."""
        study, points = self.plan.study, [dict(point) for point, _, _ in self.outcomes]
        return {
            "study": study.name, "summary": study.summary, "replicates": self.plan.replicates,
            "repeats": self.plan.repeats, "seed": self.plan.seed,
            "counts": [{"point": point, **row} for point, row in zip(points, self.counts.to_dicts(), strict=True)],
            "tables": self.tables, "failures": self.failures,
        }  # fmt: skip


def _probed(trial: Trial, *, columns: Callable[[Any], Mapping[str, Mapping[str, Any]]]) -> TrialRecord:
    """Play one trial with the robot in a worker; its rows have a probe's columns too."""
    began_s = time.perf_counter()
    showings = show(trial)
    record = tabulate(trial, showings, time.perf_counter() - began_s, frames=False)
    more = columns(showings)
    return drawn_here(dataclasses.replace(record, rows=tuple({**row, **more[row["model"]]} for row in record.rows)))


def batch(plan: Plan, name: str = "") -> Batch[Any]:
    """Return all trials of a sweep as a batch. They leave neither recordings nor frames."""
    on_clips, probe = plan.things == "clips", plan.study.probe
    name = name or plan.study.name
    work: Any = partial(offline.play_clip, frames=False) if on_clips else partial(trials.work, keep=trials.ROWS_ONLY)
    return Batch(
        name=name,
        specs=plan.specs,
        work=partial(_probed, columns=probe.columns) if probe else work,
        description={**plan.description, "experiment": name},
        schemas=(clips.TRIALS, FRAMES) if on_clips
        else (TRIAL_SCHEMA | pl.Schema(probe.schema if probe else {}), FRAME_SCHEMA),
        parameters=plan.parameters,
        things=plan.things,
        amount=lambda: f"{len(plan.points)} points, {plan.replicates} replicates, {len(plan.specs)} {plan.things}",
        size=clips.pixels if on_clips else trials.seconds,
    )  # fmt: skip


def run(plan: Plan, out: Path, resources: Resources, *, name: str = "") -> Sweep:
    """Run what a sweep's folder lacks, and write its tables and figure.

    Parameters
    ----------
    plan
        From `planned`.
    out
        The folder: a new one, or one that holds a part of this sweep.
    resources
        Workers, or a cluster.
    name
        What the run and its files are called, otherwise by the study's name.

    Returns
    -------
    Sweep
        ``outcomes.csv``, ``counts.csv``, ``NAME.json`` and ``NAME.svg`` in the folder have it.

    Raises
    ------
    UsageError
        There is another run.
    """
    with resources.pool() as pool, batch(plan, name).run(out, pool, resources) as folder:
        result = Sweep(plan, folder.trials().to_dicts(), folder.failures())
        write(result, folder, name or plan.study.name)
        return result


def write(result: Sweep, files: Files, name: str) -> None:
    """Write the tables of a sweep, its ``NAME.json`` and its figure into a folder."""
    from experiments.bench.report import style  # not before: workers do without matplotlib

    both = [table for table in (result.counts, result.numbers) if table.height]
    files.write_rows("outcomes.csv", result.table.to_dicts())
    files.write_rows("counts.csv", pl.concat(both, how="diagonal_relaxed").to_dicts() if both else [])
    files.write_json(f"{name}.json", result.described())
    if result.counts.height or (both and len(result.plan.axes) in (1, 2)):
        style.save(drawn(result), files.folder / name)


def drawn(result: Sweep) -> Any:
    """Return the figure of a sweep (matplotlib)."""
    from experiments.bench.report import sweep as report

    plan = result.plan
    titles = {claim.id: claim.title for claim, _ in plan.claims}
    titles |= {measure.name: f"{measure.says}, {measure.unit}".rstrip(", ") for measure, _ in plan.measures}
    repeats = "/".join(map(str, dict.fromkeys(plan.repeats)))
    trials_of = f"{repeats} {'trial' if repeats == '1' else 'trials'} of each condition"
    of = "each clip once" if plan.things == "clips" else trials_of
    about = f"{plan.study.name}: {plan.study.summary}; replicates: {plan.replicates}, from seed {plan.seed}, {of}"
    return report.draw(result.counts, result.numbers, plan.axes, titles, about)


def sweep(
    experiment: str | Study,
    over: Sequence[str] = (),
    models: Sequence[str] = ("dsnn",),
    seeds: range = range(1),
    *,
    claims: Sequence[str] = (),
    measures: Sequence[str] = (),
    repeats: int | None = None,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    quiet: bool = False,
) -> pl.DataFrame:
    """Judge claims and measure numbers at every point of a grid of parameters, as ``colias sweep`` does.

    Points that differ in parameters of models alone share their frames.

    Parameters
    ----------
    experiment
        Experiments, names or files joined by commas; or a study, by its name, its file, or as it is.
    over
        Axes: ``KEY=V1,V2`` texts, as ``--over`` takes them. A study has its own.
    models
        The models judged, one by one.
    seeds
        The seed of each replicate. A study has its own number of replicates; only the first seed counts.
    claims, measures
        Ids of claims, and names of measures; without both, all claims that are declared about the models.
    repeats
        Trials of each condition in a replicate; ``None``: the experiment's own number.
    out
        The folder for the trials and tables; otherwise a new one, ``runs/NAME-TIME``. There, what is missing is done.
    workers
        Number of worker processes; otherwise one for each core. 0: none, for debuggers.
    quiet
        Whether to print neither plan nor progress.

    Returns
    -------
    polars.DataFrame
        A row for each point, model, claim and replicate: ``verdict``, what ``decided``, what was ``measured``. Without
        claims, a row for each point, model and measure: ``value``, and its 95 % interval.

    Raises
    ------
    UsageError
        It cannot be run so.

    Examples
    --------
    >>> from experiments import sweep
    >>> table = sweep("general", over=("dsnn.t_sp=0.1,0.2",), claims=("C14",), repeats=5, quiet=True)
    >>> table.select("dsnn.t_sp", "verdict").rows()
    [(0.1, 'holds'), (0.2, 'holds')]
    """
    if not isinstance(seeds, range) or seeds.step != 1 or not seeds:
        raise UsageError(f"seeds must be a range of one or more that count up by 1, got {seeds!r}")
    named = experiment if isinstance(experiment, Study) else None if over else called(experiment)
    study = named or typed(str(experiment), over, claims, measures, models, (), repeats, len(seeds))
    place = new_folder(study.name) if out is None else Path(out)
    check_own(place, f"out={place}")
    result = run(planned(study, seeds.start), place, Resources(worker_count(workers), quiet=quiet))
    return result.table if result.plan.claims else result.numbers
