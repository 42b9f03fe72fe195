"""Make a run of a robot's log: the same tables, statistics, figure and claims as of simulated trials."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from contextlib import AbstractContextManager, closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import polars as pl

from experiments.bench.engine.terminal import error_console, progress
from experiments.bench.measured.frames import FrameFolder
from experiments.bench.measured.log import Log, LoggedTrial, read
from experiments.bench.measured.rows import MEASURED_SCHEMA, Given, frame_table, given, rate_hz, trial_row
from experiments.bench.run.errors import TrialError, UsageError, short
from experiments.bench.run.folder import RunFolder
from experiments.bench.run.models import ConfiguredModel, ask, choose, rate_notes
from experiments.bench.run.play import ModelRunner
from experiments.bench.run.runs import tell
from experiments.bench.run.user_code import is_file, sha256
from experiments.bench.sources.conditions import Condition
from experiments.bench.sources.experiment import Experiment
from experiments.bench.sources.robot import MARK
from experiments.bench.sources.rows import FRAME_SCHEMA
from experiments.bench.store.origin import FRAMES_MEASURED, FRAMES_OF_SIMULATION, LOG_OF_SIMULATION, MEASURED
from experiments.bench.store.pictures import Images
from experiments.bench.store.places import replacing_folder
from experiments.bench.store.rows import Failure, TrialRecord, recording_of
from experiments.bench.trials import Plan, Report, conclude, configure, describe

MOST_OFF = 10.0
"""Times by which a log's frame rate may differ from the camera's setting."""
SHOWN_FRAMES = "@frames"
"""Ends the label of a model that was shown the frames, where the robot's own has that name."""


@dataclass(frozen=True, slots=True)
class Import:
    """A log that was read and checked: nothing of it is written yet.

    Parameters
    ----------
    log
        The trials.
    plan
        The experiment, its settings and the models, in the order of their rows.
    frames
        The trials' frames.
    ran
        The log's label of a model -> the model.
    models
        The models that the frames are shown to.
    """

    log: Log
    plan: Plan
    frames: FrameFolder | None
    ran: dict[str, ConfiguredModel]
    models: tuple[ConfiguredModel, ...]


def prepare(
    experiment: Experiment, path: Path, *, pictures: Path | None, ran: Sequence[str], models: Sequence[str],
    assignments: Sequence[str],
) -> Import:  # fmt: skip
    """Read and check all that is to be imported.

    Parameters
    ----------
    experiment
        Whose conditions the trials show.
    path
        The log, a CSV file.
    pictures
        The folder of the trials' frames, if there is one.
    ran
        What the robot ran, where the log's labels are no registered models: names, or .py files. Of a log without a
        column ``model`` the first; ``dsnn`` if none is given.
    models
        Models to show the frames to.
    assignments
        ``SECTION.NAME=VALUE`` texts: parameters of the experiment, the models and the camera.

    Raises
    ------
    UsageError
        Something cannot be imported, in one line.
    """
    # What the log's models are is not known yet, so their parameters wait.
    of_design = [text for text in assignments if text.startswith("experiment.")]
    log = read(path, configure(experiment, ["dsnn"], of_design)[0])
    if not log.answered and not (models and pictures):
        problem = "no column hs or looming, so no model has answered"
        raise UsageError(f"{log.path}: {problem}: --frames DIR --model dsnn shows the frames to one")
    if models and pictures is None:
        raise UsageError("--model: a model needs --frames DIR to be shown")
    labels = [label or (ran[0] if ran else "dsnn") for label in log.models] if log.answered else []
    sources = {label: _source(log, label, ran) for label in labels}
    try:
        texts = list(dict.fromkeys([*sources.values(), *models]))
        declared, settings = configure(experiment, texts, assignments)
    except UsageError as error:
        if not str(error).startswith("--model") or set(models) & set(str(error).split()):
            raise
        problem = (
            f"the models of {log.path} are {', '.join(labels)}; --ran MODEL.py declares one that is not registered"
        )
        raise UsageError(f"{error} ({problem})") from None
    by_text = dict(zip(texts, settings.models, strict=True))
    by_label = {
        logged: dataclasses.replace(by_text[sources[label]], label=label if logged else by_text[sources[label]].label)
        for logged, label in zip(log.models if labels else (), labels, strict=True)
    }
    taken = {model.label for model in by_label.values()}
    models_shown = tuple(_beside(by_text[text], taken) for text in models)
    settings = dataclasses.replace(settings, models=(*by_label.values(), *models_shown))
    frames = None
    if pictures is not None:
        frames = FrameFolder(pictures, (settings.camera.height, settings.camera.width))
        frames.check(log)
    most = max(Counter(trial.condition for trial in log.trials).values())
    plan = Import(log, Plan(declared, settings, most, 0, experiment.design), frames, by_label, models_shown)
    _check_channels(plan)
    _check_rates(plan)
    return plan


def _source(log: Log, label: str, ran: Sequence[str]) -> str:
    """Return what ``--model`` would be given for a label of the log: of one eye's model, that model.

    Raises `UsageError` for the path of a file: a file is run where ``--ran`` names it, and not because a cell does.
    """
    named: dict[str, str] = {}
    for text in ran:
        asked = ask(text)
        label_given = choose(asked.source).label
        named[f"{label_given}:{asked.settings}" if asked.settings else label_given] = text
    plain = label.rpartition(MARK)[0] or label
    source = named.get(label) or named.get(plain) or (label if label in ran else plain)
    if source not in ran and is_file(ask(source).source):
        line = next(trial.line for trial in log.trials if label in trial.answers)
        problem = f"model={short(label)}: a log's cell names no file to run: give the same path by --ran too"
        raise UsageError(f"{log.path}, line {line}: {problem}")
    return source


def _beside(model: ConfiguredModel, taken: set[str]) -> ConfiguredModel:
    return dataclasses.replace(model, label=f"{model.label}{SHOWN_FRAMES}") if model.label in taken else model


def _check_channels(plan: Import) -> None:
    """Refuse a log that does not tell the channel whose spikes count."""
    for trial in plan.log.trials:
        for label, model in plan.ran.items():
            answer = trial.answers.get(label)
            if answer is not None and model.counted and model.counted not in answer:
                problem = f"trial {trial.index} has no {model.counted} of {model.label}, whose spikes count"
                raise UsageError(f"{plan.log.path}, line {trial.line}: {problem}")


def _check_rates(plan: Import) -> None:
    """Refuse times by which frames come at quite another rate than the camera is set to: they are in another unit."""
    fps = plan.plan.settings.camera.fps
    for trial in plan.log.trials:
        rate = rate_hz(trial.time_s, fps)
        if 1.0 / MOST_OFF <= rate / fps <= MOST_OFF:
            continue
        units = {"in milliseconds": fps / 1e3, "in microseconds": fps / 1e6, "the number of the frame": 1.0}
        guess = next((unit for unit, unit_models in units.items() if 0.5 < rate / unit_models < 2.0), "in another unit")
        raise UsageError(
            f"{plan.log.path}, line {trial.line}: the frames of trial {trial.index} come at {rate:.3g} per second by"
            f" time_s, camera.fps is {fps:g}: is time_s {guess}? legal are seconds; a camera of another rate takes"
            " --set camera.fps=RATE"
        )


def perform(plan: Import, out: Path, *, recordings: bool, quiet: bool) -> Report:
    """Write the run of a log: everything, or nothing.

    Parameters
    ----------
    plan
        The log, from `prepare`.
    out
        Folder of the run, which is not there yet.
    recordings, quiet
        Whether to record each trial for Rerun, and whether to print no progress.

    Returns
    -------
    Report
        What the run amounts to.

    Raises
    ------
    FileExistsError
        There is something at ``out``.
    UsageError
        A frame cannot be read.
    """
    fps = plan.plan.settings.camera.fps
    rates = [rate_hz(trial.time_s, fps) for trial in plan.log.trials]
    if not quiet:
        _note_rates(plan, rates)
    for note in rate_notes((model, rate) for rate in rates for model in plan.models):
        error_console.print(f"note: {note}", soft_wrap=True, markup=False)
    with _whole(out) as place:
        folder = RunFolder(place, MEASURED_SCHEMA, FRAME_SCHEMA, plan.plan.changed())
        folder.enter({**_described(plan), "recordings": recordings})
        with closing(folder):
            repeats: Counter[Condition] = Counter()
            with progress("import", len(plan.log.trials), quiet) as advance:
                for trial in plan.log.trials:
                    done = _record(plan, trial, repeats[trial.condition], recordings)
                    folder.add(done, trial.condition.label(), trial.seed or 0)
                    repeats[trial.condition] += 1
                    advance()
            folder.flush()
            folder.end()
            report = conclude(plan.plan, folder, folder.failures())
    folder.folder = out  # where it is now, for its notes
    tell(folder)
    return dataclasses.replace(report, folder=out)


def _described(plan: Import) -> dict[str, Any]:
    """Return what ``run.json`` holds."""
    provenances = [_provenance(trial, from_frames=from_frames) for trial in plan.log.trials
            for from_frames, models in ((False, plan.ran), (True, plan.models)) if models]  # fmt: skip
    measured = {
        "provenance": "; ".join(dict.fromkeys(provenances)), "log": str(plan.log.path), "sha256": sha256(plan.log.path),
        "frames": str(plan.frames.folder) if plan.frames else None,
    }  # fmt: skip
    return {**describe(plan.plan), "kind": "measured", "trials": len(plan.log.trials), "measured": measured}


def _whole(out: Path) -> AbstractContextManager[Path]:
    """Return a folder beside ``out`` that becomes it when the block is done, and is removed when that fails."""
    if out.exists() and not (out.is_dir() and not any(out.iterdir())):
        raise FileExistsError(f"{out} is there already: choose another --out, or remove it")
    return replacing_folder(out)


def _record(plan: Import, trial: LoggedTrial, repeat: int, recordings: bool) -> TrialRecord:
    """Return the rows of one trial."""
    frames = None if plan.frames is None else plan.frames.read(trial.index)
    answers = [
        given(plan.ran[label], logged, len(trial.time_s), _provenance(trial, from_frames=False))
        for label, logged in trial.answers.items() if label in plan.ran
    ]  # fmt: skip
    failures = []
    for model in plan.models:
        assert frames is not None, "prepare asks for frames"
        answer = _shown(model, frames, _provenance(trial, from_frames=True))
        if isinstance(answer, Given):
            answers.append(answer)
        else:
            failures.append(Failure(trial.index, model.label, trial.condition.label(), trial.seed or 0, answer))
    if not answers:
        raise TrialError(f"trial {trial.index}: {failures[0].reason}")
    recorded = None
    if recordings:
        from experiments.bench.measured.recording import record  # not before: Rerun takes its time to load

        recorded = recording_of(partial(record, plan.plan.experiment.name, trial, answers, frames))
    camera, name = plan.plan.settings.camera, plan.plan.experiment.name
    rows = tuple(trial_row(name, repeat, trial, answer, camera) for answer in answers)
    table = pl.concat([frame_table(trial, answer) for answer in answers])
    return TrialRecord(trial.index, rows, table, recorded, tuple(failures))


def _provenance(trial: LoggedTrial, *, from_frames: bool) -> str:
    """Return where a trial's answers come from: the robot's own, or ``from_frames`` those of a model that saw these."""
    if trial.simulated:
        return FRAMES_OF_SIMULATION if from_frames else LOG_OF_SIMULATION
    return FRAMES_MEASURED if from_frames else MEASURED


def _shown(model: ConfiguredModel, frames: Images, provenance: str) -> Given | str:
    """Return a model's answers to frames, or what went wrong in it."""
    runner = ModelRunner(model, (frames.shape[1], frames.shape[2]))
    for frame in frames:
        runner.see(frame)
    series = runner.series()
    return runner.trouble if series is None else Given(model, series, (), provenance)


def _note_rates(plan: Import, rates: Sequence[float]) -> None:
    """Say where a log's frames come at another rate, of each trial in ``rates``, than the camera is set to."""
    fps = plan.plan.settings.camera.fps
    if any(rate != fps for rate in rates):
        text = f"its frames come at {min(rates):.2f} to {max(rates):.2f} per second, camera.fps is {fps:g}"
        error_console.print(f"note: {plan.log.path}: {text}; firing rates go by the log's own", soft_wrap=True,
                            markup=False)  # fmt: skip
