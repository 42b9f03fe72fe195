"""The folder of a run: its description, tables, failures and recordings.

While a run is under way each finished trial has its own files in ``parts/``: its frames, then its rows. They are joined
into ``frames.parquet`` and ``trials.parquet`` when the run ends. A kill so loses no finished trial, and nothing changes
where the joining itself is cut short: a trial's own files count more than the joined tables.
"""

from __future__ import annotations

import io
import json
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import polars as pl
from filelock import FileLock, Timeout

from experiments.base.errors import UsageError
from experiments.base.files import NAME as DESCRIPTION, Files, read_parquet
from experiments.settings.parameters import Parameters, of_model, with_columns
from experiments.store.asked import command_note
from experiments.store.description import CPUS, ENDED, RENDERERS, begun, now, read_description, resumed, write_new
from experiments.store.tables import FAILURE, RECORDING, TrialRecord, table

RECORDINGS, LOCK, FAILURES = "recordings", ".lock", "failures.json"

PARTS = "parts"
"""The folder of the trials' own files, which is there while a run is, and after a kill."""


def _part(folder: Path, trial: int, name: str) -> Path:
    """Path of a trial's own file: its ``trials`` (rows) or ``frames``."""
    return folder / PARTS / f"{trial:06d}-{name}.arrow"


def _in_parts(folder: Path) -> list[int]:
    """Return the trials that have their own files: rows are written last."""
    return sorted(int(path.name.partition("-")[0]) for path in (folder / PARTS).glob("*-trials.arrow"))


def has_tables(folder: Path) -> bool:
    """Return whether any trial of the run in a folder is finished."""
    return (folder / "trials.parquet").is_file() or bool(_in_parts(folder))


def read_table(folder: Path, name: str, columns: list[str] | None = None) -> pl.DataFrame:
    """Read a table of a run, joined or not, in the order of its trials.

    Parameters
    ----------
    folder
        The run's folder; another process may be writing there.
    name
        ``trials`` or ``frames``.
    columns
        Names of the columns to read; all if left out.

    Raises
    ------
    FileNotFoundError
        No trial is finished.
    """
    parts, whole = _in_parts(folder), folder / f"{name}.parquet"
    if not parts:
        return read_parquet(whole, columns)
    wanted = None if columns is None else list(dict.fromkeys(["trial", *columns]))
    tables = [pl.read_ipc_stream(_part(folder, trial, name), columns=wanted) for trial in parts]
    if whole.is_file():
        tables.append(read_parquet(whole, wanted).filter(~pl.col("trial").is_in(parts)))
    table = pl.concat(tables).sort("trial", maintain_order=True)
    return table if columns is None else table.select(columns)


class RunFolder(Files):
    """The files of one run: its description, tables, failures and recordings.

    Parameters
    ----------
    folder
        Where they are. It is made if need be.
    trial_schema, frame_schema
        Columns of ``trials.parquet`` and ``frames.parquet``.
    parameters
        Those that have columns of their own in ``trials.parquet``, by key and model.

    Raises
    ------
    OSError
        The folder cannot be written.
    """

    def __init__(
        self, folder: Path, trial_schema: pl.Schema, frame_schema: pl.Schema, parameters: Parameters | None = None
    ) -> None:
        super().__init__(folder)
        self._parameters = parameters or {}
        self._schemas = {"trials": with_columns(trial_schema, self._parameters), "frames": frame_schema}
        self.recordings = folder / RECORDINGS
        self._done: set[int] = set()
        self._failures: list[dict[str, Any]] = []
        self.renderers: dict[str, list[str]] = {}
        self._cpus: list[str] = []
        self._lock = FileLock(self.path(LOCK), timeout=0)

    def enter(self, description: Mapping[str, Any], trials: Iterable[int] = ()) -> None:
        """Begin a run of ``trials``, or go on with the one that the folder holds.

        Raises
        ------
        UsageError
            The folder holds a run with other parameters, or of other code; the line names the first that differs. Or
            another process is writing there.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        try:
            self._lock.acquire()
        except Timeout:
            raise UsageError(f"{self.folder}: another process is writing its run there") from None
        except (OSError, NotImplementedError):  # a file system without locks, as some clusters have
            pass
        try:
            if begun(self.folder):
                self._read()
                there = resumed(self.folder, description, complete=self._done >= set(trials))
                self.renderers, self._cpus = there.get(RENDERERS, {}), there.get(CPUS, [])
                self.write_json(DESCRIPTION, there)
            elif has_tables(self.folder):
                raise UsageError(f"{self.folder}: holds tables and no run.json; choose another folder")
            else:
                write_new(self.folder, description)
        except BaseException:
            self.close()
            raise

    def _read(self) -> None:
        """Take in the trials that are done, and which models failed in them; other trials are to be done again."""
        self._done = set(self.table("trials")["trial"])
        listed = json.loads(self.path(FAILURES).read_text(encoding="utf-8")) if self.path(FAILURES).exists() else []
        self._failures = [failure for failure in listed if failure["model"] and failure["trial"] in self._done]

    def close(self) -> None:
        """Let other processes write here."""
        self._lock.release()

    def done(self) -> frozenset[int]:
        """Return the trials that are finished."""
        return frozenset(self._done)

    def recording(self, trial: int) -> Path:
        """Path of a trial's recording, whose folder is made."""
        self.recordings.mkdir(exist_ok=True)
        return self.recordings / f"trial-{trial:04d}.rrd"

    def add(self, trial: TrialRecord, condition: str, seed: int) -> None:
        """Write a finished trial: its recording, its frames, its models' failures, then its rows.

        Failures name its ``condition`` and ``seed``; a recording that could not be made is one of its own.
        """
        rows = [{**row, **of_model(self._parameters, row.get("model", ""))} for row in trial.rows]
        for row in rows:
            if odd := sorted({*self._schemas["trials"]} ^ row.keys()):
                raise ValueError(f"trial {trial.index}: rows and table differ in the columns {', '.join(odd)}")
        troubles = dict(trial.troubles)
        if isinstance(trial.recording, bytes):
            self.write_bytes(self.recording(trial.index), trial.recording)
        elif trial.recording:
            troubles[RECORDING] = trial.recording
        if trial.renderer and trial.pixels not in (known := self.renderers.setdefault(trial.renderer, [])):
            known.append(trial.pixels)
            self.write_json(DESCRIPTION, {**read_description(self.folder), RENDERERS: self.renderers})
        if trial.cpu not in self._cpus:
            self._cpus.append(trial.cpu)
            self.write_json(DESCRIPTION, {**read_description(self.folder), CPUS: self._cpus})
        self.path(PARTS).mkdir(exist_ok=True)
        self._write_part(trial.index, "frames", trial.frames)
        for model, reason in troubles.items():
            self.fail(trial.index, condition, seed, reason, model)
        self._write_part(trial.index, "trials", table(rows, self._schemas["trials"]))
        self._done.add(trial.index)

    def _write_part(self, trial: int, name: str, rows: pl.DataFrame) -> None:
        rows.write_ipc_stream(data := io.BytesIO(), compression="lz4")  # a seventh of the time of Parquet
        self.write_bytes(_part(self.folder, trial, name), data.getvalue())

    def fail(self, trial: int, condition: str, seed: int, reason: str, model: str = "") -> None:
        """Note what could not be done: a trial, a ``model`` in one, or its recording."""
        self._failures.append(dict(zip(FAILURE, (trial, model, condition, seed, reason), strict=True)))
        self.write_json(FAILURES, self.failures())

    def failures(self) -> list[dict[str, Any]]:
        """Return what failed so far, rows of `experiments.store.tables.FAILURE` in order of trial."""
        return sorted(self._failures, key=lambda failure: (failure["trial"], failure["model"]))

    def flush(self) -> None:
        """Join the trials' own files into the tables, and bring the list of failures up to date."""
        if self.path(FAILURES).exists():
            self.write_json(FAILURES, self.failures())
        if self.path(PARTS).is_dir() or not has_tables(self.folder):
            for name in ("frames", "trials"):
                self.write_table(self.path(f"{name}.parquet"), self.table(name))
            for trial in _in_parts(self.folder):
                _part(self.folder, trial, "trials").unlink()  # its frames are no longer read without
            shutil.rmtree(self.path(PARTS), ignore_errors=True)

    def end(self) -> None:
        """Note that the trials are done, when, and by which command the last were."""
        self.write_json(DESCRIPTION, {**read_description(self.folder), ENDED: now(), **command_note(self.folder)})

    def table(self, name: str) -> pl.DataFrame:
        """Return the rows of the ``trials``, or of the ``frames``, so far, in order of trial, then model."""
        return read_table(self.folder, name) if has_tables(self.folder) else pl.DataFrame(schema=self._schemas[name])
