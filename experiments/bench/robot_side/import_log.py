"""Make a run of a robot's log, and a log of a run."""

from __future__ import annotations

import dataclasses
import shlex
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import polars as pl

from dsnn import MODELS
from experiments.bench.result import Run
from experiments.bench.run.description import THRESHOLDS
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import ConfiguredModel, ask, look_up
from experiments.bench.run.play import play
from experiments.bench.run.recordings import pictures, write_pictures
from experiments.bench.run.rows import (
    COLUMN,
    FRAMES_MEASURED,
    FRAMES_OF_SIMULATION,
    LOG_OF_SIMULATION,
    MEASURED,
    TrialRecord,
)
from experiments.bench.run.runs import Batch, Resources
from experiments.bench.run.settings import assignments as of_mapping
from experiments.bench.run.user_code import sha256
from experiments.bench.sources import log
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.experiment import Experiment
from experiments.bench.sources.log import CHANNELS, TIME, LogTrial
from experiments.bench.sources.robot import MARK, TRUE
from experiments.bench.sources.trial_rows import FRAME_SCHEMA, TRIAL_SCHEMA
from experiments.bench.trials import Plan, conclude, configure, describe

MEASURED_SCHEMA = TRIAL_SCHEMA | pl.Schema({COLUMN: str})
SHOWN_FRAMES = "@frames"
"""Ends the label of a model that is shown the frames, where the robot's own has that name."""
LOG, FRAMES = "log.csv", "frames"


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
    labels = [str(label) for label in table["model"].unique(maintain_order=True) if log.channels_of(table, label)]
    if models and frames is None:
        raise UsageError("--model: give --frames FOLDER too, which the model is shown")
    if not labels and not models:
        raise UsageError(f"{path} has no responses (column hs or looming): show its frames to a model by --model dsnn")
    for label in labels:
        if label not in declared and ask(label)[0] not in MODELS:
            (line,) = table.filter(pl.col("model") == label)[log.LINE].head(1)
            raise UsageError(f"{path}, line {line}: no model '{label}' is registered; name its file by --ran FILE.py")
    texts = [*(declared.get(label, label) for label in labels), *models]
    chosen, settings = configure(experiment, list(dict.fromkeys(texts)), assignments)
    by_text = dict(zip(dict.fromkeys(texts), settings.models, strict=True))
    ran_models = [by_text[declared.get(label, label)] for label in labels]
    shown = [by_text[text] for text in models]
    shown = [
        dataclasses.replace(model, label=f"{model.label}{SHOWN_FRAMES if model in ran_models else ''}")
        for model in shown
    ]
    unknown = {model.label: _unknown(path, table, model) for model in ran_models}
    known = [log.without(model, unknown[model.label]) for model in ran_models]
    simulated = log.SIMULATION in table["origin"]
    origins = dict.fromkeys(unknown, LOG_OF_SIMULATION if simulated else MEASURED)
    origins |= dict.fromkeys((model.label for model in shown), FRAMES_OF_SIMULATION if simulated else FRAMES_MEASURED)
    repeats: Counter[Any] = Counter()
    trials = []
    for (index,), rows in sorted(table.partition_by("trial", as_dict=True).items()):
        condition = log.condition_of(path, rows.row(0, named=True), chosen)
        ran_here = [model for model in ran_models if model.label in rows["model"]]
        trial = LogTrial(experiment.name, index, repeats[condition], 0, condition, (*ran_here, *shown), rows,
                         settings.camera, frames, origins, unknown)  # fmt: skip
        _check(path, trial)
        trials.append(trial)
        repeats[condition] += 1
    settings = dataclasses.replace(settings, models=(*known, *shown))
    return Plan(chosen, settings, max(repeats.values()), 0, experiment.design), trials


def _unknown(path: Path, table: pl.DataFrame, model: ConfiguredModel) -> list[str]:
    """Return the channels of a model that the log lacks; `UsageError` where it lacks the one whose spikes count."""
    channels = log.channels_of(table, model.label)
    if model.counted not in channels:
        (line,) = table.filter(pl.col("model") == model.label)[log.LINE].head(1)
        raise UsageError(f"{path}, line {line}: {model.counted} of {model.label} is missing, whose spikes count")
    return [channel for channel in model.channels if channel not in channels]


def _check(path: Path, trial: LogTrial) -> None:
    """Refuse times in another unit than seconds, and frames that are not one for each line of the log."""
    rate, line = trial.fps, trial.rows[log.LINE][0]
    if not 1 / log.MOST_OFF <= rate / trial.camera.fps <= log.MOST_OFF:
        raise UsageError(
            f"{path}, line {line}: time_s must be in seconds: trial {trial.index} has {rate:.3g} frames per second by"
            f" it, and camera.fps is {trial.camera.fps:g} (--set camera.fps=RATE)"
        )
    if trial.frames is not None:
        found, wanted = len(log.frame_files(trial.frames, trial.index)), trial.shown.height
        if found != wanted:
            folder = trial.frames / f"trial-{trial.index:04d}"
            raise UsageError(f"{folder} must have {wanted} pictures ({', '.join(log.PICTURES)}), one for each frame of"
                             f" the trial that begins in line {line} of {path}, got {found}")  # fmt: skip


def play_trial(trial: LogTrial) -> TrialRecord:
    """Play a log's trial, and leave blank what the log does not tell."""
    done = play(trial, log.record)
    frames = done.frames
    for label, channels in trial.unknown.items():
        names = [name for channel in channels for name in (channel, CHANNELS[channel]) if name]
        of_model = pl.col("model") == label
        frames = frames.with_columns(pl.when(~of_model).then(pl.col(name)).alias(name) for name in names)
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


def write(recorded: Run, out: Path) -> str:
    """Write a run as the log that a robot would have sent: `LOG`, and `FRAMES` of the trials that have a recording.

    A robot has one eye: of a run with both eyes the models that see by the second are left out.

    Parameters
    ----------
    recorded
        A run of simulated trials with the robot.
    out
        A new folder.

    Returns
    -------
    str
        The command that imports it.

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
    table = table.rename({"sim_time_s": TIME}).with_columns(
        pl.lit(log.SIMULATION).alias("origin"), *_declared(recorded.description)
    )
    there = [name for name in log.COLUMNS if table[name].null_count() < table.height]
    out.mkdir(parents=True, exist_ok=True)
    table.select(there).write_csv(out / LOG)
    for recording in recorded.recordings:
        frames = pictures(recording).get("camera")
        if frames is not None:
            write_pictures(out / FRAMES / recording.stem, frames, ".pgm")
    return shlex.join(_import(recorded, out))


def _declared(description: Mapping[str, Any]) -> list[pl.Expr]:
    """Return the columns of responses, blank where a model does not declare the channel."""
    expressions = []
    for channel, spikes in CHANNELS.items():
        models = [label for label, thresholds in description[THRESHOLDS].items() if channel in thresholds]
        declares = pl.col("model").is_in(models)
        expressions += [pl.when(declares).then(pl.col(name)).alias(name) for name in (channel, spikes) if name]
    return expressions


def _declaring(recorded: Run) -> str:
    """Return the experiment as the run's own command named it: a name, or a file."""
    line = recorded.description.get("command", {}).get("line", ())
    return next((word for word in line if word.endswith(".py") and Path(word).stem == recorded.name), recorded.name)


def _import(recorded: Run, out: Path) -> list[str]:
    """Return the words of the command that imports a log of a run, with the parameters that it changed."""
    words = ["colias", "import", str(out / LOG), "--experiment", _declaring(recorded)]
    if (out / FRAMES).is_dir():
        words += ["--frames", str(out / FRAMES)]
    for key, values in (recorded.description.get("changed") or {}).items():
        name = key.rpartition(".")[2]
        changed = [value for label, value in values.items() if value is not None and name not in ask(label)[1]]
        words += [word for value in dict.fromkeys(changed) for word in ("--set", *of_mapping({key: value}))]
    return words
