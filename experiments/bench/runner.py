"""Run an experiment: every trial in turn, tables kept up to date, then summary, claims and figure."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cv2
from threadpoolctl import threadpool_limits

from experiments.bench import figures, log
from experiments.bench.claims import Verdict, flaws, judge
from experiments.bench.declaration import CONDITION_COLUMNS
from experiments.bench.plan import Plan
from experiments.bench.results import RunFolder, group
from experiments.bench.statistics import summarise
from experiments.bench.trial import TrialResult, run_trial

OnTrial = Callable[[TrialResult], None]


@dataclasses.dataclass(frozen=True, slots=True)
class Report:
    """What a finished run amounts to: a row per condition, the verdicts, and any flaws of its trials."""

    folder: Path
    summary: list[dict[str, Any]]
    verdicts: list[Verdict]
    flaws: str


def run(plan: Plan, folder: RunFolder, on_trial: OnTrial, *, recordings: bool = True) -> Report:
    """Do a checked plan into a folder created for it, telling ``on_trial`` of each finished trial.

    A trial is kept (recorded, then added to the tables) on a second thread while the next one runs. What was
    finished stays readable whenever this ends, by an exception or a kill too.
    """

    def keep(result: TrialResult) -> None:
        if recordings:
            log.write_recording(result, folder.recordings)
        folder.add(result)
        on_trial(result)

    cv2.setNumThreads(1)  # more threads cost a second core for a sixth of the time
    with threadpool_limits(1), ThreadPoolExecutor(1, "keeper") as keeper:
        kept: Future[None] | None = None
        for spec in plan.specs():
            result = run_trial(spec, keep_media=recordings)
            if kept is not None:
                kept.result()  # at most one waits, and its error ends the run
            kept = keeper.submit(keep, result)
        if kept is not None:
            kept.result()
    return conclude(plan, folder)


def conclude(plan: Plan, folder: RunFolder) -> Report:
    """Write summary, claims and figure of the trials in ``folder``."""
    rows = folder.trials()
    threshold = getattr(plan.settings.network, "t_sp", 0.0)
    verdicts = [judge(claim, rows, threshold) for claim in plan.experiment.claims]
    summary = summary_rows(rows)
    folder.write_rows("summary.csv", summary)
    folder.write_json("claims.json", {"claims": [dataclasses.asdict(v) for v in verdicts]})
    title = f"{plan.experiment.name}: {plan.settings.model}, {plan.settings.scene.arena} arena, n = {plan.repeats}"
    figure = figures.draw(rows, folder.frames(), plan.experiment.varies, title, threshold)
    figures.save(figure, folder.folder)
    return Report(folder.folder, summary, verdicts, flaws(rows))


def summary_rows(rows: Sequence[Any]) -> list[dict[str, Any]]:
    """One row per condition and quantity: n, mean, sd, median and the 95 % bootstrap interval of the mean."""
    table = []
    for condition, chosen in group(rows, *CONDITION_COLUMNS).items():
        for quantity in ("spikes", "firing_rate_hz", "peak_hs", "trough_hs", "peak_vs", "achieved_speed_cm_s"):
            summary = summarise([row[quantity] for row in chosen])
            numbers = {k: None if math.isnan(v) else v for k, v in dataclasses.asdict(summary).items()}
            table.append({**dict(zip(CONDITION_COLUMNS, condition, strict=True)), "quantity": quantity, **numbers})
    return table
