"""A robot's log as a source: what its own network responded to each frame, and the frames that its camera took.

A log is a CSV with a row per frame and model. docs/how-to/real-robot.md documents its columns.
"""

from __future__ import annotations

import csv
import dataclasses
import hashlib
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from colias_sim import Pose, bearing
from colias_sim.config import CameraConfig
from dsnn import Response
from dsnn.pictures import read_picture
from experiments.bench.run import record as rerun
from experiments.bench.run.errors import UsageError, short
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.play import Sample, Showing, Trial
from experiments.bench.run.recordings import Images
from experiments.bench.run.rows import COLUMN, OBSERVER
from experiments.bench.sources.conditions import CONDITION_COLUMNS, Condition
from experiments.bench.sources.experiment import Experiment
from experiments.bench.sources.trial_rows import FRAME_SCHEMA, away_cm, responses, windows
from scenes.hints import nearest

TIME, LINE = "time_s", "line"
CHANNELS: Mapping[str, str] = {"hs": "hs_spikes", "vs": "vs_spikes", "looming": "looming_spikes", "azimuth": ""}
"""Channel -> its column of spikes; the azimuth has none."""
RESPONSES = tuple(name for pair in CHANNELS.items() for name in pair if name)
POSES = tuple(f"{robot}_{name}" for robot in ("stimulus", "observer") for name in ("x_cm", "y_cm", "heading_deg"))
"""Columns that a tracker over the arena may add: all of them or none."""
TEXTS = ("model", "origin", "motion", "direction")
COLUMNS = ("trial", "model", "origin", *CONDITION_COLUMNS, TIME, *RESPONSES, *POSES)
ROBOT, SIMULATION = "robot", "simulation"
"""Values of ``origin``; blank is ``robot``. ``colias firmware log`` writes ``simulation``."""
RANGES: Mapping[str, tuple[float, float]] = {
    "trial": (0, 1e6), TIME: (0, 1e6),
    **dict.fromkeys(("hs", "vs", "azimuth"), (-1, 1)), **dict.fromkeys(("hs_spikes", "vs_spikes"), (-1000, 1000)),
    "looming": (0, 1), "looming_spikes": (0, 1000), **dict.fromkeys(POSES, (-1e4, 1e4)),
}  # fmt: skip
"""Column -> its least and its largest value."""
UNKNOWN = ("achieved_speed_cm_s", "path_error_mm", "drift_mm", "drive", "darkest", "brightest", "closest_cm",
           "seconds_in_view")  # fmt: skip
"""Columns of ``trials.parquet`` of which a robot's log knows nothing; of the last two with a tracker it does."""
RATE_TOLERANCE = 0.001
"""Share by which a log's frame rate may differ from the camera's setting and still be taken for it."""
MOST_OFF = 10.0
"""Times by which it may differ: beyond, ``time_s`` is in another unit than seconds."""
PICTURES = (".pgm", ".png")


def read(path: Path, unnamed: str = "dsnn") -> pl.DataFrame:
    """Read and check a robot's log.

    Parameters
    ----------
    path
        The CSV file.
    unnamed
        The model of a log without a column ``model``.

    Returns
    -------
    polars.DataFrame
        Its rows, numbers as numbers and blank cells as null, with the columns ``line``, ``model`` and ``origin``.

    Raises
    ------
    UsageError
        The line and the cell that is wrong.
    """
    with path.open(newline="", encoding="utf-8", errors="replace") as file:
        reader = csv.reader(file)
        names = [name.strip() for name in next(reader, [])]
        _check_header(path, names)
        rows = [(reader.line_num, *(cell.strip() or None for cell in row)) for row in reader if row]
    for line, *row in rows:
        if len(row) != len(names):
            raise UsageError(f"{path}, line {line}: must have {len(names)} cells, as line 1 has, got {len(row)}")
    cells = pl.DataFrame(rows, {LINE: pl.Int64, **dict.fromkeys(names, pl.String)}, orient="row")
    table = _numbers(path, cells)
    if "model" not in table.columns:
        table = table.with_columns(model=pl.lit(unnamed))
    origin = pl.col("origin").fill_null(ROBOT) if "origin" in table.columns else pl.lit(ROBOT)
    table = table.with_columns(origin=origin)
    _check_rows(path, table)
    return table


def _check_header(path: Path, names: Sequence[str]) -> None:
    for name in names:
        if name not in COLUMNS:
            near = nearest(name, COLUMNS, after="; ")
            raise UsageError(f"{path}, line 1: unknown column {short(name)} ({near}all: {', '.join(COLUMNS)})")
        if names.count(name) > 1:
            raise UsageError(f"{path}, line 1: column {name} is there twice")
    needed = ["trial", TIME, *(POSES if set(POSES) & set(names) else ())]
    needed += [name for pair in CHANNELS.items() if set(pair) & set(names) for name in pair if name]
    if missing := [name for name in needed if name not in names]:
        raise UsageError(f"{path}, line 1: column {missing[0]} is missing")


def _numbers(path: Path, cells: pl.DataFrame) -> pl.DataFrame:
    """Return the cells as numbers, where a column has numbers."""
    kinds: dict[str, Any] = {}
    for name in (name for name in cells.columns[1:] if name not in TEXTS):
        kinds[name] = pl.Int64 if name == "trial" or name.endswith("_spikes") else pl.Float64
        value, (low, high) = pl.col(name).cast(kinds[name], strict=False), RANGES.get(name, (-math.inf, math.inf))
        legal = value.is_not_null() & value.is_finite() & (value >= low) & (value <= high)
        what = "a whole number" if kinds[name] is pl.Int64 else "a number"
        between = f" between {low:g} and {high:g}" if math.isfinite(low) else ""
        _refuse(path, cells, pl.col(name).is_not_null() & ~legal, f"{name} must be {what}{between}, got {{{name}!r}}")
    table = cells.with_columns(pl.col(name).cast(kind) for name, kind in kinds.items())
    for name in ("trial", TIME, *(name for name in ("model", *POSES) if name in table.columns)):
        _refuse(path, table, pl.col(name).is_null(), f"{name} is blank")
    return table


def _check_rows(path: Path, table: pl.DataFrame) -> None:
    """Refuse rows that contradict the other rows of their trial or their model."""
    odd = ~pl.col("origin").is_in([ROBOT, SIMULATION])
    _refuse(path, table, odd, f"origin must be {ROBOT} or {SIMULATION}, got {{origin!r}}")
    earlier = pl.col(TIME).diff().over("trial", "model") <= 0
    _refuse(path, table, earlier, "time_s={time_s:g} of trial {trial} is not later than the frame before it")
    for name in (name for name in CONDITION_COLUMNS if name in table.columns):
        other = pl.col(name).ne_missing(pl.col(name).first().over("trial"))
        _refuse(path, table, other, f"{name} is {{{name}}}, but trial {{trial}} began with another value")
    for channel, spikes in CHANNELS.items():
        for name in (name for name in (channel, spikes) if name in table.columns):
            first = pl.col(channel).is_null().first().over("model")
            gap = f"{name} must be there in each frame of {{model}} or in none, and begins otherwise"
            _refuse(path, table, pl.col(name).is_null().ne(first), gap)
    for trial in table.partition_by("trial", maintain_order=True):
        begin, *others = trial.partition_by("model", maintain_order=True)
        for block in others:
            if not block[TIME].equals(begin[TIME]):
                problem = f"trial {block['trial'][0]}: {block['model'][0]} has other times than {begin['model'][0]}"
                raise UsageError(f"{path}, line {block[LINE][0]}: {problem}")


def _refuse(path: Path, table: pl.DataFrame, wrong: pl.Expr, reason: str) -> None:
    """Raise `UsageError` about the first row that is wrong; ``{NAME}`` in the reason stands for a cell of it."""
    for row in table.filter(wrong).head(1).to_dicts():
        raise UsageError(f"{path}, line {row[LINE]}: {reason.format(**row)}")


def condition_of(path: Path, row: Mapping[str, Any], experiment: Experiment) -> Condition:
    """Find the condition of an experiment that a row of a log names; `UsageError` where it names none, or several."""
    given = {name: row[name] for name in CONDITION_COLUMNS if name in row}
    conditions = experiment.conditions()
    fitting = [one for one in conditions if all(getattr(one, name) == value for name, value in given.items())]
    if len(fitting) == 1:
        return fitting[0]
    text = ", ".join(f"{name}={value}" for name, value in given.items()) or "no column of a condition"
    legal = "; ".join(one.label() for one in conditions)
    number = "several conditions" if fitting else "no condition"
    raise UsageError(f"{path}, line {row[LINE]}: {text}: {number} of {experiment.name} (--set experiment.NAME=VALUE"
                     f" changes them): {legal}")  # fmt: skip


def channels_of(table: pl.DataFrame, model: str) -> tuple[str, ...]:
    """Return the channels that a log has of a model."""
    first = table.filter(pl.col("model") == model).row(0, named=True)
    return tuple(channel for channel in CHANNELS if first.get(channel) is not None)


def without(model: ConfiguredModel, unknown: Sequence[str]) -> ConfiguredModel:
    """Return a model that does not declare the channels that are unknown."""
    entry = model.declared
    channels = tuple(channel for channel in entry.channels if channel not in unknown)
    thresholds = {str(channel): name for channel, name in entry.thresholds.items() if channel in channels}
    return dataclasses.replace(model, entry=dataclasses.replace(entry, channels=channels, thresholds=thresholds))


class Playback:
    """A model that responds what a log says that the robot's own responded: a row of it for each frame."""

    def __init__(self, rows: pl.DataFrame) -> None:
        self._responses = iter(rows.select(name for name in RESPONSES if name in rows.columns).to_dicts())

    def step(self, frame: Any) -> Response:
        """Return the response of the next row."""
        known = {name: value for name, value in next(self._responses).items() if value is not None}
        return Response(**{"hs": 0.0, "vs": 0.0, "hs_spikes": 0, "vs_spikes": 0, **known})


@dataclass(frozen=True, slots=True)
class LogTrial(Trial):
    """A trial of a log.

    Parameters
    ----------
    rows
        Its rows.
    camera
        The robot's.
    frames
        The folder of the trials' frames, if there is one.
    origins
        Label of a model -> where its responses come from.
    unknown
        Label of a model that the log has -> the channels that it has and the log has not.
    """

    rows: pl.DataFrame
    camera: CameraConfig
    frames: Path | None
    origins: Mapping[str, str]
    unknown: Mapping[str, Sequence[str]]

    @property
    def shown(self) -> pl.DataFrame:
        """A row per frame: those of the first model."""
        return self.rows.filter(pl.col("model") == self.rows["model"][0])

    @property
    def fps(self) -> float:
        """Frame rate, 1/s: that of the camera where the times go by it, else what they tell."""
        times, nominal = self.shown[TIME], self.camera.fps
        rate = 1.0 / float(np.median(np.diff(times))) if len(times) > 1 else nominal
        return nominal if abs(rate / nominal - 1.0) <= RATE_TOLERANCE else rate

    def sources(self) -> Iterator[tuple[str, LogSource, Sequence[ConfiguredModel]]]:
        """Open the source; models that the log has respond what it says."""
        yield (
            "",
            LogSource(self),
            [self._played(model) if model.label in self.unknown else model for model in self.models],
        )

    def _played(self, model: ConfiguredModel) -> ConfiguredModel:
        rows = self.rows.filter(pl.col("model") == model.label)
        known = without(model, self.unknown[model.label])

        def build(_shape: tuple[int, int], _parameters: Any) -> Any:
            return Playback(rows)

        return dataclasses.replace(known, entry=dataclasses.replace(known.declared, build=build))

    def frame_rates(self) -> Iterator[tuple[ConfiguredModel, float]]:
        """Return each model with the log's frame rate, 1/s."""
        return ((model, self.fps) for model in self.models)


class LogSource:
    """The frames of a log's trial, blank ones where nobody kept them, with the poses that a tracker has told.

    Parameters
    ----------
    trial
        The trial.

    Raises
    ------
    UsageError
        A frame cannot be read, or has another size than the camera.
    """

    frame_columns = FRAME_SCHEMA

    def __init__(self, trial: LogTrial) -> None:
        self.trial, self.fps, self.shape = trial, trial.fps, (trial.camera.height, trial.camera.width)
        self.tracked = POSES[0] in trial.rows.columns

    def __iter__(self) -> Iterator[Sample]:
        """Yield the frames."""
        trial, rows = self.trial, self.trial.shown.to_dicts()
        frames = np.zeros((len(rows), *self.shape), np.uint8)
        if trial.frames is not None:
            frames = read_frames(frame_files(trial.frames, trial.index), self.shape)
        for row, image in zip(rows, frames, strict=True):
            truth = {"robot": OBSERVER, "sim_time_s": row[TIME], "stimulus_bearing_deg": None}
            truth |= {name: row.get(name) for name in POSES}
            if self.tracked:
                stimulus, observer = (_pose(row, robot) for robot in ("stimulus", "observer"))
                ahead = bearing(observer, stimulus, trial.camera.forward_cm / 100)
                truth["stimulus_bearing_deg"] = math.degrees(ahead)
            yield Sample(row[TIME], image, truth)

    def columns(self) -> dict[str, Any]:
        """Return the robot that sees, and the condition. A robot's trial has no seed."""
        return {"robot": OBSERVER, "seed": None, **self.trial.condition.columns()}

    def measures(self, model: ConfiguredModel, frames: pl.DataFrame) -> dict[str, Any]:
        """Return a model's responses in the whole trial, and with a tracker in parts of it; null where unknown.

        Parameters
        ----------
        model
            The model.
        frames
            A row per frame: time, poses, responses.
        """
        trial, measured = self.trial, dict[str, Any](dict.fromkeys(UNKNOWN))
        parts = windows(trial.condition, trial.camera, frames) if self.tracked else {}
        if self.tracked:
            measured["closest_cm"] = float(away_cm(frames, trial.camera.forward_cm).min())
            measured["seconds_in_view"] = float(parts["in_view"].sum()) / self.fps
        measured |= responses(model, frames, parts, self.fps)
        for channel in trial.unknown.get(model.label, ()):
            measured |= {name: None for name in (f"peak_{channel}", f"trough_{channel}") if name in measured}
        return {**measured, COLUMN: trial.origins[model.label]}


def _pose(row: Mapping[str, Any], robot: str) -> Pose:
    return Pose(row[f"{robot}_x_cm"] / 100, row[f"{robot}_y_cm"] / 100, math.radians(row[f"{robot}_heading_deg"]))


def frame_files(folder: Path, trial: int) -> list[Path]:
    """Return the pictures of a trial in the order of their numbers, 2 before 10; empty where there are none."""
    pictures = [path for path in (folder / f"trial-{trial:04d}").glob("*") if path.suffix.lower() in PICTURES]
    return sorted(pictures, key=in_order)


def in_order(path: Path) -> list[str]:
    """Return a key that sorts files by the numbers in their names."""
    return [part.zfill(20) for part in re.findall("[0-9]+", path.stem)]


def read_frames(files: Sequence[Path], shape: tuple[int, int] | None = None) -> Images:
    """Read pictures as a camera measured them, (T, R, C); `UsageError` for one of another size or kind."""
    frames: list[Images] = []
    for path in files:
        try:
            frames.append(read_picture(path, raw=True))
        except ValueError as error:
            raise UsageError(str(error)) from None
        rows, columns = shape or frames[0].shape
        if frames[-1].shape != (rows, columns):
            height, width = frames[-1].shape
            raise UsageError(
                f"{path} has {width}x{height} px, not {columns}x{rows} (--set camera.width, camera.height)"
            )
    return np.stack(frames)


def record(trial: LogTrial, showings: Sequence[Showing], rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return the recording of a log's trial, as the bytes of an .rrd file: frames where there are some, responses."""
    (showing,) = showings
    truth, shown = showing.truth(), {model.label: (model, series) for model, series in showing.series()}
    images = {"": np.stack([sample.image for sample in showing.samples])} if trial.frames else {}
    responses_by_model = {label: series for label, (_, series) in shown.items()}
    frames = rerun.Frames(truth["sim_time_s"].to_numpy(), np.arange(truth.height), responses_by_model, images)
    content = rerun.Content(tuple(rerun.Model.of(model) for model, _ in shown.values()), tuple(images))
    origin = rows[0][COLUMN]
    values = {"experiment": trial.experiment, "trial": trial.index, COLUMN: origin, **trial.condition.columns()}
    digest = hashlib.blake2s(trial.rows.write_csv().encode(), digest_size=6).hexdigest()
    return rerun.write(
        content, frames, f"{trial.index:04d} {trial.condition.label()}, {origin}",
        f"{trial.experiment}-measured-{trial.index:04d}-{digest}", {"trial": rerun.known(values)},
    )  # fmt: skip
