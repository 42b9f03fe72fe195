"""A robot's log: its columns, and what a file of them has to be.

A log is a CSV with a row per frame and model. docs/how-to/real-robot.md documents its columns.
"""

import codecs
import dataclasses
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import polars as pl

from dsnn import Response
from experiments.base.errors import UsageError, check_known
from experiments.declare.conditions import CONDITION_COLUMNS, Condition
from experiments.declare.experiment import Experiment
from experiments.settings.models import ConfiguredModel
from experiments.show.trial_rows import FRAME_SCHEMA, TRIAL_SCHEMA

LOG, FRAMES = "log.csv", "frames"
TIME, LINE = "time_s", "line"
CHANNELS: Mapping[str, str] = {
    "hs": "hs_spikes", "vs": "vs_spikes", "looming": "looming_spikes",
    **dict.fromkeys(("azimuth", "target", "elevation", "target_direction"), ""),
}  # fmt: skip
"""Channel -> its column of spikes; positions and the strength of a target have none."""
RESPONSES = tuple(name for pair in CHANNELS.items() for name in pair if name)
POSES = tuple(f"{robot}_{name}" for robot in ("stimulus", "observer") for name in ("x_cm", "y_cm", "heading_deg"))
"""Columns that a tracker over the arena may add: all of them or none."""
_TYPES = {**TRIAL_SCHEMA, **FRAME_SCHEMA, "origin": pl.String(), TIME: pl.Float64()}
SCHEMA = pl.Schema(
    {name: _TYPES[name] for name in ("trial", "model", "origin", *CONDITION_COLUMNS, TIME, *RESPONSES, *POSES)}
)
"""Columns of a log."""
RANGES = {**dict.fromkeys(("hs", "vs", "azimuth", "elevation"), (-1, 1)), "looming": (0, 1), "looming_spikes": (0, 1e6)}
"""Column -> its least and its largest value; of the others a million."""
OTHER_TABLES = {b"PK\x03": "a workbook", b"\0": "no UTF-8", b";": "semicolons", b"\t": "tabs", b"|": "bars"}
"""What the first line of another table than a log has -> its name."""
ROBOT, SIMULATION = "robot", "simulation"
"""Values of ``origin``; blank is ``robot``. ``colias firmware log`` writes ``simulation``."""
MEASURED = "measured", "frames measured, network simulated"
"""Where the rows of the robot's own network come from, and those of a model that was shown the robot's frames."""
LOG_OF_SIMULATION = "log of a simulated run", "frames from the log of a simulated run"
"""The same of a log that ``colias firmware log`` wrote: nothing of it was measured."""


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
        known = f"one condition of {experiment.name}, as --set experiment.NAME=VALUE has it: {legal}"
        raise UsageError(f"{path}, line {row[LINE]}: {text} must be {known}")
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
