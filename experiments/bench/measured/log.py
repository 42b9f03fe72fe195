"""Read a robot's log: a CSV with a row per frame and model. docs/back-from-the-robot.md documents its columns.

Everything is checked before anything is written. Each refusal is one line with the file and the number of its line.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import polars as pl

from experiments.bench.run.errors import UsageError, short
from experiments.bench.sources.conditions import CONDITION_COLUMNS, Condition
from experiments.bench.sources.experiment import Experiment
from scenes.hints import nearest

Floats = npt.NDArray[np.float64]
TIME = "time_s"
CHANNELS: Mapping[str, str] = {"hs": "hs_spikes", "vs": "vs_spikes", "looming": "looming_spikes", "azimuth": ""}
"""Channel -> its column of spikes; the azimuth has none."""
ANSWERS = tuple(name for pair in CHANNELS.items() for name in pair if name)
POSES = (
    "stimulus_bearing_deg", "stimulus_x_cm", "stimulus_y_cm", "stimulus_heading_deg", "observer_x_cm",
    "observer_y_cm", "observer_heading_deg",
)  # fmt: skip
"""Columns that a tracker over the arena may add; all of them or none."""
INDEX = ("trial", "model", "seed", "origin")
KNOWN = (*INDEX, *CONDITION_COLUMNS, TIME, *ANSWERS, *POSES)
"""All columns, in the order in which a log is written."""
TEXTS = ("model", "origin", "motion", "direction")
WHOLE = ("trial", "seed", *(spikes for spikes in CHANNELS.values() if spikes))
ROBOT, SIMULATION = "robot", "simulation"
"""Values that ``origin`` may have; blank is ``robot``. ``colias firmware log`` writes ``simulation``."""
MOST_SPIKES = 1000
"""Spikes of one frame; a count beyond it is a damaged line."""
RANGES: Mapping[str, tuple[float, float]] = {
    **dict.fromkeys(("trial", "seed", TIME), (0, 2**53)),
    **dict.fromkeys(("hs", "vs", "azimuth"), (-1, 1)),
    **dict.fromkeys(("hs_spikes", "vs_spikes"), (-MOST_SPIKES, MOST_SPIKES)),
    "looming": (0, 1),
    "looming_spikes": (0, MOST_SPIKES),
    **dict.fromkeys(POSES, (-1e4, 1e4)),
}
"""Column -> its least and its largest value."""
SHARED = ("seed", "origin", *CONDITION_COLUMNS)
"""Columns that have one value in all rows of a trial."""
CLEAR_CM = 1.0
"""Distance off the observer's axis from which a tracker surely tells the side."""
UNNAMED = ""
"""The model of a log without a column ``model``."""
LINE = "line"
BLOCK = ("trial", "model")


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
        that runs back, a condition that is not the experiment's, a trial that says two things.
    """
    texts = _texts(path)
    _check_header(path, texts.columns[1:], experiment)
    table = _values(path, texts)
    _check_rows(path, table)
    trials = []
    for (index,), rows in sorted(table.partition_by("trial", as_dict=True, maintain_order=True).items()):
        blocks = rows.partition_by("model", as_dict=True, maintain_order=True)
        first = next(iter(blocks.values()))
        for (model,), block in blocks.items():
            if not block[TIME].equals(first[TIME]):
                problem = f"trial {index}: {model} has other times than the model before it"
                raise UsageError(f"{path}, line {block[LINE][0]}: {problem}")
        answers = {
            str(model): {
                name: block[name].to_numpy()
                for channel, spikes in CHANNELS.items() if channel in block.columns and not block[channel].null_count()
                for name in (channel, spikes) if name
            }
            for (model,), block in blocks.items()
        }  # fmt: skip
        cells = first.row(0, named=True)
        poses = {name: first[name].to_numpy() for name in POSES} if POSES[0] in cells else None
        trials.append(
            LoggedTrial(
                int(index), cells[LINE], _condition(path, cells, experiment), cells.get("seed"),
                cells.get("origin") == SIMULATION, first[TIME].to_numpy(), answers, poses,
            )
        )  # fmt: skip
    return Log(path, tuple(trials), tuple(table["model"].unique(maintain_order=True)))


def _texts(path: Path) -> pl.DataFrame:
    """Read the cells as texts, stripped, a blank one as null, with the number of each row's line."""
    try:
        cells = pl.read_csv(path, infer_schema=False, raise_if_empty=True, glob=False)
    except pl.exceptions.PolarsError as error:
        raise UsageError(f"{path}: is no table with commas between its columns ({short(str(error))})") from None
    cells = cells.rename(str.strip).with_columns(pl.all().str.strip_chars().replace("", None))
    return cells.with_row_index(LINE, 2)


def _check_header(path: Path, names: Sequence[str], experiment: Experiment) -> None:
    conditions = experiment.conditions()
    needed = ["trial", TIME]
    needed += [name for name in CONDITION_COLUMNS if len({getattr(one, name) for one in conditions}) > 1]
    needed += [spikes for channel, spikes in CHANNELS.items() if channel in names and spikes]
    needed += [channel for channel, spikes in CHANNELS.items() if spikes in names]
    needed += POSES if set(POSES) & set(names) else ()
    for name in names:
        if name not in KNOWN:
            near = nearest(name, KNOWN, after="; ")
            raise UsageError(f"{path}, line 1: unknown column {short(name)} ({near}all: {', '.join(KNOWN)})")
    for name in needed:
        if name not in names:
            raise UsageError(f"{path}, line 1: column {name} is missing")


def _values(path: Path, texts: pl.DataFrame) -> pl.DataFrame:
    """Return the cells as numbers, where a column has numbers."""
    kinds = {name: pl.Int64 if name in WHOLE else pl.Float64 for name in texts.columns[1:] if name not in TEXTS}
    for name, kind in kinds.items():
        value, (low, high) = pl.col(name).cast(kind, strict=False), RANGES.get(name, (-math.inf, math.inf))
        legal = value.is_not_null() & value.is_finite() & (value >= low) & (value <= high)
        what = "a whole number" if kind is pl.Int64 else "a number"
        between = f" between {low:g} and {high:g}" if math.isfinite(low) else ""
        _refuse(path, texts, pl.col(name).is_not_null() & ~legal, f"{name} must be {what}{between}, got {{{name}!r}}")
    table = texts.with_columns(pl.col(name).cast(kind) for name, kind in kinds.items())
    for name in ("trial", TIME, *(name for name in ("model", *POSES) if name in table.columns)):
        _refuse(path, table, pl.col(name).is_null(), f"{name} is blank")
    return table if "model" in table.columns else table.with_columns(model=pl.lit(UNNAMED))


def _check_rows(path: Path, table: pl.DataFrame) -> None:
    """Refuse rows that contradict themselves or the other rows of their trial."""
    if "origin" in table.columns:
        odd = pl.col("origin").is_not_null() & ~pl.col("origin").is_in([ROBOT, SIMULATION])
        _refuse(path, table, odd, f"origin must be {ROBOT} or {SIMULATION}, got {{origin!r}}")
    earlier = pl.col(TIME).diff().over(BLOCK) <= 0
    _refuse(path, table, earlier, "time_s={time_s:g} of trial {trial} is not later than the frame before it")
    for name in (name for name in SHARED if name in table.columns):
        other = pl.col(name).ne_missing(pl.col(name).first().over("trial"))
        _refuse(path, table, other, f"{name} is {{{name}}}, but trial {{trial}} began with another value")
    for channel, spikes in CHANNELS.items():
        if channel not in table.columns:
            continue
        blank = pl.col(channel).is_null()
        gaps = blank.ne(blank.first().over(BLOCK))
        _refuse(path, table, gaps, f"{channel} is blank in some frames of trial {{trial}}, and not in others")
        if spikes:
            odd = blank.ne(pl.col(spikes).is_null()) | (pl.col(channel).sign() * pl.col(spikes) < 0)
            _refuse(path, table, odd, f"{spikes} is {{{spikes}}}, and {channel} is {{{channel}}}")
    if POSES[0] in table.columns:
        # In logs of versions up to 0.3 left was positive.
        x, y = (pl.col(f"stimulus_{axis}_cm") - pl.col(f"observer_{axis}_cm") for axis in "xy")
        heading = pl.col("observer_heading_deg").radians()
        right_cm = x * heading.sin() - y * heading.cos()
        mirrored = (right_cm.abs() > CLEAR_CM) & (right_cm * pl.col(POSES[0]).radians().sin() < 0)
        side = "but its poses have the stimulus on the other side; right is positive"
        _refuse(path, table, mirrored, f"{POSES[0]} is {{{POSES[0]}:g}}, {side}")


def _refuse(path: Path, table: pl.DataFrame, wrong: pl.Expr, reason: str) -> None:
    """Raise `UsageError` about the first row that is wrong; ``{NAME}`` in the reason stands for a cell of it."""
    for row in table.filter(wrong).head(1).to_dicts():
        raise UsageError(f"{path}, line {row[LINE]}: {reason.format(**row)}")


def _condition(path: Path, cells: Mapping[str, Any], experiment: Experiment) -> Condition:
    """Find the condition of the experiment that a trial's columns name."""
    given = {name: cells[name] for name in CONDITION_COLUMNS if name in cells}
    fitting = [
        one for one in experiment.conditions() if all(getattr(one, name) == value for name, value in given.items())
    ]
    if len(fitting) == 1:
        return fitting[0]
    text = ", ".join(f"{name}={value}" for name, value in given.items())
    there = "; ".join(one.label() for one in experiment.conditions())
    problem = f"no condition of {experiment.name} has {text} (--set experiment.* changes them): {there}"
    raise UsageError(f"{path}, line {cells[LINE]}: {problem}")
