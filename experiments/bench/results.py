"""Tables of a run: a row per trial and model, a row per frame and model, whole and atomically written."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import math
import os
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq

from dsnn import ResponseSeries
from experiments.bench import provenance
from experiments.bench.contents import (
    Contents,
    Misfit,
    check_recordings,
    checked_failures,
    checked_frames,
    checked_rows,
    is_recording,
    lacking,
    read_table,
    same_rows,
)
from experiments.bench.declaration import CONDITION_COLUMNS
from experiments.bench.description import (
    codes,
    holds_results,
    read_description,
    reconciled,
    short,
    to_json,
    write_new,
)
from experiments.bench.files import UsageError
from experiments.bench.trial import FrameColumns, TrialResult

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

_TEXT = ("motion", "direction")
TRIAL_SCHEMA = pa.schema(
    {
        "experiment": pa.string(),
        "trial": pa.int64(),
        "repeat": pa.int64(),
        "seed": pa.int64(),
        "model": pa.string(),
        **{name: pa.string() if name in _TEXT else pa.float64() for name in CONDITION_COLUMNS},
        "spikes": pa.int64(),
        **dict.fromkeys(("hs_spikes", "vs_spikes", "looming_spikes"), pa.int64()),
        "firing_rate_hz": pa.float64(),
        "peak_hs": pa.float64(),
        "trough_hs": pa.float64(),
        "peak_vs": pa.float64(),
        "trough_vs": pa.float64(),
        "peak_looming": pa.float64(),
        "achieved_speed_cm_s": pa.float64(),
        "path_error_mm": pa.float64(),
        "closest_cm": pa.float64(),
        "frames": pa.int64(),
        "wall_s": pa.float64(),
        "code": pa.string(),  # of what computed the row: see `experiments.bench.provenance`
    }
)

FRAME_SCHEMA = pa.schema(
    {
        "trial": pa.int64(),
        "model": pa.string(),
        "frame": pa.int64(),
        "sim_time_s": pa.float64(),
        **{
            field.name: pa.int64() if field.name.endswith("spikes") else pa.float64()
            for field in dataclasses.fields(ResponseSeries)
        },
        **{field.name: pa.float64() for field in dataclasses.fields(FrameColumns) if field.name != "sim_time_s"},
    }
)

MOST_LISTED = 10
"""Numbers of trials in a message."""

WRITING_SHARE = 0.05
"""Of a run's time, what rewriting the tables may take: they are brought up to date as often as this allows."""


@dataclass(frozen=True, slots=True)
class Finished:
    """What a worker hands back of a trial: rows ready for the tables, and the recording's bytes."""

    index: int
    rows: tuple[dict[str, Any], ...]
    frames: pa.Table
    recording: bytes | None
    failures: tuple[Failure, ...] = ()
    """Those of single models, which the others' answers outlive."""


@dataclass(frozen=True, slots=True)
class Failure:
    """A trial that could not be finished, or a ``model`` that broke in one that otherwise was, and why."""

    trial: int
    model: str
    """Empty for a whole trial."""
    condition: str
    seed: int
    attempts: int
    reason: str

    def __str__(self) -> str:
        what = f"{self.model} failed in trial {self.trial}" if self.model else f"trial {self.trial} failed"
        times = f" after {self.attempts} attempts" if self.attempts > 1 else ""
        return f"{what}{times} ({self.condition}): {self.reason}"


def recording_name(index: int) -> str:
    """File name of the recording of trial ``index``."""
    return f"trial-{index:04d}.rrd"


def finished(result: TrialResult, recording: bytes | None, *, frames: bool = True) -> Finished:
    """A trial's result as table rows, one per model, and frame rows if wanted."""
    table = _frame_table(result) if frames else FRAME_SCHEMA.empty_table()
    spec = result.spec
    broken = tuple(
        Failure(spec.index, label, spec.condition.label(), spec.seed, 1, reason)
        for label, reason in result.broken.items()
    )
    return Finished(spec.index, tuple(_rows(result)), table, recording, broken)


def _rows(result: TrialResult) -> Iterable[dict[str, Any]]:
    spec = result.spec
    shared = {
        "experiment": spec.experiment,
        "trial": spec.index,
        "repeat": spec.repeat,
        "seed": spec.seed,
        **dataclasses.asdict(spec.condition),
    }
    for answer in result.answers:
        values = {name: getattr(answer, name, None) for name in TRIAL_SCHEMA.names}
        yield {
            name: shared[name] if name in shared else getattr(result, name) if hasattr(result, name) else values[name]
            for name in TRIAL_SCHEMA.names
        }


def _frame_table(result: TrialResult) -> pa.Table:
    columns = {field.name: getattr(result.columns, field.name) for field in dataclasses.fields(FrameColumns)}
    tables = []
    for answer in result.answers:
        own = {field.name: getattr(answer.series, field.name) for field in dataclasses.fields(ResponseSeries)}
        index = {
            "trial": [result.spec.index] * result.frames,
            "model": [answer.model] * result.frames,
            "frame": range(result.frames),
        }
        tables.append(pa.table({**index, **columns, **own}).select(FRAME_SCHEMA.names).cast(FRAME_SCHEMA))
    return pa.concat_tables(tables)


class RunFolder:
    """The files of one run. Every file is complete at every moment: written beside its place, then renamed into it.

    Raises ``OSError`` when the folder cannot be written.
    """

    def __init__(
        self, folder: Path, trial_schema: pa.Schema = TRIAL_SCHEMA, frame_schema: pa.Schema = FRAME_SCHEMA
    ) -> None:
        self.folder = folder
        self._trial_schema, self._frame_schema = trial_schema, frame_schema
        self.recordings = folder / "recordings"
        self._rows: dict[int, tuple[dict[str, Any], ...]] = {}
        self._frames: dict[int, pa.Table] = {}
        self._failures: list[Failure] = []
        self._before: dict[int, tuple[dict[str, Any], ...]] = {}
        self._again: set[int] = set()
        self._changed: list[int] = []
        self._code = ""
        self.provenance: Mapping[str, Any] = {}
        """What computes, as the folder was entered with it."""
        self._lock: IO[str] | None = None
        self._due = 0.0
        self._stale = False

    def enter(self, description: Mapping[str, Any], begun: bool, contents: Contents, other_code: bool = False) -> None:
        """`reopen` a run that was ``begun``, otherwise `create` one; ``contents`` is what it may hold."""
        if begun:
            self.reopen(description, contents, other_code)
        else:
            self.create(description)

    def create(self, description: Mapping[str, Any]) -> None:
        """Make the folder with its ``experiment.json``.

        Raises ``FileExistsError`` if it holds a run already, which is never overwritten; of two runs that begin
        at once, one gets it.
        """
        self.recordings.mkdir(parents=True, exist_ok=True)
        self._take()
        try:
            if holds_results(self.folder):
                raise FileExistsError
            write_new(self.folder, description)
        except FileExistsError:
            self.close()
            raise FileExistsError(
                f"{self.folder} already holds a run: choose another --out, remove it, or go on with it by --resume"
            ) from None
        except BaseException:
            self.close()
            raise
        self._made_by(description)

    def reopen(self, description: Mapping[str, Any], contents: Contents, other_code: bool = False) -> None:
        """Go on with the run that the folder holds.

        Raises `UsageError` if it holds none, one with other parameters or of other code (which ``other_code``
        allows), naming the first that differs, or one whose files do not fit ``contents``, naming what does not.
        """
        read_description(self.folder)  # before anything is written where there may be no run
        self._take()
        try:
            there = reconciled(self.folder, description, other_code)
            self.recordings.mkdir(exist_ok=True)
            self._read(contents, codes(there))
        except Misfit as error:
            self.close()
            raise UsageError(f"{self.folder}: {error}") from None
        except BaseException:
            self.close()
            raise
        self._made_by(description)
        if there != read_description(self.folder):
            self.write_json("experiment.json", there)
        if not self._before.keys() <= self._rows.keys():
            self._write_rows()  # before the frames: whenever this is cut short, a trial that has its row has its frames

    def _made_by(self, description: Mapping[str, Any]) -> None:
        self.provenance = {key: description[key] for key in provenance.KEYS if key in description}
        self._code = str(description.get("code", ""))

    def _read(self, contents: Contents, codes: frozenset[str]) -> None:
        """Take in what is there and belongs there; trials of which a part is gone are to be done again.

        What those have left stays until then, but for trials that lack the row of a model.
        """
        check_recordings(self.recordings, contents, recording_name)
        if not os.path.lexists(self.path("trials.parquet")):
            return
        table = read_table(self.path("trials.parquet"), self._trial_schema)
        rows = checked_rows(table, contents, codes)
        listed = self._listed_failures()
        failures = checked_failures(listed, rows, contents, Failure)
        gone = {t for t in rows if contents.trials[t].recorded and not is_recording(self.recording(t))}
        partly = set(lacking(rows, [(f.trial, f.model) for f in failures], contents))
        self._again = gone | partly
        self._before = {trial: rows[trial] for trial in self._again}
        self._rows = {trial: own for trial, own in rows.items() if trial not in partly}
        self._failures = [failure for failure in failures if failure.trial not in partly]
        frames = read_table(self.path("frames.parquet"), self._frame_schema)
        self._frames = checked_frames(frames, self._rows, contents)
        # Rows in another order, or frames of trials without rows, which a kill leaves, are put right.
        self._stale = self.rows() != table.to_pylist() or not self.frames().equals(frames)
        self._stale |= len(listed) != len(self._failures)

    def _listed_failures(self) -> Any:
        path = self.path("failures.json")
        try:
            return json.loads(path.read_text(encoding="utf-8")) if os.path.lexists(path) else []
        except (OSError, ValueError, RecursionError) as error:
            raise Misfit(f"failures.json cannot be read ({short(error)})") from None

    def _take(self) -> None:
        """Keep other processes from writing here as long as this one does."""
        if fcntl is None:
            return
        lock = self.path(".lock").open("w", encoding="utf-8")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.close()
            raise UsageError(f"{self.folder}: another process is writing its run there") from None
        except OSError:  # a file system without locks
            lock.close()
            return
        self._lock = lock

    def close(self) -> None:
        """Let other processes write here."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def path(self, name: str) -> Path:
        """Path of a file in the folder."""
        return self.folder / name

    def done(self) -> frozenset[int]:
        """The trials that are finished."""
        return frozenset(self._rows.keys() - self._again)

    def recording(self, trial: int) -> Path:
        """Path of a trial's recording."""
        return self.recordings / recording_name(trial)

    def add(self, trial: Finished) -> None:
        """Append a finished trial: its recording, then the tables as soon as they may take the time."""
        if trial.recording is not None:
            self._replace(self.recording(trial.index), trial.recording)
        rows = tuple({**row, "code": self._code} for row in trial.rows)
        if trial.index in self._again:
            self._make_room(trial.index, rows)
        self._rows[trial.index] = rows
        self._frames[trial.index] = trial.frames
        self._failures += trial.failures
        self._stale = True
        if time.monotonic() >= self._due:
            self.flush()

    def _make_room(self, trial: int, rows: Sequence[Mapping[str, Any]]) -> None:
        """Forget what is there of a trial that was done again."""
        self._again.remove(trial)
        self._failures = [failure for failure in self._failures if failure.trial != trial]
        if not same_rows(self._before[trial], rows):
            self._changed.append(trial)
            if self._rows.pop(trial, None):
                self._write_rows()  # at no moment are its new frames there with its old row

    def fail(self, failure: Failure) -> None:
        """Note a trial that could not be finished."""
        self._failures.append(failure)
        self._stale = True

    def failures(self) -> list[Failure]:
        """What failed so far, in order of trial."""
        return sorted(self._failures, key=lambda failure: (failure.trial, failure.model))

    def flush(self) -> None:
        """Bring the tables up to date, and the list of failures."""
        if not self._stale:
            return
        began = time.monotonic()
        # Rows last: whenever this is cut short, a trial that has its row has its frames, and its models' failures.
        self._write_table("frames.parquet", self.frames())
        if self._failures or self.path("failures.json").exists():
            self.write_json("failures.json", self.failures())
        self._write_rows()
        self._stale = False
        ended = time.monotonic()
        self._due = ended + (ended - began) / WRITING_SHARE

    def rows(self) -> list[dict[str, Any]]:
        """The rows so far, in order of trial, then model."""
        return [row for trial in sorted(self._rows) for row in self._rows[trial]]

    def notes(self) -> list[str]:
        """What is to be known of the tables beside their numbers, a line each."""
        said = []
        if self._before:
            lost = "a part of what they left was gone"
            said.append(f"{self.folder}: done again, since {lost}: {_listed(self._before)}")
        if self._changed:
            said.append(f"{self.folder}: done again with other numbers than before: {_listed(self._changed)}")
        mixed = mixture(self.rows())
        return [*said, *([f"{self.folder}: {mixed}; experiment.json tells them apart"] if mixed else [])]

    def frames(self) -> pa.Table:
        """The per-frame table so far, in the same order."""
        tables = [self._frames[trial] for trial in sorted(self._frames)]
        return pa.concat_tables(tables) if tables else self._frame_schema.empty_table()

    def write_text(self, name: str, text: str) -> None:
        """Write a text file atomically."""
        self._replace(self.path(name), text.encode())

    def write_json(self, name: str, value: Any) -> None:
        """Write a JSON file atomically, indented for reading."""
        self.write_text(name, to_json(value))

    def write_rows(self, name: str, rows: Sequence[Mapping[str, Any]]) -> None:
        """Write rows as CSV atomically."""
        with self._replacing(self.path(name)) as partial:
            pa.csv.write_csv(pa.Table.from_pylist(list(rows)), partial)

    def _write_rows(self) -> None:
        self._write_table("trials.parquet", pa.Table.from_pylist(self.rows(), self._trial_schema))

    def _write_table(self, name: str, table: pa.Table) -> None:
        with self._replacing(self.path(name)) as partial:
            pq.write_table(table, partial)

    def _replace(self, path: Path, data: bytes) -> None:
        with self._replacing(path) as partial:
            partial.write_bytes(data)

    @contextlib.contextmanager
    def _replacing(self, path: Path) -> Iterator[Path]:
        """A file to write beside ``path``, which it then replaces, whole and on the disk, or not at all."""
        partial = path.with_name(path.name + ".part")
        try:
            yield partial
            with partial.open("rb") as file:
                os.fsync(file.fileno())
        except OSError:
            partial.unlink(missing_ok=True)
            raise
        partial.replace(path)


def read_trials(folder: Path) -> list[dict[str, Any]]:
    """The rows of a run's ``trials.parquet``; ``FileNotFoundError`` where there is none."""
    rows: list[dict[str, Any]] = pq.read_table(folder / "trials.parquet").to_pylist()
    return rows


def group(rows: Iterable[Mapping[str, Any]], *keys: str) -> dict[tuple[Any, ...], list[Mapping[str, Any]]]:
    """Rows by the values of ``keys``, groups in order of first appearance."""
    groups: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def varying(rows: Sequence[Mapping[str, Any]], varies: str) -> list[str]:
    """``varies``, and the other columns that tell the conditions apart, model included."""
    implied = {"motion": {"angle_deg", "distance_cm", "far_cm", "acceleration_cm_s2"}, "angle_deg": {"direction"}}
    others = [
        name
        for name in ("model", *CONDITION_COLUMNS)
        if name != varies and name not in implied.get(varies, ()) and len({row[name] for row in rows}) > 1
    ]
    return [*(["model"] if "model" in others else []), varies, *(name for name in others if name != "model")]


def known(value: float) -> float | None:
    """The value for a table: empty instead of NaN."""
    return None if math.isnan(value) else value


def mixture(rows: Iterable[Mapping[str, Any]]) -> str:
    """In words, of how many trials each code computed the rows, if more than one did; otherwise empty."""
    trials: dict[str, set[int]] = {}
    for row in rows:
        if "code" in row:
            trials.setdefault(row["code"], set()).add(row["trial"])
    if len(trials) < 2:
        return ""
    return f"rows of {len(trials)} codes ({', '.join(f'{code}: {len(own)} trials' for code, own in trials.items())})"


def _listed(trials: Iterable[int]) -> str:
    numbers = sorted(trials)
    more = f" and {len(numbers) - MOST_LISTED} more" if len(numbers) > MOST_LISTED else ""
    return f"trials {', '.join(map(str, numbers[:MOST_LISTED]))}{more}"
