"""Report of a run: summary, claims and figure of its trials."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

from experiments.bench.report import robot as robot_figure
from experiments.bench.report import style
from experiments.bench.robot.open_loop import in_short, why
from experiments.bench.run.folder import RunFolder
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.experiment import Drawing
from experiments.bench.sources.robot_claims import find, flaws, judge
from experiments.bench.sources.rows import drawable
from experiments.bench.stats import excitation, stored
from experiments.bench.stats.checks import is_number
from experiments.bench.stats.excitation import NEEDED, WHOLE, Course, without_parts
from experiments.bench.stats.tests import holm, paired, summarise
from experiments.bench.stats.verdict import Verdict
from experiments.bench.store.files import TABLE, drawn_from
from experiments.bench.store.origin import origin
from experiments.bench.store.rows import Failure, group, mixture
from experiments.bench.trials import Plan
from scenes import arena_name

QUANTITIES = (
    "spikes", "firing_rate_hz", "peak_hs", "trough_hs", "peak_vs", "achieved_speed_cm_s", "path_error_mm", "drift_mm",
    "seconds_in_view", "spikes_in_view", "rate_in_view_hz", "mean_hs_in_view", "mean_hs_near_axis", "spikes_in_window",
    "spikes_in_inner_window",
)  # fmt: skip

SIGNED = ("peak_hs", "trough_hs", "peak_vs", "drift_mm", "mean_hs_in_view", "mean_hs_near_axis")
"""Those of them that can be negative: of the others no interval goes below 0."""


@dataclasses.dataclass(frozen=True, slots=True)
class Report:
    """Report of a run: a row per condition, the verdicts, any flaws of its trials, and those that failed.

    ``open_loop`` says why trials are not left out for their speed or path, where the stimulus was driven open loop.
    """

    folder: Path
    varies: str
    drawing: Drawing
    rows: list[dict[str, Any]]
    summary: list[dict[str, Any]]
    verdicts: list[Verdict]
    comparisons: list[dict[str, Any]]
    flaws: str
    failures: list[Failure]
    courses: list[Course]
    """Courses of a run whose figure is about excitation; else empty."""
    open_loop: str = ""
    provenance: str = ""
    """Origin of the trials, as `experiments.bench.store.origin` says it; empty: they are simulated."""
    counted: Mapping[str, str] = dataclasses.field(default_factory=dict)
    """Model -> the channel that it is told of by: `experiments.bench.run.models.ConfiguredModel.counted`."""


def conclude(plan: Plan, folder: RunFolder, failures: Sequence[Failure] = ()) -> Report:
    """Write summary, claims and figure of the trials in ``folder``."""
    rows = folder.trials().to_dicts()
    admitted = [text for text in (mixture(rows), in_short(rows)) if text]
    verdicts = [
        _noting(judge(claim, model_rows, model.threshold, model.label), plan.experiment.name, lost, admitted)
        for model in plan.settings.models
        for model_rows in [[row for row in rows if row["model"] == model.label]]
        for lost in [sum(failure.model in ("", model.label) for failure in failures)]
        for claim in map(find, plan.experiment.claims)
        if not claim.models and claim.concerns(model.channels)
    ] + _of_several(plan, rows, failures, admitted)
    figure_rows = without_parts(rows) if plan.experiment.figure == "excitation" else rows
    summary = summary_rows(figure_rows)
    reference = plan.settings.models[0].label if len(plan.experiment.models) > 1 else ""
    compared = compare(figure_rows, reference)
    courses_found = courses_of(plan, rows, folder)
    if courses_found:
        folder.write_rows("excitation.csv", excitation.table(courses_found))
    if rows:
        folder.write_rows("summary.csv", summary)
        title = robot_figure.title(plan.experiment.name, arena_name(plan.settings.scene.arena), rows, plan.changed(),
                                   open_loop=plan.settings.robot.open_loop)  # fmt: skip
        thresholds = {model.label: model.threshold for model in plan.settings.models}
        drawn = robot_figure.draw(drawable(plan.experiment.figure, rows), rows, folder.frames(), plan.experiment.varies,
                                  thresholds, title, excitation.table(courses_found))  # fmt: skip
        style.save(drawn, folder.folder / "figure", drawn_from([folder.folder / TABLE]))
    if compared:
        folder.write_rows("comparisons.csv", compared)
    folder.write_json("claims.json", stored.document(verdicts))
    declared = plan.experiment
    return Report(
        folder.folder, declared.varies, drawable(declared.figure, rows), figure_rows, summary, verdicts, compared,
        flaws(rows), list(failures), courses_found,
        why(plan.settings.robot, min(condition.speed_cm_s for condition in declared.conditions()))
        if plan.settings.robot.open_loop else "",
        origin(rows),
        {model.label: model.counted for model in plan.settings.models},
    )  # fmt: skip


def _of_several(plan: Plan, rows: Sequence[Any], failures: Sequence[Failure], admitted: Sequence[str]) -> list[Verdict]:
    """The verdicts on claims that compare models."""
    thresholds = {model.label: model.threshold for model in plan.settings.models}
    return [
        _noting(judge(claim, rows, thresholds.get(claim.spiking), ""), plan.experiment.name, lost, admitted)
        for claim in map(find, plan.experiment.claims)
        if claim.models
        for lost in [sum(failure.model in ("", *claim.models) for failure in failures)]
    ]


def courses_of(plan: Plan, rows: Sequence[Any], folder: RunFolder) -> list[Course]:
    """Excitation and inhibition in each condition; empty where the figure is about other things, or models lack."""
    networks = {model.label: model.network for model in plan.settings.models}
    if plan.experiment.figure != "excitation" or not set(NEEDED) <= set(networks):
        return []
    return excitation.courses(rows, folder.frames(), networks[WHOLE].w_i)


def _noting(verdict: Verdict, experiment: str, lost: int, notes: Sequence[str]) -> Verdict:
    """The verdict, naming its experiment, with the trials it could not be judged on and ``notes`` on the others."""
    failed = f"{lost} trial{'s' * (lost != 1)} of the run failed" if lost else ""
    return dataclasses.replace(verdict, outcome=verdict.outcome.noting([failed, *notes]), experiment=experiment)


def summary_rows(rows: Sequence[Any]) -> list[dict[str, Any]]:
    """One row per model, condition and quantity: n, mean, sd, median, 95 % interval of the mean."""
    keys = ("model", *CONDITION_COLUMNS)
    table = []
    for condition, chosen in group(rows, *keys).items():
        for quantity in QUANTITIES:
            values = [row[quantity] for row in chosen if is_number(row.get(quantity))]
            if not values:  # the motion has no such quantity
                continue
            summary = summarise(values, -math.inf if quantity in SIGNED else 0.0)
            numbers = {k: None if math.isnan(v) else v for k, v in dataclasses.asdict(summary).items()}
            table.append({**dict(zip(keys, condition, strict=True)), "quantity": quantity, **numbers})
    return table


def compare(rows: Sequence[Any], reference: str = "") -> list[dict[str, Any]]:
    """Models on the same trials, per condition: a paired test of their spikes, p by Holm over all rows.

    A model that does not spike has nothing to be tested.

    Parameters
    ----------
    rows
        Of ``trials.parquet``.
    reference
        The model that all others are compared with; empty: every two models are.
    """
    models = list(dict.fromkeys(row["model"] for row in rows))
    table: list[dict[str, Any]] = []
    for condition, chosen in group(rows, *CONDITION_COLUMNS).items():
        counted = [row for row in chosen if row["spikes"] is not None]
        spikes = {m: {row["trial"]: row["spikes"] for row in counted if row["model"] == m} for m in models}
        for one, other in combinations(models, 2):
            if reference not in ("", one):  # the first of the models
                continue
            both = [trial for trial in spikes[one] if trial in spikes[other]]  # one may have failed in some
            if not both:
                continue
            first, second = ([spikes[m][trial] for trial in both] for m in (one, other))
            test = paired(first, second)
            table.append(
                {
                    **dict(zip(CONDITION_COLUMNS, condition, strict=True)), "model": one, "against": other,
                    "n": len(both), "mean_difference": (sum(first) - sum(second)) / len(both),
                    "rank_biserial": test.effect, "test": test.name, "p": test.p,
                }
            )  # fmt: skip
    for row, p in zip(table, holm([row["p"] for row in table]), strict=True):
        row["p_holm"] = p
    return table
