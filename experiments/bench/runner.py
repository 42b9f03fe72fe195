"""Run an experiment: every trial in turn, tables kept up to date, then summary, claims and figure."""

from __future__ import annotations

import dataclasses
import importlib.metadata
import platform
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import cv2
from threadpoolctl import threadpool_limits

from experiments.bench import figures, log
from experiments.bench.claims import Verdict, judge
from experiments.bench.declaration import Experiment, Settings, TrialSpec, trial_specs
from experiments.bench.results import RunFolder, group
from experiments.bench.settings import UsageError
from experiments.bench.statistics import summarise
from experiments.bench.trial import TrialResult, reach_cm, run_trial
from scenes import ARENA_RADIUS_CM

LIBRARIES = ("colias-sim", "mujoco", "numpy", "opencv-python-headless", "rerun-sdk", "scipy", "pyarrow")

OnTrial = Callable[[TrialResult], None]


@dataclasses.dataclass(frozen=True, slots=True)
class Report:
    """What a finished run amounts to: a row per condition, and the verdicts."""

    folder: Path
    summary: list[dict[str, Any]]
    verdicts: list[Verdict]


@dataclasses.dataclass(frozen=True, slots=True)
class Plan:
    """A run to do: everything that decides its numbers."""

    experiment: Experiment
    settings: Settings
    repeats: int
    seed: int

    def specs(self) -> list[TrialSpec]:
        """Every trial of the run."""
        return trial_specs(self.experiment, self.settings, self.repeats, self.seed)


def run(plan: Plan, folder: RunFolder, on_trial: OnTrial, *, recordings: bool = True) -> Report:
    """Do a checked plan into a folder already created, telling ``on_trial`` of each finished trial.

    A trial is kept (recorded, then added to the tables) on a second thread while the next one runs. What was
    finished stays readable whenever this ends, by an exception or a kill too.
    """

    def keep(result: TrialResult) -> None:
        if recordings:
            log.write_recording(result, folder.recordings)
        folder.add(result)
        on_trial(result)

    cv2.setNumThreads(1)  # more threads cost a second core for a sixth of the time
    folder.write_json("experiment.json", describe(plan))
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


def check(plan: Plan) -> None:
    """Raise `UsageError` for a plan whose stimulus would have to drive through the wall."""
    for condition in plan.experiment.design.conditions():
        reach = reach_cm(condition, plan.settings)
        if reach > ARENA_RADIUS_CM:
            raise UsageError(
                f"{condition.label()}: seen through {plan.settings.camera.hfov_deg:g} degrees the crossing reaches "
                f"{reach:.0f} cm from the centre; the arena ends at {ARENA_RADIUS_CM:g} cm"
            )


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
    return Report(folder.folder, summary, verdicts)


def summary_rows(rows: Sequence[Any]) -> list[dict[str, Any]]:
    """One row per condition and quantity: n, mean, sd, median and the 95 % bootstrap interval of the mean."""
    table = []
    keys = ("motion", "direction", "speed_cm_s", "distance_cm", "angle_deg")
    for condition, chosen in group(rows, *keys).items():
        for quantity in ("spikes", "firing_rate_hz", "peak_hs", "trough_hs", "peak_vs", "achieved_speed_cm_s"):
            summary = summarise([row[quantity] for row in chosen])
            table.append(
                {**dict(zip(keys, condition, strict=True)), "quantity": quantity, **dataclasses.asdict(summary)}
            )
    return table


def describe(plan: Plan) -> dict[str, Any]:
    """What ``experiment.json`` holds: every parameter, the seed, the versions that computed the numbers."""
    return {
        "experiment": plan.experiment,
        "repeats": plan.repeats,
        "seed": plan.seed,
        "trials": len(plan.specs()),
        "settings": plan.settings,
        "versions": {
            "python": platform.python_version(),
            **{name: importlib.metadata.version(name) for name in LIBRARIES},
        },
    }
