"""The folder of a run that is being written: its description, tables, failures and recordings."""

from __future__ import annotations

import errno
import json
import os
import shutil
import time
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
from filelock import FileLock, Timeout

from experiments.bench.engine.errors import UsageError
from experiments.bench.store import provenance
from experiments.bench.store.contents import (
    SPIKES,
    Contents,
    Misfit,
    check_recordings,
    check_row,
    checked_failures,
    checked_frames,
    checked_rows,
    is_recording,
    lacking,
    read_table,
    same_rows,
)
from experiments.bench.store.description import (
    ENDED,
    PIXELS,
    RENDERERS,
    begun,
    codes,
    command_note,
    holds_results,
    noted,
    now,
    read_description,
    reconciled,
    short,
    write_new,
)
from experiments.bench.store.description import NAME as DESCRIPTION
from experiments.bench.store.files import Files
from experiments.bench.store.parameters import Parameters, of_model, with_columns
from experiments.bench.store.places import inside, regular, told
from experiments.bench.store.rows import (
    RECORDING,
    Failure,
    TrialRecord,
    listed_trials,
    mixture,
    recording_name,
)
from experiments.bench.store.tables import PARTS, TABLES, file_name, remove_parts, sources

RECORDINGS, LOCK = "recordings", ".lock"

WITHOUT_LOCKS = frozenset({errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOTSUP, errno.EINVAL})
"""What a file system says that has no locks: runs do without there."""

FOR_TABLES_BYTES = 2 * 2**20
"""What recordings leave free on a disk, beside room for the table of frames anew: rows outlive recordings."""

PART_S, PART_SHARE = 1.0, 0.02
"""A part of the tables is written as soon as this time has passed since the last, or this share of the run so far, if
that is longer: so much may a kill lose, and an hour's run has some 200 parts."""


class RunFolder(Files):
    """The files of one run: its description, tables, failures and recordings.

    Parameters
    ----------
    folder
        Where they are. It is made if need be.
    trial_schema, frame_schema
        Of ``trials.parquet`` and ``frames.parquet``.
    parameters
        Those that have columns of their own in ``trials.parquet``, by key and model.

    Raises
    ------
    OSError
        The folder cannot be written.
    """

    def __init__(
        self, folder: Path, trial_schema: pa.Schema, frame_schema: pa.Schema, parameters: Parameters | None = None
    ) -> None:
        super().__init__(folder)
        self._parameters = parameters or {}
        self._contents: Contents | None = None
        self._trial_schema, self._frame_schema = with_columns(trial_schema, self._parameters), frame_schema
        self.recordings = folder / RECORDINGS
        self._rows: dict[int, tuple[dict[str, Any], ...]] = {}
        self._frames: dict[int, pa.Table] = {}
        self._failures: list[Failure] = []
        self._before: dict[int, tuple[dict[str, Any], ...]] = {}
        self._again: set[int] = set()
        self._changed: list[int] = []
        self._code = ""
        self._noted: dict[str, list[str]] = {RENDERERS: [], PIXELS: []}
        self.provenance: Mapping[str, Any] = {}
        """What computes, as the folder was entered with it."""
        self._lock: FileLock | None = None
        self._pending: list[int] = []
        self._next_part = 0
        self._frames_bytes = 0
        self._began = time.monotonic()
        self._due = 0.0
        self._joined = True

    def enter(self, description: Mapping[str, Any], contents: Contents, other_code: bool = False) -> None:
        """Go on with the run that the folder holds, or `create` one; ``contents`` is what it may hold.

        Raises ``FileExistsError`` where there are tables without a description, and `UsageError` as `reopen` does.
        """
        self._contents = contents
        if begun(self.folder):
            self.reopen(description, contents, other_code)
        else:
            self.create(description)

    def create(self, description: Mapping[str, Any]) -> None:
        """Make the folder with its ``experiment.json``.

        Raises ``FileExistsError`` if it holds a run already, which is never overwritten; of two runs that begin
        at once, one gets it.
        """
        self._check_links()
        self.recordings.mkdir(parents=True, exist_ok=True)
        self._take()
        try:
            if holds_results(self.folder):
                raise FileExistsError
            write_new(self.folder, description)
        except FileExistsError:
            self.close()
            raise FileExistsError(
                f"{self.folder} already holds a run, which was begun just now or whose {DESCRIPTION} is gone:"
                " choose another --out, or remove it"
            ) from None
        except BaseException:
            self.close()
            raise
        self._made_by(description)

    def reopen(self, description: Mapping[str, Any], contents: Contents, other_code: bool) -> None:
        """Go on with the run that the folder holds.

        Raises `UsageError` if it holds none, one with other parameters or of other code (which ``other_code``
        allows), naming the first that differs, or one whose files do not fit ``contents``, naming what does not.
        """
        reconciled(self.folder, description, other_code)  # before anything is written where there may be another run
        self._check_links()
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
        self._noted = {entry: noted(there, entry) for entry in self._noted}
        if there != read_description(self.folder):
            self.write_json("experiment.json", there)

    def _made_by(self, description: Mapping[str, Any]) -> None:
        self.provenance = {key: description[key] for key in (*provenance.KEYS, "form") if key in description}
        self._code = str(description.get("code", ""))

    def _read(self, contents: Contents, codes: frozenset[str]) -> None:
        """Take in what is there and belongs there; trials of which a part is gone are to be done again.

        What those have left stays until then, but for trials that lack the row of a model.
        """
        check_recordings(self.recordings, contents, recording_name)
        tables: dict[int | None, pa.Table] = {
            part: read_table(self.path(file_name("trials", part)), self._trial_schema) for part in sources(self.folder)
        }
        rows: dict[int | None, dict[int, tuple[dict[str, Any], ...]]] = {}
        for part, table in tables.items():  # of a trial the newest part counts
            checked = checked_rows(table, contents, codes, file_name("trials", part))
            rows[part] = {trial: trial_rows for trial, trial_rows in checked.items() if trial not in self._rows}
            self._rows |= rows[part]
        listed = self._listed_failures() if tables else []
        failures: list[Failure] = checked_failures(listed, self._rows, contents, Failure)
        gone = {t for t in self._rows if contents.trials[t].recorded and not is_recording(self.recording(t))}
        partly = set(lacking(self._rows, [(f.trial, f.model) for f in failures], contents))
        self._again = gone | partly
        self._before = {trial: self._rows[trial] for trial in sorted(self._again)}
        self._rows = {trial: trial_rows for trial, trial_rows in self._rows.items() if trial not in partly}
        self._failures = [failure for failure in failures if failure.trial not in partly]
        for part, new in rows.items():
            name = file_name("frames", part)
            frames = read_table(self.path(name), self._frame_schema)
            kept = {trial: trial_rows for trial, trial_rows in new.items() if trial not in partly}
            self._frames |= checked_frames(frames, kept, contents, name)
            self._frames_bytes += self.path(name).stat().st_size
            # Rows in another order, or frames of trials without rows, are put right when the tables are joined.
            self._joined &= part is None and self.frames().equals(frames)
        self._joined &= len(listed) == len(self._failures) and not self.path(PARTS).exists()
        self._joined &= self.rows() == [row for table in tables.values() for row in table.to_pylist()]
        self._next_part = max((part for part in tables if part is not None), default=-1) + 1

    def _listed_failures(self) -> Any:
        path = self.path("failures.json")
        try:
            return json.loads(regular(path).read_text(encoding="utf-8")) if os.path.lexists(path) else []
        except (OSError, ValueError, RecursionError) as error:
            raise Misfit(f"failures.json cannot be read ({short(error)})") from None

    def _check_links(self) -> None:
        """Raise `UsageError` where what is written into, and not replaced as files are, is a link."""
        for name in (RECORDINGS, PARTS, LOCK):
            inside(self.folder, name)

    def _take(self) -> None:
        """Keep other processes from writing here as long as this one does."""
        lock = FileLock(self.path(LOCK), timeout=0)
        try:
            lock.acquire()
        except Timeout:
            raise UsageError(f"{self.folder}: another process is writing its run there") from None
        except (OSError, NotImplementedError) as error:
            if isinstance(error, OSError) and error.errno not in WITHOUT_LOCKS:
                raise
            return
        self._lock = lock

    def close(self) -> None:
        """Let other processes write here."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def done(self) -> frozenset[int]:
        """Return the trials that are finished."""
        return frozenset(self._rows.keys() - self._again)

    def written(self) -> frozenset[int]:
        """Return the finished trials that are on the disk: fewer than are done where that is full."""
        return self.done() - {*self._pending}

    def recording(self, trial: int) -> Path:
        """Path of a trial's recording."""
        return self.recordings / recording_name(trial)

    def add(self, trial: TrialRecord, condition: str, seed: int) -> None:
        """Append a finished trial: its recording, then its rows and frames, in a part with others that end meanwhile.

        A recording that could not be made or written is a failure of its own, which names ``condition`` and ``seed``.

        Raises
        ------
        Misfit
            A row is none that `reopen` would take; nothing of the trial is kept.
        """
        rows = tuple(
            {**row, "code": self._code, **of_model(self._parameters, row.get("model", ""))} for row in trial.rows
        )
        self._check(trial.index, rows)
        reason = self._record(trial)
        self._note(trial)
        if trial.index in self._again:
            self._again.remove(trial.index)
            self._failures = [failure for failure in self._failures if failure.trial != trial.index]
            if not same_rows(self._before[trial.index], rows):
                self._changed.append(trial.index)
        self._rows[trial.index] = rows
        self._frames[trial.index] = trial.frames
        self._failures += trial.failures
        if reason:
            self._failures.append(Failure(trial.index, RECORDING, condition, seed, 1, reason))
        self._pending.append(trial.index)
        if time.monotonic() >= self._due:
            self._write_part()

    def _record(self, trial: TrialRecord) -> str:
        """Write a trial's recording where there is one; return why there is none where there should be."""
        if not isinstance(trial.recording, bytes):
            return trial.recording or ""
        path, kept = self.recording(trial.index), FOR_TABLES_BYTES + 2 * self._frames_bytes
        try:
            free = shutil.disk_usage(self.recordings).free
            if free < len(trial.recording) + kept:
                room = f"{_mb(free)} are free in {self.recordings}, {_mb(kept)} of them for tables"
                return f"{path}: the disk is full ({room}; it needs {_mb(len(trial.recording))})"
            self.write_bytes(path, trial.recording)
        except OSError as error:
            return told(error)
        return ""

    def _check(self, trial: int, rows: Sequence[dict[str, Any]]) -> None:
        """Raise `Misfit` for rows that have other columns than the table, or that `reopen` would refuse."""
        for row in rows:
            if odd := sorted(set(self._trial_schema.names) ^ row.keys()):
                kind = "missing" if odd[0] in self._trial_schema.names else "unknown"
                raise Misfit(f"trials.parquet: trial {trial}: column {odd[0]!r} is {kind}")
            if self._contents is not None:
                check_row(row, self._contents, {self._code})

    def _note(self, trial: TrialRecord) -> None:
        """Write down what drew a trial's frames, where nothing of this run was drawn by it before."""
        new = {
            entry: [*self._noted[entry], mark]
            for entry, mark in ((RENDERERS, trial.renderer), (PIXELS, trial.pixels))
            if mark and mark not in self._noted[entry]
        }
        if not new:
            return
        self._noted |= new
        self.write_json("experiment.json", {**read_description(self.folder), **new})

    def fail(self, failure: Failure) -> None:
        """Note a trial that could not be finished."""
        self._failures.append(failure)
        self._joined = False

    def failures(self) -> list[Failure]:
        """Return what failed so far, in order of trial."""
        return sorted(self._failures, key=lambda failure: (failure.trial, failure.model))

    def _write_part(self) -> None:
        """Write the trials that are on no disk yet as a part of the tables."""
        trials, names = sorted(self._pending), [file_name(name, self._next_part) for name in TABLES]
        self.path(PARTS).mkdir(exist_ok=True)
        self._joined = False
        # Rows last: whenever this is cut short, a trial that has its row has its frames, and its models' failures.
        # Those of a trial done again go with its new rows alone: without them it would be done once more.
        again = self._before.keys() & {*trials}
        frames = {trial: self._frames[trial] for trial in trials}
        self.write_table(names[1], joined_frames(frames, self._frame_schema))
        self._write_failures(but=again)
        self._write_rows(names[0], [row for trial in trials for row in self._rows[trial]])
        if again:
            self._write_failures()
        self._frames_bytes += self.path(names[1]).stat().st_size
        self._next_part += 1
        self._pending.clear()
        now = time.monotonic()
        self._due = now + max(PART_S, PART_SHARE * (now - self._began))

    def flush(self) -> None:
        """Bring the whole tables up to date, and the list of failures; their parts go."""
        if self._pending:
            self._write_part()  # which has room where two copies of everything have none
        if self._joined:
            return
        self.write_table("frames.parquet", self.frames())
        self._write_failures()
        self._write_rows("trials.parquet", self.rows())
        remove_parts(self.folder)
        self._joined = True

    def end(self) -> None:
        """Note that the trials are done, when, and by which command the last were."""
        self.write_json("experiment.json", {**read_description(self.folder), ENDED: now(), **command_note()})

    def _write_failures(self, but: Collection[int] = ()) -> None:
        if self._failures or self.path("failures.json").exists():
            self.write_json("failures.json", [failure for failure in self.failures() if failure.trial not in but])

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows so far, in order of trial, then model."""
        return [row for trial in sorted(self._rows) for row in self._rows[trial]]

    def notes(self) -> list[str]:
        """Return what is to be known of the tables beside their numbers, a line each."""
        notes = []
        if self._before:
            lost = "a part of what they left was gone"
            notes.append(f"{self.folder}: done again, since {lost}: {listed_trials(self._before)}")
        if self._changed:
            notes.append(f"{self.folder}: done again with other numbers than before: {listed_trials(self._changed)}")
        if len(frames := self._noted[PIXELS]) > 1:
            notes.append(
                f"{self.folder}: its frames were drawn with pixels that differ (reference frames {', '.join(frames)}),"
                " so trials of one machine may have other numbers on another; experiment.json tells what drew"
            )
        notes += [f"{self.folder}: {note}" for note in self._uncounted()]
        mixed = mixture(self.rows())
        return [*notes, *([f"{self.folder}: {mixed}; experiment.json tells them apart"] if mixed else [])]

    def _uncounted(self) -> list[str]:
        """Return a line for each model that spikes in a channel whose count is null, as far as frames are kept."""
        uncounted = {
            (row["model"], name): None
            for trial, rows in self._rows.items()
            for row in rows
            for name in SPIKES
            if name in row and row[name] is None and name in self._frames[trial].column_names
            and _any(self._frames[trial], row["model"], name)
        }  # fmt: skip
        return [
            f"{model} returns {name} and has no threshold for them, so they are not counted: colias check says more"
            for model, name in uncounted
        ]

    def frames(self) -> pa.Table:
        """Return the per-frame table so far, in the same order."""
        return joined_frames(self._frames, self._frame_schema)

    def _write_rows(self, name: str, rows: Sequence[Mapping[str, Any]]) -> None:
        self.write_table(name, pa.Table.from_pylist(list(rows), self._trial_schema))


def joined_frames(frames: Mapping[int, pa.Table], schema: pa.Schema) -> pa.Table:
    """Return the frames of trials as one table, in the order of the trials."""
    tables = [frames[trial] for trial in sorted(frames)]
    return pa.concat_tables(tables) if tables else schema.empty_table()


def _mb(size: int) -> str:
    return f"{size / 2**20:,.1f} MB"


def _any(frames: pa.Table, model: str, name: str) -> bool:
    """Return whether a model has a number other than 0 in a column of a trial's frames."""
    model_frames = frames.filter(np.asarray(frames["model"]) == model)
    return bool(np.any(model_frames[name].drop_null().to_numpy()))
