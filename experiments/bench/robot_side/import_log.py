"""Make a run of a robot's log, and a log of a run."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import polars as pl

from dsnn import MODELS
from experiments.bench.result import Run
from experiments.bench.run import rows as of_rows
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import ask, look_up
from experiments.bench.run.play import play
from experiments.bench.run.recordings import pictures, write_pictures
from experiments.bench.run.runs import Batch, Resources
from experiments.bench.run.user_code import sha256
from experiments.bench.sources import log
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.experiment import Experiment
from experiments.bench.sources.log import CHANNELS, LINE, TIME, LogTrial
from experiments.bench.sources.robot import MARK, TRUE
from experiments.bench.sources.trial_rows import FRAME_SCHEMA, TRIAL_SCHEMA
from experiments.bench.trials import Plan, conclude, configure, describe

MEASURED_SCHEMA = TRIAL_SCHEMA | pl.Schema({of_rows.COLUMN: str})
SHOWN_FRAMES = "@frames"
"""Ends the label of a model that is shown the frames, where the robot's own has that name."""
LOG, FRAMES = "log.csv", "frames"
LEAST_FPS = 0.5
"""Slowest rate of a log's frames, 1/s: below, ``time_s`` is in another unit than seconds."""


def plan(
    experiment: Experiment, path: Path, frames: Path | None = None, ran: Sequence[str] = (),
    models: Sequence[str] = (), assignments: Sequence[str] = (),
) -> tuple[Plan, list[LogTrial]]:  # fmt: skip
    """Read and check a log and the frames that belong to it.

    Parameters
    ----------
    experiment
        Whose conditions the trials show.
    path
        The log, a CSV file.
    frames
        The folder of the trials' frames.
    ran
        What the robot ran, names or .py files: the model of a log without a column ``model``, otherwise ``dsnn``, and
        the files that labels in that column stand for.
    models
        Models to show the frames to.
    assignments
        ``SECTION.NAME=VALUE`` texts: parameters of the experiment, the models and the camera.

    Returns
    -------
    Plan
        The experiment, its settings and the models.
    list of LogTrial
        The trials.

    Raises
    ------
    UsageError
        Something cannot be imported: the line and the cell, or the file.
    """
    declared = {look_up([text])[0].label: text for text in ran}
    table = log.read(path, next(iter(declared), "dsnn"))
    of_model = {str(label): rows for (label,), rows in table.partition_by("model", as_dict=True).items()}
    of_model = {label: rows for label, rows in of_model.items() if any(channel in rows for channel in CHANNELS)}
    if (models and frames is None) or not (models or of_model):
        raise UsageError(f"{path}: --model needs --frames FOLDER, and a log without responses (hs, looming) both")
    for label, rows in of_model.items():
        if label not in declared and ask(label)[0] not in MODELS:  # a cell of a log runs no file
            raise UsageError(f"{path}, line {rows[LINE][0]}: no model '{label}': name its file by --ran FILE.py")
    texts = list(dict.fromkeys([*(declared.get(label, label) for label in of_model), *models]))
    chosen, settings = configure(experiment, texts, assignments)
    by_text = dict(zip(texts, settings.models, strict=True))
    ran_models = {label: by_text[declared.get(label, label)] for label in of_model}
    logged = {label: log.logged(model, of_model[label]) for label, model in ran_models.items()}
    unknown = {label: [channel for channel in ran_models[label].channels if channel not in model.channels]
               for label, model in logged.items()}  # fmt: skip
    again = [by_text[text] for text in models]
    shown = [dataclasses.replace(model, label=f"{model.label}{SHOWN_FRAMES if model.label in of_model else ''}")
             for model in again]  # fmt: skip
    words = of_rows.MEASURED, of_rows.FRAMES_MEASURED
    if log.SIMULATION in table["origin"]:
        words = of_rows.LOG_OF_SIMULATION, of_rows.FRAMES_OF_SIMULATION
    origins = {**dict.fromkeys(logged, words[0]), **{model.label: words[1] for model in shown}}
    repeats: Counter[Any] = Counter()
    trials = []
    for (index,), rows in sorted(table.partition_by("trial", as_dict=True).items()):
        condition = log.condition_of(path, rows.row(0, named=True), chosen)
        here = [model for label, model in ran_models.items() if label in rows["model"]]
        trial = LogTrial(experiment.name, index, repeats[condition], 0, condition, (*here, *shown), rows,
                         settings.camera, frames, origins, unknown)  # fmt: skip
        _check(path, trial)
        trials.append(trial)
        repeats[condition] += 1
    settings = dataclasses.replace(settings, models=(*logged.values(), *shown))
    return Plan(chosen, settings, max(repeats.values()), 0, experiment.design), trials


def _check(path: Path, trial: LogTrial) -> None:
    """Refuse times in another unit than seconds, and frames that are not one for each line of the log."""
    if trial.fps < LEAST_FPS:
        raise UsageError(f"{path}: time_s must be in seconds; trial {trial.index} has {trial.fps:.3g} frames/s by it")
    if trial.frames is not None:
        folder = log.trial_folder(trial.frames, trial.index)
        found, wanted = len(log.pictures_in(folder)), trial.shown.height
        if found != wanted:
            raise UsageError(f"{folder} must have {wanted} pictures, one for each frame of the log, got {found}")


def play_trial(trial: LogTrial) -> of_rows.TrialRecord:
    """Play a log's trial, and leave blank what the log does not tell."""
    done = play(trial, log.record)
    frames = done.frames
    for label, channels in trial.unknown.items():
        names = [name for channel in channels for name in (channel, CHANNELS[channel]) if name]
        frames = frames.with_columns(pl.when(pl.col("model") != label).then(pl.col(name)).alias(name) for name in names)
    return dataclasses.replace(done, frames=frames)


def run(planned: Plan, trials: Sequence[LogTrial], path: Path, out: Path, *, quiet: bool = False) -> Run:
    """Play the trials of a log into a run's folder, judge its claims and draw its figure.

    Parameters
    ----------
    planned, trials, path
        From `plan`, and the log that they were read from.
    out
        The run's folder.
    quiet
        Whether to show no progress.
    """
    origins = dict.fromkeys(origin for trial in trials for origin in trial.origins.values())
    frames = trials[0].frames
    source = {"provenance": "; ".join(origins), "log": str(path), "sha256": sha256(path),
              "frames": str(frames) if frames else None}  # fmt: skip
    batch = Batch(
        name=planned.experiment.name, specs=trials, work=play_trial,
        description={**describe(planned), "kind": "measured", "trials": len(trials), "measured": source},
        schemas=(MEASURED_SCHEMA, FRAME_SCHEMA), parameters=planned.changed(),
    )  # fmt: skip
    resources = Resources(workers=0, quiet=quiet)
    with resources.pool(rendering=False) as pool, batch.run(out, pool, resources) as folder:
        return conclude(planned, folder)


def write(recorded: Run, out: Path) -> None:
    """Write a run as the log that a robot would have sent: `LOG`, and `FRAMES` of the trials that have a recording.

    A robot has one eye: of a run with both eyes the models that see by the second are left out.

    Parameters
    ----------
    recorded
        A run of simulated trials with the robot.
    out
        A new folder.

    Raises
    ------
    UsageError
        The run is of another kind.
    """
    if recorded.kind != "trials":
        raise UsageError(f"{recorded.folder}: a log is of simulated trials with the robot, not of {recorded.kind}")
    conditions = recorded.trials.select("trial", "model", *CONDITION_COLUMNS)
    conditions = conditions.filter(~pl.col("model").str.ends_with(f"{MARK}{TRUE}"))
    table = recorded.frames.join(conditions, on=["trial", "model"], how="inner", maintain_order="left")
    table = table.rename({"sim_time_s": TIME}).with_columns(pl.lit(log.SIMULATION).alias("origin"))
    there = [name for name in log.SCHEMA if table[name].null_count() < table.height]
    out.mkdir(parents=True, exist_ok=True)
    table.select(there).write_csv(out / LOG)
    for recording in recorded.recordings:
        frames = pictures(recording).get("camera")
        if frames is not None:
            write_pictures(out / FRAMES / recording.stem, frames, ".pgm")
