"""Checks of the tables of a run: every row is held against the plan, and refused by name where it does not belong."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from experiments.bench.store.description import short
from experiments.bench.store.files import UNREPEATABLE, read_parquet
from experiments.bench.store.parameters import Parameters, of_model
from experiments.bench.store.places import regular
from experiments.bench.store.rows import RECORDING

Row = dict[str, Any]
SPIKES = ("hs_spikes", "vs_spikes", "looming_spikes")
STEPS_MAY_LACK = frozenset({"hs", "vs", "looming", "azimuth", *SPIKES})
"""Columns of frames that may be null for a robot in an env, where it sees nothing."""
RRD_BEGINS, RRD_ENDS = b"RRF2", b"RRF2FOOT"
RRD_TAIL = 12
"""Bytes at a recording's end that begin with `RRD_ENDS`."""


class Misfit(ValueError):
    """Something in a run's folder that the run did not write there, or not so."""


@dataclass(frozen=True, slots=True)
class Planned:
    """The planned rows of one trial: equal ``columns``, a row for each of ``models``, in this order."""

    columns: Mapping[str, Any]
    models: tuple[str, ...]
    recorded: bool = False
    """True if it is to be recorded."""


@dataclass(frozen=True, slots=True)
class Contents:
    """The permitted contents of a run's folder.

    Parameters
    ----------
    trials
        The planned trials, by number.
    may_be_null
        Measures that some trials do not have (`experiments.bench.store.rows.optional`). What a trial sets may be
        null wherever the plan says so.
    frames
        Whether their frames are kept.
    parameters
        The parameters that have columns, by key and model.
    """

    trials: Mapping[int, Planned]
    may_be_null: frozenset[str]
    frames: bool = True
    parameters: Parameters = field(default_factory=dict)

    def trial(self, file: str, index: Any) -> Planned:
        """Return what is planned of trial ``index``, of which ``file`` tells; `Misfit` if nothing is."""
        if type(index) is not int:
            raise Misfit(f"{file}: {index!r} is no trial's number")
        if index not in self.trials:
            raise Misfit(f"{file}: trial {index} is not in the plan, which has {len(self.trials)} from 0 up")
        return self.trials[index]


def read_table(path: Path, schema: pa.Schema) -> pa.Table:
    """Return a table as it was written; `Misfit` in one line on a file that is none, or has other columns."""
    try:
        table = read_parquet(path)
    except OSError as error:
        raise Misfit(f"{path.name} cannot be read ({error.strerror or short(error)})") from None
    except Exception as error:  # bytes that are no table can make the library raise anything
        raise Misfit(f"{path.name} cannot be read ({short(error)})") from None
    if table.schema.names != schema.names:
        odd = [name for name in table.schema.names if name not in schema.names]
        odd += [name for name in schema.names if name not in table.schema.names]
        problem = f"column {odd[0]!r} is {'unknown' if odd[0] in table.schema.names else 'missing'}" if odd else "order"
        raise Misfit(f"{path.name} cannot be read (its columns are not those of this run: {problem[:100]})")
    for column in schema:
        there = table.schema.field(column.name).type
        if there != column.type:
            raise Misfit(f"{path.name} cannot be read (column {column.name!r} has {there}, expected {column.type})")
    return table


def checked_rows(table: pa.Table, contents: Contents, codes: frozenset[str], file: str) -> dict[int, tuple[Row, ...]]:
    """Return the rows by trial, in the order of its models; `Misfit` that names the first row that does not belong."""
    rows: dict[int, dict[str, Row]] = {}
    for row in table.to_pylist():
        check_row(row, contents, codes, file)
        model = row["model"]
        if model in rows.setdefault(row["trial"], {}):
            raise Misfit(f"{file}: trial {row['trial']}: two rows of {model}")
        rows[row["trial"]][model] = row
    return {
        trial: tuple(model_rows[model] for model in contents.trials[trial].models if model in model_rows)
        for trial, model_rows in sorted(rows.items())
    }


def check_row(row: Row, contents: Contents, codes: Collection[str], file: str = "trials.parquet") -> None:
    """Hold a row against the plan, when it is written and when it is read.

    Parameters
    ----------
    row
        The row.
    contents
        The plan.
    codes
        What may have computed the row.
    file
        The table, for the message.

    Raises
    ------
    Misfit
        The row is none of this run's: the message names the first thing about it that is not.
    """
    planned = contents.trial(file, row["trial"])
    where, model = f"{file}: trial {row['trial']}", row["model"]
    if model not in planned.models:
        raise Misfit(f"{where}: model {model!r} is not in the plan, which has {', '.join(planned.models)}")
    if row["code"] not in codes:
        raise Misfit(f"{where}: code {row['code']!r} is none that experiment.json lists")
    model_parameters = of_model(contents.parameters, model)
    for name, value in planned.columns.items():
        if row[name] != value:
            raise Misfit(f"{where}: {name} is {row[name]!r}, the plan says {value!r}")
    for name, value in model_parameters.items():
        if row[name] != value:
            raise Misfit(f"{where}: {name} of {model} is {row[name]!r}, the plan says {value!r}")
    for name, value in row.items():
        if name in planned.columns or name in model_parameters or (value is None and name in contents.may_be_null):
            continue
        if value is None or (isinstance(value, float) and not math.isfinite(value)):
            raise Misfit(f"{where}: {name} is {value!r}")
    if row.get("hs_spikes") is not None and row["spikes"] != row["hs_spikes"]:  # of a model of direction HS counts
        raise Misfit(f"{where}: spikes is {row['spikes']!r}, hs_spikes is {row['hs_spikes']}")
    if row["frames"] < 1:
        raise Misfit(f"{where}: frames is {row['frames']}")


def checked_frames(
    table: pa.Table, rows: Mapping[int, Sequence[Row]], contents: Contents, file: str
) -> dict[int, pa.Table]:
    """Return the frames by trial, in the order of its rows, of those trials that have rows.

    Frames are written before rows, so that those of a trial without rows are what a kill leaves: it will run again.
    Raises `Misfit` that names the first trial whose frames are not those of its rows.
    """
    if not contents.frames:
        if table.num_rows:
            raise Misfit(f"{file}: it holds {table.num_rows} frames, this run keeps none")
        return {trial: table for trial in rows}
    for name in ("trial", "model", "frame"):
        if table[name].null_count:
            raise Misfit(f"{file}: a row without {name}")
    trials: npt.NDArray[np.int64] = table["trial"].to_numpy()
    for index in np.unique(trials).tolist():
        contents.trial(file, index)
    if np.any(np.diff(trials) < 0):
        order = np.argsort(trials, kind="stable")
        table, trials = table.take(order), trials[order]
    frames = {}
    for trial, trial_rows in rows.items():
        low, high = np.searchsorted(trials, [trial, trial + 1])
        frames[trial] = _frames_of(table.slice(low, high - low), trial_rows, f"{file}: trial {trial}")
    return frames


def _frames_of(frames: pa.Table, rows: Sequence[Row], where: str) -> pa.Table:
    """Return one trial's frames, a row's after another's, each from 0 up."""
    models = np.asarray(frames["model"].to_pylist(), dtype=object)
    stranger = next((model for model in models.tolist() if model not in {row["model"] for row in rows}), None)
    if stranger is not None:
        raise Misfit(f"{where}: frames of {stranger!r}, which has no row in trials.parquet")
    parts = []
    for row in rows:
        part = frames.filter(pa.array(models == row["model"], pa.bool_()))
        place = f"{where}: {row['model']}"
        if part.num_rows != row["frames"]:
            raise Misfit(f"{place} has {part.num_rows} frames, its row in trials.parquet says {row['frames']}")
        numbers = part["frame"].to_numpy()
        if np.any(np.diff(numbers) < 0):
            part = part.take(np.argsort(numbers, kind="stable"))
        if not np.array_equal(part["frame"].to_numpy(), np.arange(row["frames"])):
            raise Misfit(f"{place}: its frames are not numbered from 0 to {row['frames'] - 1}, each once")
        _check_values(part, row, place)
        parts.append(part)
    return pa.concat_tables(parts)


def _check_values(part: pa.Table, row: Row, where: str) -> None:
    """Raise `Misfit` unless the frames are those which the row was made of."""
    bodily = "x_cm" in part.column_names
    for name in part.column_names:
        if part[name].null_count and not (bodily and name in STEPS_MAY_LACK):
            raise Misfit(f"{where}: a frame without {name}")
    for name, value in row.items():
        end, _, of = name.partition("_")
        if end in ("peak", "trough") and of in part.column_names:
            extreme = float(getattr(part[of].to_numpy(), "max" if end == "peak" else "min")())
            if extreme != value:
                raise Misfit(
                    f"{where}: its frames have a {name} of {extreme!r}, its row in trials.parquet says {value!r}"
                )
    _check_counts(part, row, where)
    if "reward" in row and "reward" in part.column_names:
        total = float(part["reward"].to_numpy().sum())
        if not math.isclose(total, row["reward"], rel_tol=1e-9, abs_tol=1e-9):
            stored = row["reward"]
            raise Misfit(f"{where}: its frames have a reward of {total!r}, its row in trials.parquet says {stored!r}")


def _check_counts(part: pa.Table, row: Row, where: str) -> None:
    """Raise `Misfit` unless the row's spikes are those of its frames: of each channel, and of the one that counts."""
    counts = {name: int(np.abs(part[name].to_numpy()).sum()) for name in SPIKES
              if row.get(name) is not None and name in part.column_names and not part[name].null_count}  # fmt: skip
    for name, count in counts.items():
        if row[name] != count:
            raise Misfit(f"{where}: its frames have {count} {name}, its row in trials.parquet says {row[name]}")
    if counts and row.get("spikes") not in (None, *counts.values()):
        numbers = " or ".join(map(str, counts.values()))
        raise Misfit(f"{where}: its frames have {numbers} spikes, its row in trials.parquet says {row['spikes']}")


def checked_failures(
    listed: Any, rows: Mapping[int, Sequence[Row]], contents: Contents, make: Callable[..., Any]
) -> list[Any]:
    """Return the failures of single models in trials that have rows, made by ``make``; others will run again.

    Raises `Misfit` that names the first that does not belong.
    """
    file = "failures.json"
    if not isinstance(listed, list):
        raise Misfit(f"{file} cannot be read (it holds a {type(listed).__name__}, expected a list)")
    kinds = {"trial": int, "model": str, "condition": str, "seed": int, "attempts": int, "reason": str}
    failures = []
    for item in listed:
        if not isinstance(item, dict) or {name: type(value) for name, value in item.items()} != kinds:
            raise Misfit(f"{file} cannot be read (expected objects of {', '.join(kinds)})")
        trial, model = item["trial"], item["model"]
        planned = contents.trial(file, trial)
        if item["seed"] != planned.columns["seed"]:
            raise Misfit(f"{file}: trial {trial}: seed is {item['seed']}, the plan says {planned.columns['seed']}")
        if model == RECORDING:
            continue  # the trial is done again, as it has no recording
        if model and model not in planned.models:
            raise Misfit(f"{file}: trial {trial}: model {model!r} is not in the plan")
        if not model or trial not in rows:
            continue
        if model in {row["model"] for row in rows[trial]}:
            raise Misfit(f"{file}: trial {trial}: {model} failed, but has a row in trials.parquet")
        failures.append(make(**item))
    return failures


def check_recordings(folder: Path, contents: Contents, name: Callable[[int], str]) -> None:
    """Raise `Misfit` on a recording of a trial that has none in the plan."""
    planned = {name(trial) for trial, trial_plan in contents.trials.items() if trial_plan.recorded}
    for path in sorted(folder.glob("trial-*.rrd")):
        if path.name not in planned:
            raise Misfit(f"recordings/{path.name} is of no trial that this run records")


def is_recording(path: Path) -> bool:
    """Return whether a whole recording is there, as far as its first and last bytes tell."""
    try:
        with regular(path).open("rb") as file:
            begins = file.read(len(RRD_BEGINS))
            file.seek(0, 2)
            file.seek(max(file.tell() - RRD_TAIL, 0))
            return begins == RRD_BEGINS and file.read().startswith(RRD_ENDS)
    except FileNotFoundError:
        return False
    except OSError as error:
        raise Misfit(f"recordings/{path.name} cannot be read ({error.strerror})") from None


def lacking(rows: Mapping[int, Sequence[Row]], failed: Iterable[tuple[int, str]], contents: Contents) -> Iterator[int]:
    """Trials that lack a model's row, where no failure tells why."""
    known = set(failed)
    for trial, trial_rows in rows.items():
        there = {row["model"] for row in trial_rows}
        if any(model not in there and (trial, model) not in known for model in contents.trials[trial].models):
            yield trial


def same_rows(before: Sequence[Mapping[str, Any]], after: Sequence[Mapping[str, Any]]) -> bool:
    """Return whether rows made again have the numbers of those ``before``: the time they took and their code aside."""
    by_model = {row["model"]: {k: v for k, v in row.items() if k not in UNREPEATABLE} for row in after}
    return all(by_model.get(row["model"]) == {k: v for k, v in row.items() if k not in UNREPEATABLE} for row in before)


def planned_trial(spec: Any, models: Iterable[str], recorded: bool, **columns: Any) -> Planned:
    """Return what is planned of a trial; its experiment, repeat and seed, and more ``columns``."""
    shared = {"experiment": spec.experiment, "repeat": spec.repeat, "seed": spec.seed}
    return Planned({**shared, **columns}, tuple(models), recorded)
