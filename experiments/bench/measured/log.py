"""Read a robot's log: a CSV with a row per frame and model, checked line by line.

Everything is checked before anything is written. Each refusal is one line with the file and the number of its line.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from experiments.bench.measured.columns import CHANNELS, KNOWN, POSES, SIMULATION, TIME, parse
from experiments.bench.run.errors import UsageError, short
from experiments.bench.sources.conditions import CONDITION_COLUMNS, Condition
from experiments.bench.sources.experiment import Experiment
from scenes.hints import nearest

Floats = npt.NDArray[np.float64]
Cells = Mapping[str, Any]
SEPARATORS = {";": "';'", "\t": "a tab", "|": "'|'"}
"""Signs that other programs put between the columns of a table, in words."""
SHARED = ("seed", "origin", *CONDITION_COLUMNS)
"""Columns that have one value in all rows of a trial."""
CLEAR_CM = 1.0
"""Distance off the observer's axis from which a tracker surely tells the side."""
UNNAMED = ""
"""The model of a log without a column ``model``."""


@dataclass(frozen=True, slots=True)
class LoggedTrial:
    """One trial of a log.

    Parameters
    ----------
    index
        Its number in the log.
    line
        The line of its first frame, in the file.
    condition
        The condition of the experiment that it shows.
    seed
        Of its random draws, where the log tells one.
    simulated
        Whether the log says that its trials were simulated.
    time_s
        Of each frame, (T,), rising.
    answers
        Model -> column (``hs``, ``hs_spikes``, ...) -> its values, (T,). A model has the channels that the log has of
        it; without any, the log is one of a camera alone.
    poses
        Column -> its values, (T,), from a tracker; ``None`` without one.
    """

    index: int
    line: int
    condition: Condition
    seed: int | None
    simulated: bool
    time_s: Floats
    answers: Mapping[str, Mapping[str, npt.NDArray[Any]]]
    poses: Mapping[str, Floats] | None


@dataclass(frozen=True, slots=True)
class Log:
    """A log: its file, its trials in their order, and the models that answered, in order of first appearance."""

    path: Path
    trials: tuple[LoggedTrial, ...]
    models: tuple[str, ...]

    @property
    def answered(self) -> bool:
        """Tell whether the robot's own network answered; otherwise the log is of a camera alone."""
        return any(channels for trial in self.trials for channels in trial.answers.values())


class _Reader:
    """The lines of a file, and where it stands in them."""

    def __init__(self, path: Path, experiment: Experiment) -> None:
        self.path, self.experiment = path, experiment
        self.line = 1

    def refuse(self, reason: str, line: int | None = None) -> NoReturn:
        """Raise `UsageError` about a line, by default the present one."""
        raise UsageError(f"{self.path}, line {line or self.line}: {reason}") from None

    def rows(self) -> Iterator[Cells]:
        """Yield each row's cells by column, checked one by one."""
        try:
            with self.path.open(newline="", encoding="utf-8-sig") as file:
                lines = csv.reader(file, strict=True)
                names = next(lines, None)
                if names == []:
                    self.refuse("the line is blank: expected the names of the columns")
                header = [name.strip() for name in names or ()]
                self._check_header(header)
                for cells in lines:
                    self.line = lines.line_num
                    if not cells:
                        continue
                    if len(cells) != len(header):
                        self.refuse(f"{len(cells)} cells, the header has {len(header)} columns")
                    try:
                        yield {name: parse(name, cell) for name, cell in zip(header, cells, strict=True)}
                    except ValueError as error:
                        self.refuse(str(error))
        except OSError as error:
            raise UsageError(f"{self.path}: cannot be read ({error.strerror})") from None
        except (UnicodeDecodeError, csv.Error) as error:
            self.refuse(f"no CSV in UTF-8 ({error})")

    def _check_header(self, header: Sequence[str]) -> None:
        if not header:
            self.refuse("the file is empty: expected a line with the names of the columns")
        other = next((mark for mark in SEPARATORS if mark in header[0]), None) if len(header) == 1 else None
        if other is not None:
            reason = f"the columns are separated by {SEPARATORS[other]}"
            self.refuse(f"{reason}: legal are commas between them, and points in numbers")
        for name in header:
            if name not in KNOWN:
                near = nearest(name, KNOWN, after="; ")
                self.refuse(f"unknown column {short(name)} ({near}all: {', '.join(KNOWN)})")
            if header.count(name) > 1:
                self.refuse(f"column {name!r} is there twice")
        needed = ["trial", TIME, *telling(self.experiment.conditions())]
        needed += [spikes for channel, spikes in CHANNELS.items() if channel in header and spikes]
        needed += [channel for channel, spikes in CHANNELS.items() if spikes in header]
        needed += POSES if set(POSES) & set(header) else ()
        for name in needed:
            if name not in header:
                self.refuse(f"column {name!r} is missing{self._why(name)}")

    def _why(self, name: str) -> str:
        if name in CONDITION_COLUMNS:
            return f": it tells the conditions of {self.experiment.name} apart"
        if name in POSES:
            return f": a tracker gives all of {', '.join(POSES)}, or none"
        other = next((c if name == s else s for c, s in CHANNELS.items() if name in (c, s)), "")
        return f": {other} needs it" if other else ""


def telling(conditions: Sequence[Condition]) -> list[str]:
    """Return the columns in which conditions differ: without them a log does not say what a trial showed."""
    return [name for name in CONDITION_COLUMNS if len({getattr(condition, name) for condition in conditions}) > 1]


def read(path: Path, experiment: Experiment) -> Log:
    """Read and check a log.

    Parameters
    ----------
    path
        The CSV file.
    experiment
        Whose conditions its trials show.

    Returns
    -------
    Log
        Its trials.

    Raises
    ------
    UsageError
        In one line with file and line number: an unknown or missing column, a cell that is no legal value, a time
        that runs back, a condition that is not the experiment's, a trial that is there twice or says two things.
    """
    reader = _Reader(path, experiment)
    blocks: dict[tuple[int, str], list[tuple[int, Cells]]] = {}
    before: tuple[int, str] | None = None
    for cells in reader.rows():
        key = (_given(reader, cells, "trial"), cells.get("model", UNNAMED))
        if key[1] is None:
            reader.refuse("model is blank")
        if key != before and key in blocks:
            of = f" of {key[1]}" if key[1] else ""
            reader.refuse(f"trial {key[0]}{of} is there twice: it began in line {blocks[key][0][0]} and ended before")
        _check_row(reader, cells, blocks.get(key, ()))
        blocks.setdefault(key, []).append((reader.line, cells))
        before = key
    if not blocks:
        reader.refuse("no frame of any trial")
    trials: dict[int, dict[str, list[tuple[int, Cells]]]] = {}
    for (trial, model), lines in blocks.items():
        trials.setdefault(trial, {})[model] = lines
    trials_read = tuple(_trial(reader, index, lines) for index, lines in sorted(trials.items()))
    return Log(path, trials_read, tuple(dict.fromkeys(model for _, model in blocks)))


def _given(reader: _Reader, cells: Cells, name: str) -> Any:
    if cells[name] is None:
        reader.refuse(f"{name} is blank")
    return cells[name]


def _check_row(reader: _Reader, cells: Cells, lines: Sequence[tuple[int, Cells]]) -> None:
    """Refuse a row that does not go on with the rows of its block."""
    time_s = _given(reader, cells, TIME)
    for name in POSES:
        if name in cells:
            _given(reader, cells, name)
    if POSES[0] in cells:
        _check_bearing(reader, cells)
    for channel, spikes in CHANNELS.items():
        if spikes and channel in cells and (cells[channel] is None) != (cells[spikes] is None):
            reader.refuse(f"{channel if cells[channel] is None else spikes} is blank, but not its partner")
        if spikes and cells.get(channel) and cells[channel] * cells[spikes] < 0:
            reason = f"{spikes}={cells[spikes]}, but {channel}={cells[channel]:g}"
            reader.refuse(f"{reason}: legal are spikes with the potential's sign")
    if not lines:
        return
    first_line, first = lines[0]
    if time_s <= lines[-1][1][TIME]:
        reader.refuse(
            f"time_s={time_s:g} runs back: line {lines[-1][0]} of trial {cells['trial']} has {lines[-1][1][TIME]:g} "
            "(times rise; a trial that is there twice needs another number)"
        )
    for name in SHARED:
        if cells.get(name) != first.get(name):
            there = f"trial {cells['trial']} began in line {first_line} with {first[name]}"
            reader.refuse(f"{name}={cells[name]}: {there}")
    for name in CHANNELS:
        if name in cells and (cells[name] is None) != (first[name] is None):
            reader.refuse(f"{name} is blank in some frames of trial {cells['trial']}, and not in others")


def _check_bearing(reader: _Reader, cells: Cells) -> None:
    """Refuse a bearing of the other side than the poses say: in logs of versions up to 0.3 left was positive."""
    bearing, (x, y) = cells[POSES[0]], (cells[f"stimulus_{axis}_cm"] - cells[f"observer_{axis}_cm"] for axis in "xy")
    heading = math.radians(cells["observer_heading_deg"])
    right_cm = x * math.sin(heading) - y * math.cos(heading)
    if abs(right_cm) > CLEAR_CM and right_cm * math.sin(math.radians(bearing)) < 0.0:
        side = "right" if right_cm > 0.0 else "left"
        reader.refuse(f"{POSES[0]} is {bearing:g}, but its poses have the stimulus on the {side}; right is positive")


def _trial(reader: _Reader, index: int, blocks: Mapping[str, Sequence[tuple[int, Cells]]]) -> LoggedTrial:
    """Put one trial together from the blocks of its models."""
    first = next(iter(blocks.values()))
    line, cells = first[0]
    times = np.array([lines[TIME] for _, lines in first], np.float64)
    answers = {}
    for model, lines in blocks.items():
        begins, first_cells = lines[0]
        if [row[TIME] for _, row in lines] != times.tolist():
            reader.refuse(f"trial {index}: {model} has other times than the model before it", begins)
        differs = [name for name in SHARED if first_cells.get(name) != cells.get(name)]
        if differs:
            reader.refuse(
                f"trial {index}: {differs[0]}={first_cells[differs[0]]}, line {line} has {cells[differs[0]]}", begins
            )
        answers[model] = {
            name: np.array([row[name] for _, row in lines], np.int64 if name in CHANNELS.values() else np.float64)
            for channel, spikes in CHANNELS.items()
            if first_cells.get(channel) is not None
            for name in (channel, spikes)
            if name
        }
    poses = (
        {name: np.array([row[name] for _, row in first], np.float64) for name in POSES} if POSES[0] in cells else None
    )
    simulated = cells.get("origin") == SIMULATION
    return LoggedTrial(
        index, line, _condition(reader, cells, line), cells.get("seed"), simulated, times, answers, poses
    )


def _condition(reader: _Reader, cells: Cells, line: int) -> Condition:
    """Find the condition of the experiment that a trial's columns name."""
    conditions, name = reader.experiment.conditions(), reader.experiment.name
    given = [column for column in CONDITION_COLUMNS if column in cells]
    fitting = [
        condition for condition in conditions if all(getattr(condition, column) == cells[column] for column in given)
    ]
    if len(fitting) == 1:
        return fitting[0]
    for column in given:
        levels = list(dict.fromkeys(getattr(condition, column) for condition in conditions))
        if cells[column] not in levels:
            text = ", ".join("blank" if level is None else f"{level:g}" if isinstance(level, float) else level
                              for level in levels)  # fmt: skip
            value = "blank" if cells[column] is None else cells[column]
            reader.refuse(
                f"{column}={value}: no condition of {name} (it has {text}; --set experiment.* changes it)", line
            )
    text = ", ".join(f"{column}={cells[column]}" for column in given)
    reader.refuse(f"no condition of {name} has {text} together", line)
