"""Write a run as the log that a robot would have sent: `experiments.bench.measured.log` reads it back."""

from __future__ import annotations

import csv
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from experiments.bench.measured.frames import PGM, trial_name
from experiments.bench.measured.log import ANSWERS, CHANNELS, INDEX, POSES, ROBOT, SIMULATION, TIME
from experiments.bench.run.errors import UsageError
from experiments.bench.run.user_code import is_file
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.store.description import THRESHOLDS
from experiments.bench.store.origin import COLUMN, FRAMES_MEASURED, MEASURED
from experiments.bench.store.pictures import pictures, write_pictures
from experiments.bench.store.record import Record
from experiments.bench.store.rows import group

LOG, FRAMES = "log.csv", "frames"
CAMERA = "camera"
"""The entity of a recording that has the frames of the camera as it is set."""

Row = Mapping[str, Any]


def write_log(run: Record, out: Path, *, tracked: bool, advance: Callable[[], None]) -> str:
    """Write a run of the robot as a log: `LOG`, and `FRAMES` where the run has some.

    Parameters
    ----------
    run
        The run; its recordings hold the frames of the camera.
    out
        A new folder.
    tracked
        Whether to write poses too, as a tracker over the arena would give them.
    advance
        Called once a trial.

    Returns
    -------
    str
        The command that imports what was written.

    Raises
    ------
    UsageError
        The run is not of the robot.
    """
    if not run.kind.robot:
        raise UsageError(f"{run.folder}: a log is of trials with the robot, not of {run.kind.what}")
    rows = run.trials.to_dicts()
    channels = _channels(run.description, rows)
    header = [*INDEX, *CONDITION_COLUMNS, TIME]
    header += [name for channel, spikes in CHANNELS.items() for name in (channel, spikes)
               if name and any(channel in model_rows for model_rows in channels.values())]  # fmt: skip
    header += POSES if tracked else ()
    out.mkdir(parents=True, exist_ok=True)
    model_rows = run.frames.partition_by("trial", "model", as_dict=True)
    with (out / LOG).open("w", newline="", encoding="utf-8") as file:
        lines = csv.writer(file, lineterminator="\n")
        lines.writerow(header)
        for row in rows:
            lines.writerows(
                _lines(header, row, model_rows[row["trial"], row["model"]].to_dicts(), channels[row["model"]])
            )
    there = {path.stem: path for path in run.recordings}
    for trial in dict.fromkeys(row["trial"] for row in rows):
        recording = there.get(trial_name(trial))
        seen = pictures(recording).get(CAMERA) if recording else None
        if seen is not None:
            write_pictures(out / FRAMES / trial_name(trial), seen, PGM)
        advance()
    pictured = out / FRAMES if (out / FRAMES).is_dir() else None
    return _command(run.description, out / LOG, pictured, channels)


def _lines(header: Sequence[str], row: Row, frames: Iterable[Row], channels: Sequence[str]) -> Iterator[list[str]]:
    """Yield the lines of one trial as one model answered it."""
    known = {name for channel in channels for name in (channel, CHANNELS[channel])}
    for frame in frames:
        values = {**row, TIME: frame["sim_time_s"], **{name: frame[name] for name in header if name in frame}}
        values |= {name: None for name in ANSWERS if name not in known}
        values["origin"] = ROBOT if row.get(COLUMN) in (MEASURED, FRAMES_MEASURED) else SIMULATION
        yield [_cell(values[name]) for name in header]


def _cell(value: Any) -> str:
    """Return the shortest text that is the same number again; blank for null."""
    return "" if value is None else repr(value) if isinstance(value, float) else str(value)


def _channels(description: Mapping[str, Any], rows: Sequence[Row]) -> dict[str, tuple[str, ...]]:
    """Model -> the channels that it declares, and that the run knows. No model's file is run for it."""
    return {
        str(label): tuple(
            channel for channel in description[THRESHOLDS][label]
            if not CHANNELS[channel] or model_rows[0][CHANNELS[channel]] is not None
        )
        for (label,), model_rows in group(rows, "model").items()
    }  # fmt: skip


def _command(description: Mapping[str, Any], log: Path, frames: Path | None, models: Iterable[str]) -> str:
    """Return the command that imports what was written, with every parameter that is not at its default."""
    words = ["colias", "import", str(log), *(["--frames", str(frames)] if frames else [])]
    words += ["--experiment", _declared(description)]
    listed = description["settings"]["models"]
    words += [word for model in listed if is_file(model["source"]) for word in ("--ran", model["source"])]
    for key, values in (description.get("changed") or {}).items():
        # What stands in a label after its colon is a model's own.
        name = key.partition(".")[2]
        common = {str(value).lower() if isinstance(value, bool) else str(value) for label, value in values.items()
                  if value is not None and f"{name}=" not in label.partition(":")[2]}  # fmt: skip
        words += [word for value in sorted(common) for word in ("--set", f"{key}={value}")]
    return shlex.join(words)


def _declared(description: Mapping[str, Any]) -> str:
    """Return the experiment as the run was given it: the path of a file, or its name."""
    command = description["command"]
    words = command.get("line") or ["run", str(command["arguments"]["experiment"])]
    files = (word for before, word in pairwise(words) if word.endswith(".py") and not before.startswith("-"))
    file = next(files, None)
    return str(Path(command["folder"], file)) if file else str(description["experiment"]["name"])
