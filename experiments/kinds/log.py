"""A robot's log as a run: the trials that it tells of, with the tables, figure and verdicts of simulated ones.

And the other way round: a run of simulated trials as the log that a robot would have sent.
"""

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import polars as pl

from dsnn import MODELS
from experiments.base.errors import UsageError
from experiments.base.files import Files
from experiments.base.user_code import sha256
from experiments.declare.conditions import CONDITION_COLUMNS
from experiments.kinds import registry, trials
from experiments.kinds.result import Kind, Run, concluding
from experiments.robot.log_trial import LEAST_FPS, LogTrial, lacking, pictures_in, record, trial_folder
from experiments.robot.logs import (
    CHANNELS,
    FRAMES,
    LINE,
    LOG,
    LOG_OF_SIMULATION,
    MEASURED,
    SCHEMA,
    SIMULATION,
    condition_of,
    logged,
    read,
)
from experiments.settings.models import EYE, look_up, parse_model
from experiments.settings.settings import configure
from experiments.show.play import play
from experiments.show.robot import TRUE
from experiments.show.trial_rows import FRAME_SCHEMA, TRIAL_SCHEMA
from experiments.store.asked import Asked
from experiments.store.plan import Plan
from experiments.store.recordings import pictures, write_pictures
from experiments.store.tables import COLUMN, TrialRecord, without_controls

MEASURED_SCHEMA = TRIAL_SCHEMA | pl.Schema({COLUMN: str})
SHOWN_FRAMES = "@frames"
"""Ends the label of a model that is shown the frames, where the robot's own has that name."""


def plan(asked: Asked) -> Plan[LogTrial]:
    """Read and check a log and the frames that belong to it.

    Parameters
    ----------
    asked
        What was asked for: the log, a CSV file; ``models`` to show the frames to; values of the experiment, the models
        and the camera. Its options are ``experiment``, whose conditions the trials show; ``frames``, the folder of the
        trials' frames; and ``ran``, what the robot ran, names or .py files: the model of a log without a column
        ``model``, otherwise ``dsnn``, and the files that labels in that column stand for.

    Returns
    -------
    Plan
        The trials.

    Raises
    ------
    UsageError
        Something cannot be imported: the line and the cell, or the file.
    """
    path, frames = Path(asked.what[0]), asked.option("frames")
    frames = Path(frames) if frames else None
    experiment = asked.declared or registry.load(asked.option("experiment", "speed"))
    declared = {look_up([text])[0].label: text for text in asked.option("ran", ())}
    table = read(path, next(iter(declared), "dsnn"))
    of_model = _of_models(path, table, declared, asked.models, frames)
    texts = list(dict.fromkeys([*(declared.get(label, label) for label in of_model), *asked.models]))
    chosen, settings = configure(experiment, texts, asked.values)
    if any(model.processor.every > 1 for model in settings.models):
        raise UsageError("processor.every must be 1: a log has the frames that the robot's network took")
    by_text = dict(zip(texts, settings.models, strict=True))
    ran = {label: by_text[declared.get(label, label)] for label in of_model}
    playing = {label: logged(model, of_model[label]) for label, model in ran.items()}
    unknown = {label: [channel for channel in ran[label].channels if channel not in model.channels]
               for label, model in playing.items()}  # fmt: skip
    replaying = [by_text[text] for text in asked.models]  # under labels that the robot's own have not
    shown = [dataclasses.replace(model, label=f"{model.label}{SHOWN_FRAMES}") if model.label in of_model else model
             for model in replaying]  # fmt: skip
    its_own, replayed = LOG_OF_SIMULATION if SIMULATION in table["origin"] else MEASURED
    origins = {**dict.fromkeys(playing, its_own), **{model.label: replayed for model in shown}}
    repeats: Counter[Any] = Counter()
    listed = []
    for (index,), rows in sorted(table.partition_by("trial", as_dict=True).items()):
        condition = condition_of(path, rows.row(0, named=True), chosen)
        here = [model for label, model in ran.items() if label in rows["model"]]
        trial = LogTrial(experiment.name, index, repeats[condition], 0, condition, (*here, *shown), rows,
                         settings.camera, frames, origins, unknown)  # fmt: skip
        _check(path, trial)
        listed.append(trial)
        repeats[condition] += 1
    settings = dataclasses.replace(settings, models=(*playing.values(), *shown))
    resolved, changed = trials.resolve(asked, experiment, chosen, settings, max(repeats.values()), len(listed))
    return Plan(
        asked, experiment.name, listed, play_trial, {**resolved, "measured": _source(path, frames, listed)},
        (MEASURED_SCHEMA, FRAME_SCHEMA), chosen, settings.models, changed,
        notes=tuple(filter(None, (lacking(trial)[1] for trial in listed))),
    )  # fmt: skip


def _of_models(
    path: Path, table: pl.DataFrame, declared: Mapping[str, str], models: Sequence[str], frames: Path | None
) -> dict[str, pl.DataFrame]:
    """Return the rows of each model that has responses in a log; `UsageError` where nothing can be shown of one."""
    of_model = {str(label): rows for (label,), rows in table.partition_by("model", as_dict=True).items()}
    of_model = {label: rows for label, rows in of_model.items() if any(channel in rows for channel in CHANNELS)}
    if (models and frames is None) or not (models or of_model):
        raise UsageError(f"{path}: --model needs --frames FOLDER, and a log without responses (hs, looming) both")
    for label, rows in of_model.items():
        if label not in declared and parse_model(label)[0] not in MODELS:  # a cell of a log runs no file
            raise UsageError(f"{path}, line {rows[LINE][0]}: no model '{label}': name its file by --ran FILE.py")
    return of_model


def _source(path: Path, frames: Path | None, listed: Sequence[LogTrial]) -> dict[str, Any]:
    """Return what ``run.json`` has of a log."""
    origins = dict.fromkeys(origin for trial in listed for origin in trial.origins.values())
    return {"provenance": "; ".join(origins), "log": str(path), "sha256": sha256(path),
            "frames": str(frames) if frames else None,
            "lacking_frames": sum(lacking(trial)[0] for trial in listed)}  # fmt: skip


def _check(path: Path, trial: LogTrial) -> None:
    """Refuse times in another unit than seconds, and frames that are not one for each line of the log."""
    if trial.fps < LEAST_FPS:
        raise UsageError(f"{path}: time_s must be in seconds; trial {trial.index} has {trial.fps:.3g} frames/s by it")
    if trial.frames is not None:
        folder = trial_folder(trial.frames, trial.index)
        found, wanted = len(pictures_in(folder)), trial.shown.height
        if found != wanted:
            raise UsageError(f"{folder} must have {wanted} pictures, one for each frame of the log, got {found}: leave"
                             f" out this trial, or what has no row or no picture. {lacking(trial)[1]}")  # fmt: skip


def play_trial(trial: LogTrial) -> TrialRecord:
    """Play a log's trial, and leave blank what the log does not tell."""
    done = play(trial, record)
    frames = done.frames
    for label, channels in trial.unknown.items():
        names = [name for channel in channels for name in (channel, CHANNELS[channel]) if name]
        frames = frames.with_columns(pl.when(pl.col("model") != label).then(pl.col(name)).alias(name) for name in names)
    return dataclasses.replace(done, frames=frames)


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
    conditions = without_controls(conditions.filter(~pl.col("model").str.ends_with(f"{EYE}{TRUE}")))
    table = recorded.frames.join(conditions, on=["trial", "model"], how="inner", maintain_order="left")
    table = table.with_columns(pl.lit(SIMULATION).alias("origin"))
    there = [name for name in SCHEMA if table[name].null_count() < table.height]
    out.mkdir(parents=True, exist_ok=True)
    Files(out).write_text(LOG, table.select(there).write_csv())
    for recording in recorded.recordings:
        frames = pictures(recording).get("camera")
        if frames is not None:
            write_pictures(out / FRAMES / recording.stem, frames, ".pgm")


KIND = Kind(plan, concluding(trials.conclude), trials.draw, trials.show, renders=False)
