"""A robot's log: read and made a run, written of a run, decoded of what a board has sent.

A log is a CSV with a row per frame and model. docs/how-to/real-robot.md documents its columns. A board's serial line
has records: ``dsnn/native/firmware/record.h`` has their form, ``measure_main.c`` the list of them.
"""

from __future__ import annotations

import binascii
import codecs
import dataclasses
import hashlib
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
import polars as pl

from colias_sim import bearing
from colias_sim.config import CameraConfig
from dsnn import Response
from dsnn.pictures import read_picture
from experiments.base.console import count
from experiments.base.errors import UsageError, as_usage_error, check_known
from experiments.declare.conditions import CONDITION_COLUMNS, Condition, pose_of
from experiments.declare.experiment import Experiment
from experiments.robot.firmware import MODEL
from experiments.robot.qemu import Q15
from experiments.settings.models import ConfiguredModel
from experiments.settings.pictures import by_number
from experiments.show import record as rerun
from experiments.show.play import Sample, Showing, Trial
from experiments.show.trial_rows import FRAME_SCHEMA, TRIAL_SCHEMA, away_cm, responses, windows
from experiments.store.recordings import Images
from experiments.store.tables import COLUMN, OBSERVER

Floats = npt.NDArray[np.float64]
TIME, LINE = "time_s", "line"
CHANNELS: Mapping[str, str] = {"hs": "hs_spikes", "vs": "vs_spikes", "looming": "looming_spikes", "azimuth": ""}
"""Channel -> its column of spikes; the azimuth has none."""
RESPONSES = tuple(name for pair in CHANNELS.items() for name in pair if name)
POSES = tuple(f"{robot}_{name}" for robot in ("stimulus", "observer") for name in ("x_cm", "y_cm", "heading_deg"))
"""Columns that a tracker over the arena may add: all of them or none."""
_TYPES = {**TRIAL_SCHEMA, **FRAME_SCHEMA, "origin": pl.String(), TIME: pl.Float64()}
SCHEMA = pl.Schema(
    {name: _TYPES[name] for name in ("trial", "model", "origin", *CONDITION_COLUMNS, TIME, *RESPONSES, *POSES)}
)
"""Columns of a log."""
RANGES = {"hs": (-1, 1), "vs": (-1, 1), "azimuth": (-1, 1), "looming": (0, 1), "looming_spikes": (0, 1e6)}
"""Column -> its least and its largest value; of the others a million."""
OTHER_TABLES = {b"PK\x03": "a workbook", b"\0": "no UTF-8", b";": "semicolons", b"\t": "tabs", b"|": "bars"}
"""What the first line of another table than a log has -> its name."""
ROBOT, SIMULATION = "robot", "simulation"
"""Values of ``origin``; blank is ``robot``. ``colias firmware log`` writes ``simulation``."""
UNKNOWN = ("phase", "achieved_speed_cm_s", "path_error_mm", "drift_mm", "drive", "darkest", "brightest", "closest_cm",
           "seconds_in_view")  # fmt: skip
"""Columns of ``trials.parquet`` of which a robot's log knows nothing; of the last two with a tracker it does."""
MEASURED = "measured", "frames measured, network simulated"
"""Where the rows of the robot's own network come from, and those of a model that was shown the robot's frames."""
LOG_OF_SIMULATION = "log of a simulated run", "frames from the log of a simulated run"
"""The same of a log that ``colias firmware log`` wrote: nothing of it was measured."""
RATE_TOLERANCE = 0.001
"""Share by which a log's frame rate may differ from the camera's setting and still be taken for it."""
MOST_TICK = 0.95
"""Longest tick of a log's clock, as a share of a frame's time, for which the camera's setting may explain the times."""
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
        Its rows, of `SCHEMA`, with the columns ``line``, ``model`` and ``origin``.

    Raises
    ------
    UsageError
        The line and what is wrong in it.
    """
    cells = _cells(path)
    names = cells.columns[1:]
    for name in names:
        check_known(f"{path}, line 1: column", name, SCHEMA)
    whole = ["trial", TIME, *(POSES if set(POSES) & set(names) else ())]
    pairs = [pair for pair in CHANNELS.items() if set(pair) & set(names)]
    if missing := [name for name in (*whole, *(name for pair in pairs for name in pair if name)) if name not in names]:
        raise UsageError(f"{path}, line 1: column {missing[0]} is missing")
    table = cells.cast({name: SCHEMA[name] for name in names}, strict=False)
    for name in (name for name in names if SCHEMA[name].is_numeric()):
        low, high = RANGES.get(name, (-1e6, 1e6))
        illegal = cells[name].is_not_null() & ~table[name].is_between(low, high).fill_null(False)
        what = "a whole number" if SCHEMA[name].is_integer() else "a number"
        _refuse(path, cells.filter(illegal), f"{name} must be {what} from {low:g} to {high:g}, got '{{{name}}}'")
    given = {"model": pl.lit(unnamed), "origin": pl.lit(ROBOT)}
    table = table.with_columns(**{name: value for name, value in given.items() if name not in names})
    table = table.with_columns(pl.col("origin").fill_null(ROBOT))
    condition = pl.struct("trial", *(name for name in CONDITION_COLUMNS if name in names))
    rules = {
        f"{', '.join(whole)} and model must not be blank": pl.any_horizontal(pl.col("model", *whole).is_null()),
        "{time_s:g} is not later than the frame before it": pl.col(TIME).diff().over("trial", "model") <= 0,
        "trial {trial} began with another condition": condition.ne_missing(condition.first().over("trial")),
        "all models of a trial must have the same frames":
            pl.len().over("trial", TIME) != pl.col("model").n_unique().over("trial"),
        **{f"{name} must be there in each frame of {{model}} or in none":
            pl.col(name).is_null() != pl.col(channel).is_null().first().over("model")
           for channel, spikes in pairs for name in (channel, spikes) if name},
        **{f"{channel} is {{{channel}:g}} and {spikes} {{{spikes}}}, the spikes must be {meaning}": broken
           for channel, spikes in pairs if spikes for meaning, broken in _contradictions(channel, spikes).items()},
    }  # fmt: skip
    for reason, broken in rules.items():
        _refuse(path, table.filter(broken), reason)
    return table


def _cells(path: Path) -> pl.DataFrame:
    """Read the cells of a CSV as texts, with the number of their line; blank rows are dropped."""
    data = path.read_bytes()
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        data = data.decode("utf-16", "replace").encode()
    heading = data.lstrip().partition(b"\n")[0]
    words = f"{path} must have commas between its cells, and decimal points: save it as a CSV with these, got"
    if mark := next((name for mark, name in OTHER_TABLES.items() if mark in heading), ""):
        raise UsageError(f"{words} {mark}")
    try:
        cells = pl.read_csv(data, infer_schema=False, encoding="utf8-lossy", row_index_name=LINE, row_index_offset=2)
    except pl.exceptions.PolarsError as error:
        raise UsageError(f"{words}: {str(error).splitlines()[0]}") from None
    return cells.filter(pl.any_horizontal(pl.col(cells.columns[1:]).str.strip_chars().fill_null("") != ""))


def _contradictions(channel: str, spikes: str) -> Mapping[str, pl.Expr]:
    """Return what spikes must be -> where they contradict the potential, and so are something else."""
    size, potential, trial = pl.col(spikes).abs(), pl.col(channel), ("trial", "model")
    never_falls, most = (size.diff().fill_null(0) >= 0).all().over(trial), size.max().over(trial)
    excess = potential.abs() - potential.abs().min().over(trial)
    of_fewer = pl.when(size < most).then(excess).max().over(trial)
    return {
        "signed as the potential is (255 of a byte is -1)": potential.sign() * pl.col(spikes) < 0,
        # Sums so far are largest at the end of a trial, when the potential is at rest again.
        "those of one frame, not the sum so far": never_falls & (size == most) & (most > 1) & (excess < of_fewer / 2),
    }


def _refuse(path: Path, wrong: pl.DataFrame, reason: str) -> None:
    """Raise `UsageError` about the first of some rows; ``{NAME}`` in the reason stands for a cell of it."""
    for row in wrong.head(1).to_dicts():
        raise UsageError(f"{path}, line {row[LINE]}: {reason.format(**row)}")


def condition_of(path: Path, row: Mapping[str, Any], experiment: Experiment) -> Condition:
    """Find the condition of an experiment that a row of a log names; `UsageError` where it names none, or several."""
    given = {name: row[name] for name in CONDITION_COLUMNS if name in row}
    conditions = experiment.conditions()
    fitting = [one for one in conditions if all(getattr(one, name) == value for name, value in given.items())]
    if len(fitting) != 1:
        text = ", ".join(f"{name}={value}" for name, value in given.items()) or "no column of a condition"
        legal = "; ".join(one.label() for one in conditions)
        raise UsageError(f"{path}, line {row[LINE]}: {text} must be one condition of {experiment.name} (--set"
                         f" experiment.NAME=VALUE changes them): {legal}")  # fmt: skip
    return fitting[0]


def logged(model: ConfiguredModel, rows: pl.DataFrame) -> ConfiguredModel:
    """Return a model that responds what its rows of a log say, and declares no channel that they lack.

    Raises `UsageError` where they lack all.
    """
    entry = model.declared
    first = rows.row(0, named=True)
    channels = tuple(channel for channel in entry.channels if first.get(channel) is not None)
    thresholds = {channel: name for channel, name in entry.thresholds.items() if channel in channels}
    if not channels:
        raise UsageError(f"the log has no response of {model.label}, whose columns are {', '.join(entry.channels)}")

    def build(_shape: tuple[int, int], _parameters: Any) -> Any:
        played = iter(rows.select(name for name in RESPONSES if name in rows.columns).to_dicts())
        blank = {"hs": 0.0, "vs": 0.0, "hs_spikes": 0, "vs_spikes": 0}

        def step(_frame: Any) -> Response:
            return Response(**blank | {name: value for name, value in next(played).items() if value is not None})

        return SimpleNamespace(step=step)

    entry = dataclasses.replace(entry, channels=channels, thresholds=thresholds, build=build)
    return dataclasses.replace(model, declared=entry)


@dataclass(frozen=True, slots=True)
class LogTrial(Trial):
    """A trial of a log, and the source of its frames.

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

    frame_columns: ClassVar[pl.Schema] = FRAME_SCHEMA

    @property
    def shown(self) -> pl.DataFrame:
        """A row per frame: those of the first model."""
        return self.rows.filter(pl.col("model") == self.rows["model"][0])

    @property
    def fps(self) -> float:
        """Frame rate, 1/s: that of the camera where the times go by it, else what they tell."""
        rate, _ = rate_and_steps(self.shown[TIME].to_numpy(), self.camera.fps)
        return self.camera.fps if abs(rate / self.camera.fps - 1.0) <= RATE_TOLERANCE else rate

    @property
    def shape(self) -> tuple[int, int]:
        """(R, C) of a frame."""
        return self.camera.height, self.camera.width

    @property
    def tracked(self) -> bool:
        """Whether a tracker has told the poses."""
        return POSES[0] in self.rows.columns

    def sources(self) -> Iterator[tuple[str, Any, Sequence[ConfiguredModel]]]:
        """Return the trial itself as the source; models that the log has respond what it says."""
        rows = self.rows.partition_by("model", as_dict=True)
        models = [logged(m, rows[(m.label,)]) if m.label in self.unknown else m for m in self.models]
        yield "", self, models

    def __iter__(self) -> Iterator[Sample]:
        """Yield the frames, blank ones where nobody kept them, with the poses that a tracker has told."""
        rows = self.shown.to_dicts()
        frames = np.zeros((len(rows), *self.shape), np.uint8)
        if self.frames is not None:
            frames = read_frames(trial_folder(self.frames, self.index), self.shape)
        for row, image in zip(rows, frames, strict=True):
            truth = {"robot": OBSERVER, "time_s": row[TIME], "stimulus_bearing_deg": None}
            truth |= {name: row.get(name) for name in POSES}
            if self.tracked:
                stimulus, observer = (pose_of(itemgetter(*names)(row)) for names in (POSES[:3], POSES[3:]))
                ahead = bearing(observer, stimulus, self.camera.forward_cm / 100)
                truth["stimulus_bearing_deg"] = math.degrees(ahead)
            yield Sample(row[TIME], image, truth)

    def columns(self, _truth: pl.DataFrame) -> dict[str, Any]:
        """Return the robot that sees, and the condition. A robot's trial has no seed."""
        return {"robot": OBSERVER, "seed": None, **self.condition.columns()}

    def measures(self, model: ConfiguredModel, frames: pl.DataFrame) -> dict[str, Any]:
        """Return a model's responses in the whole trial, and with a tracker in parts of it.

        Parameters
        ----------
        model
            The model.
        frames
            A row per frame: time, poses, responses.
        """
        parts = windows(self.condition, self.camera, frames) if self.tracked else {}
        measured = {**dict.fromkeys(UNKNOWN), **responses(model, frames, parts, self.fps)}
        if self.tracked:
            measured["closest_cm"] = float(away_cm(frames, self.camera.forward_cm).min())
            measured["seconds_in_view"] = float(parts["in_view"].sum()) / self.fps
        lost = {f"{end}_{channel}" for channel in self.unknown.get(model.label, ()) for end in ("peak", "trough")}
        return {**measured, **dict.fromkeys(lost & measured.keys()), COLUMN: self.origins[model.label]}


def rate_and_steps(time_s: Floats, nominal: float) -> tuple[float, Floats]:
    """Find the rate of a camera by the times of its frames, and how many frames it went from each time to the next.

    A clock that ticks rounds the times, so single differences tell no rate: only the whole stretch does. Where the
    ticks are nearly as long as a frame, several rates explain the times. Then the rate with the fewest lost frames
    counts, and the nominal one before others.

    Parameters
    ----------
    time_s
        Times in s that grow, (T,).
    nominal
        The rate that the camera should have, 1/s.

    Returns
    -------
    rate : float
        Frames per second.
    steps : ndarray
        (T - 1,) whole numbers: 1, or more where frames are lost. After a time that came late the next is 0.
    """
    waits = np.diff(time_s)
    if not waits.size:
        return nominal, waits
    period = waits[waits < 1.8 * np.median(waits)].mean()  # without waits for lost frames
    for _ in range(3):
        steps = np.rint(waits / period)
        period = waits.sum() / steps.sum()
    # Frames at the nominal rate have phases in its period that spread by less than a tick.
    tick = nominal * float(np.gcd.reduce(np.rint(1e6 * waits).astype(np.int64))) / 1e6
    phases = np.sort(time_s * nominal % 1.0)
    free = np.diff(phases, append=phases[0] + 1.0)
    spread, first = 1.0 - free.max(), phases[(free.argmax() + 1) % len(phases)]
    of_nominal = np.diff(np.rint(time_s * nominal - first - spread / 2))
    explained = spread < tick - 1e-6 and tick < MOST_TICK and of_nominal.sum() <= steps.sum()
    return (nominal, of_nominal) if explained else (float(1.0 / period), steps)


def trial_folder(folder: Path, trial: int) -> Path:
    """Return the folder of a trial's frames."""
    return folder / f"trial-{trial:04d}"


def pictures_in(folder: Path) -> list[Path]:
    """Return the pictures of a folder in the order of their numbers, 2 before 10; empty where there are none."""
    return sorted((path for path in folder.glob("*") if path.suffix.lower() in PICTURES), key=by_number)


def read_frames(folder: Path, shape: tuple[int, int] | None = None) -> Images:
    """Read pictures as a camera measured them, (T, R, C); `UsageError` for one of another size or kind."""
    with as_usage_error():
        frames = [read_picture(path, raw=True) for path in pictures_in(folder)]
    sizes = {frame.shape for frame in frames}
    if len(sizes) != 1 or shape not in (None, *sizes):
        rows, columns = shape or ("R", "C")
        raise UsageError(f"{folder} must have pictures ({', '.join(PICTURES)}) of {columns}x{rows} px, all of one size")
    return np.stack(frames)


def record(trial: LogTrial, showings: Sequence[Showing], rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return the recording of a log's trial, as the bytes of an .rrd file: frames where there are some, responses."""
    (showing,) = showings
    truth, shown = showing.truth(), showing.series()
    images = {"": np.stack([sample.image for sample in showing.samples])} if trial.frames else {}
    by_model = {model.label: series for model, series in shown}
    frames = rerun.Frames(truth["time_s"].to_numpy(), np.arange(truth.height), by_model, images)
    content = rerun.Content(tuple(rerun.RecordedModel.of(model) for model, _ in shown), tuple(images))
    origin = rows[0][COLUMN]
    values = {"experiment": trial.experiment, "trial": trial.index, COLUMN: origin, **trial.condition.columns()}
    digest = hashlib.blake2s(trial.rows.write_csv().encode(), digest_size=6).hexdigest()
    return rerun.write(
        content, frames, f"{trial.index:04d} {trial.label()}, {origin}",
        f"{trial.experiment}-measured-{trial.index:04d}-{digest}", {"trial": rerun.known(values)},
    )  # fmt: skip


LOG, FRAMES = "log.csv", "frames"
LEAST_FPS = 0.5
"""Slowest rate of a log's frames, 1/s: below, ``time_s`` is in another unit than seconds."""


def lacking(trial: LogTrial) -> tuple[int, str]:
    """Return how many frames a log lacks inside a trial, by their times, and a note about them; empty of none."""
    times = trial.shown[TIME].to_numpy()
    lost = rate_and_steps(times, trial.camera.fps)[1] - 1  # -1 where a late time stamp is made up for
    if (number := round(float(lost.sum()))) <= 0:
        return 0, ""
    return number, (f"trial {trial.index} lacks {count(number, 'frame')} at {trial.fps:.3g} frames/s, the first after"
                    f" {times[(lost > 0).argmax()]:.2f} s: spikes of these frames are not counted")  # fmt: skip


NONE = "-"
"""What stands where a board cannot tell."""
BOARD = ("version", "board", "columns", "rows", "trials", "frames", "frame_us", "clock_hz", "flash_waits", "counter")
FRAME = ("trial", "frame", "hs", "vs", "hs_spikes", "vs_spikes", "cycles")
FIELDS = {"board": BOARD, "frame": FRAME, "stack": ("bytes",), "end": ("sent",)}
"""Record -> its fields."""
KINDS = {**dict.fromkeys(("board", "counter"), str), **dict.fromkeys(("clock_hz", "flash_waits", "cycles"), int | None)}
"""Field -> what it is; the others are whole numbers."""
_WHOLE = re.compile(r"-?\d{1,10}")
_SERIAL = re.compile(rb"\$([a-z0-9,-]*)\*([0-9A-F]{4})\r?")


def crc(content: bytes) -> int:
    """CRC-16 of a record's content: polynomial 0x1021, from 0xFFFF."""
    return binascii.crc_hqx(content, 0xFFFF)


def decode(data: bytes) -> tuple[pl.DataFrame, Mapping[str, Any], int]:
    """Decode a capture of the serial line. A line that is damaged, or of another firmware, is skipped.

    Parameters
    ----------
    data
        The bytes as they came. Where the program ran several times, as after a reset of the board, a frame counts as it
        was sent last; where another program ran, the frames before it are dropped.

    Returns
    -------
    polars.DataFrame
        A row per frame: potentials in Q15, spikes, and cycles, null where none were counted.
    dict
        Fields of the records ``board`` and ``stack``; empty where these are lost.
    int
        Number of lines that were skipped.
    """
    frames, board, skipped = [], dict[str, Any](), 0
    for line in filter(bytes.strip, data.split(b"\n")):
        match = _SERIAL.fullmatch(line)
        kind, *texts = match[1].decode().split(",") if match else [""]
        values = [None if text == NONE else int(text) if _WHOLE.fullmatch(text) else text for text in texts]
        record = dict(zip(names := FIELDS.get(kind, ()), values, strict=False))
        ours = 0 < len(names) == len(values) and all(isinstance(record[name], KINDS.get(name, int)) for name in names)
        if match is None or int(match[2], 16) != crc(match[1]) or not ours:
            skipped += 1
        elif kind == "frame":
            frames.append(record)
        elif kind != "end":
            if kind == "board" and any(board.get(name, value) != value for name, value in record.items()):
                frames, board = [], {}  # another program was flashed meanwhile
            board |= record
    table = pl.DataFrame(frames, dict.fromkeys(FRAME, pl.Int64))
    return table.unique(["trial", "frame"], keep="last").sort("trial", "frame"), board, skipped


def log_of(frames: pl.DataFrame, board: Mapping[str, Any]) -> pl.DataFrame:
    """Return the frames as a log that ``colias import`` reads: the robot's where a board says so that is no emulator.

    Where the board's record is lost, frames came 30 a second.
    """
    origin = SIMULATION if board.get("board", "qemu-").startswith("qemu-") else ROBOT
    time_s = (pl.col("frame") + 1) * board.get("frame_us", 33_333) / 1e6
    return frames.select(
        "trial", model=pl.lit(MODEL), origin=pl.lit(origin), time_s=time_s.round(6),
        hs=pl.col("hs") / Q15, hs_spikes="hs_spikes", vs=pl.col("vs") / Q15, vs_spikes="vs_spikes",
    )  # fmt: skip
