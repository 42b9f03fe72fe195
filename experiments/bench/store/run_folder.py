"""The folder of a run that is being written: its description, tables, failures and recordings."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
from filelock import FileLock, Timeout

from experiments.bench.run.errors import UsageError
from experiments.bench.store import provenance, tables
from experiments.bench.store.description import (
    ENDED,
    PIXELS,
    RENDERERS,
    begun,
    command_note,
    now,
    read_description,
    reconciled,
    write_new,
)
from experiments.bench.store.description import NAME as DESCRIPTION
from experiments.bench.store.files import Files
from experiments.bench.store.parameters import Parameters, of_model, with_columns
from experiments.bench.store.rows import RECORDING, Failure, TrialRecord, mixture, recording_name
from experiments.bench.store.tables import PARTS, TABLES, file_name, remove_parts

RECORDINGS, LOCK, FAILURES = "recordings", ".lock", "failures.json"
SPIKES = ("hs_spikes", "vs_spikes", "looming_spikes")

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
        self._trial_schema, self._frame_schema = with_columns(trial_schema, self._parameters), frame_schema
        self.recordings = folder / RECORDINGS
        self._rows: dict[int, tuple[dict[str, Any], ...]] = {}
        self._frames: dict[int, pa.Table] = {}
        self._failures: list[Failure] = []
        self._code = ""
        self._noted: dict[str, list[str]] = {RENDERERS: [], PIXELS: []}
        self.provenance: Mapping[str, Any] = {}
        """What computes, as the folder was entered with it."""
        self._lock: FileLock | None = None
        self._pending: list[int] = []
        self._next_part = 0
        self._began = time.monotonic()
        self._due = 0.0
        self._joined = True

    def enter(self, description: Mapping[str, Any], other_code: bool = False) -> None:
        """Begin a run, or go on with the one that the folder holds.

        Raises
        ------
        UsageError
            The folder holds a run with other parameters or of other code (which ``other_code`` allows); the line names
            the first that differs. Or another process is writing there.
        """
        self.recordings.mkdir(parents=True, exist_ok=True)
        self._take()
        try:
            if begun(self.folder):
                there = reconciled(self.folder, description, other_code)
                self._noted = {entry: there.get(entry, []) for entry in self._noted}
                self._read()
                if there != read_description(self.folder):
                    self.write_json(DESCRIPTION, there)
            else:
                write_new(self.folder, description)
        except BaseException:
            self.close()
            raise
        self.provenance = {key: description[key] for key in (*provenance.KEYS, "form") if key in description}
        self._code = str(description.get("code", ""))

    def _read(self) -> None:
        """Take in the trials that are done; those without any row are to be done again."""
        listed = json.loads(self.path(FAILURES).read_text(encoding="utf-8")) if self.path(FAILURES).exists() else []
        if tables.present(self.folder):
            for row in tables.read(self.folder, "trials").to_pylist():
                self._rows[row["trial"]] = (*self._rows.get(row["trial"], ()), row)
            frames = tables.read(self.folder, "frames")
            trials: npt.NDArray[np.int64] = frames["trial"].to_numpy()
            for trial in self._rows:
                low, high = np.searchsorted(trials, [trial, trial + 1])
                self._frames[trial] = frames.slice(low, high - low)
        failures = [Failure(**item) for item in listed]
        self._failures = [failure for failure in failures if failure.model and failure.trial in self._rows]
        self._joined = len(failures) == len(self._failures) and not self.path(PARTS).exists()
        self._next_part = max(tables.parts_of(self.folder), default=-1) + 1

    def _take(self) -> None:
        """Keep other processes from writing here as long as this one does."""
        lock = FileLock(self.path(LOCK), timeout=0)
        try:
            lock.acquire()
        except Timeout:
            raise UsageError(f"{self.folder}: another process is writing its run there") from None
        except (OSError, NotImplementedError):  # a file system without locks, as some clusters have
            return
        self._lock = lock

    def close(self) -> None:
        """Let other processes write here."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def done(self) -> frozenset[int]:
        """Return the trials that are finished."""
        return frozenset(self._rows)

    def written(self) -> frozenset[int]:
        """Return the finished trials that are on the disk."""
        return self.done() - {*self._pending}

    def recording(self, trial: int) -> Path:
        """Path of a trial's recording."""
        return self.recordings / recording_name(trial)

    def add(self, trial: TrialRecord, condition: str, seed: int) -> None:
        """Append a finished trial: its recording, then its rows and frames, in a part with others that end meanwhile.

        A recording that could not be made is a failure of its own, which names ``condition`` and ``seed``.
        """
        rows = tuple(
            {**row, "code": self._code, **of_model(self._parameters, row.get("model", ""))} for row in trial.rows
        )
        for row in rows:
            if odd := sorted(set(self._trial_schema.names) ^ row.keys()):
                raise ValueError(f"trial {trial.index}: rows and table differ in the columns {', '.join(odd)}")
        if isinstance(trial.recording, bytes):
            self.write_bytes(self.recording(trial.index), trial.recording)
        elif trial.recording:
            self._failures.append(Failure(trial.index, RECORDING, condition, seed, trial.recording))
        self._note(trial)
        self._rows[trial.index] = rows
        self._frames[trial.index] = trial.frames
        self._failures += trial.failures
        self._pending.append(trial.index)
        if time.monotonic() >= self._due:
            self._write_part()

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
        self.write_json(DESCRIPTION, {**read_description(self.folder), **new})

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
        self.write_table(names[1], joined_frames({trial: self._frames[trial] for trial in trials}, self._frame_schema))
        self._write_failures()
        self._write_rows(names[0], [row for trial in trials for row in self._rows[trial]])
        self._next_part += 1
        self._pending.clear()
        now = time.monotonic()
        self._due = now + max(PART_S, PART_SHARE * (now - self._began))

    def flush(self) -> None:
        """Bring the whole tables up to date, and the list of failures; their parts go."""
        if self._pending:
            self._write_part()
        if self._joined:
            return
        self.write_table("frames.parquet", self.frames())
        self._write_failures()
        self._write_rows("trials.parquet", self.rows())
        remove_parts(self.folder)
        self._joined = True

    def end(self) -> None:
        """Note that the trials are done, when, and by which command the last were."""
        self.write_json(DESCRIPTION, {**read_description(self.folder), ENDED: now(), **command_note()})

    def _write_failures(self) -> None:
        if self._failures or self.path(FAILURES).exists():
            self.write_json(FAILURES, self.failures())

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows so far, in order of trial, then model."""
        return [row for trial in sorted(self._rows) for row in self._rows[trial]]

    def notes(self) -> list[str]:
        """Return what is to be known of the tables beside their numbers, a line each."""
        notes = []
        if len(frames := self._noted[PIXELS]) > 1:
            notes.append(
                f"{self.folder}: its frames were drawn with pixels that differ (reference frames {', '.join(frames)}),"
                " so trials of one machine may have other numbers on another; run.json tells what drew"
            )
        notes += [f"{self.folder}: {note}" for note in self._uncounted()]
        mixed = mixture(self.rows())
        return [*notes, *([f"{self.folder}: {mixed}; run.json tells them apart"] if mixed else [])]

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


def _any(frames: pa.Table, model: str, name: str) -> bool:
    """Return whether a model has a number other than 0 in a column of a trial's frames."""
    model_frames = frames.filter(np.asarray(frames["model"]) == model)
    return bool(np.any(model_frames[name].drop_null().to_numpy()))
