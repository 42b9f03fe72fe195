"""The folder of a run: its description, tables, failures and recordings.

While a run is under way each finished trial has its own files in ``parts/``: its frames, then its rows. They are joined
into ``frames.parquet`` and ``trials.parquet`` when the run ends. A kill so loses no finished trial, and nothing changes
where the joining itself is cut short: a trial's own files count more than the joined tables.

``run.json`` has every parameter of a run, its seed, and what computed it: one form for every kind of run.
"""

import datetime
import io
import json
import shutil
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import polars as pl
from filelock import FileLock, Timeout

from experiments.base.errors import UsageError, short
from experiments.base.files import NAME, Files, read_json, read_parquet, to_json
from experiments.settings.parameters import Parameters, of_model, with_columns
from experiments.store import provenance
from experiments.store.asked import ASKED, command_note
from experiments.store.tables import FAILURE, RECORDING, TrialRecord, table

KIND = "kind"
"""The entry with the kind of the run: ``trials``, ``clips``, ..."""
BEGUN, ENDED = "begun", "ended"
"""The entries that say when the run was begun, and when the last of its trials was done: ISO 8601, UTC."""
RENDERERS = "renderers"
"""The entry with what drew the frames (`colias_sim.gl.renderer`), each with the hashes of its reference frames
(`colias_sim.reference`), one unless machines differ. It is no parameter: a run may be resumed with another renderer, as
all that were tried drew equal pixels."""
CPUS = "cpus"
"""The entry with the features of the CPUs that computed the trials (`experiments.store.tables.cpu_features`), one
unless machines differ. It is no parameter: a run may be resumed on another CPU, whose last bits differ."""
THRESHOLDS = "thresholds"
"""The entry with each model's spiking thresholds, label -> channel -> number: readers do not run a model's file."""
NOTES = frozenset((KIND, BEGUN, ENDED, "command", ASKED, RENDERERS, CPUS, THRESHOLDS, *provenance.KEYS))
"""Entries that are not parameters."""
DERIVED = frozenset(("trials", "changed", "clips", "backgrounds"))
"""Entries that follow from others."""
OF_REPLICATES = ("replicates", "trials", "backgrounds")
"""Entries of a study that grow when it resumes with more replicates: its trials are in the order of these."""
MOST_NAMED = 3
"""Parameters that a refusal to resume names."""


def now() -> str:
    """Return the time as `BEGUN` has it."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


def begun(folder: Path) -> bool:
    """Return whether ``folder`` holds a run."""
    return (folder / NAME).is_file()


def write_new(folder: Path, description: Mapping[str, Any]) -> None:
    """Write the description, the time and the command, whole or not at all."""
    Files(folder).write_json(NAME, {BEGUN: now(), **command_note(folder), **description})


def begin_whole(folder: Path, description: Mapping[str, Any]) -> None:
    """Make the folder of a run of runs, if it does not hold one of this kind yet.

    A run that resumes there is compared with its parts, not with the description.

    Raises
    ------
    UsageError
        The folder holds a run of another kind.
    """
    kind = description[KIND]
    folder.mkdir(parents=True, exist_ok=True)
    if not begun(folder):
        write_new(folder, {"experiment": kind, "versions": provenance.versions(), **description})
    elif (there := read_description(folder).get(KIND)) != kind:
        raise UsageError(f"{folder}: holds a run of kind {there}, not {kind}; choose another --out")


def read_description(folder: Path) -> dict[str, Any]:
    """Read the description in ``folder``; `UsageError` in one line if there is none."""
    if not begun(folder):
        if (folder / "experiment.json").is_file():
            raise UsageError(f"{folder}: colias-sim 0.3 or earlier made this run, and reads it")
        raise UsageError(f"{folder}: no {NAME} there, so it is no run's folder")
    try:
        description: dict[str, Any] = read_json(folder / NAME)
    except ValueError as error:
        raise UsageError(f"{folder / NAME}: is not a run's description: {error}") from None
    return description


def resumed(folder: Path, description: Mapping[str, Any], *, complete: bool = False) -> dict[str, Any]:
    """Return the description in ``folder``, for a run described by ``description`` that resumes there.

    A study may resume with more replicates than it has.

    Parameters
    ----------
    folder
        Where the run is.
    description
        That of the run now.
    complete
        Whether no trial is missing. Then nothing is computed, and the run may be judged by other claims.

    Raises
    ------
    UsageError
        Parameters differ, or what computes does; the line names the first.
    """
    here = json.loads(to_json(description))
    there = provenance.moved(read_description(folder), here)
    if here.get("replicates", 0) > there.get("replicates", 0) > 0:
        there |= {name: here[name] for name in OF_REPLICATES if name in here}
    if complete and isinstance(there.get("experiment"), dict) and "claims" in there["experiment"]:
        there["experiment"] |= {"claims": here["experiment"]["claims"]}
    found = [*differences(there, here), *(provenance.differences(there, here) if "source" in here else ())]
    if differing := [f"{name} is {short(a)} there and {short(b)} now" for name, a, b in found]:
        first = "; ".join(differing[:MOST_NAMED])
        raise UsageError(f"{folder}: {first}: use the first command's options and files, or choose another --out")
    return there


def differences(there: Mapping[str, Any], here: Mapping[str, Any]) -> list[tuple[str, Any, Any]]:
    """Return name and both values of every parameter that differs, as ``--set`` names it; `DERIVED` ones if all are so.

    Of runs of two experiments, only that is returned; of models those that both runs have.
    """
    before, after = (dict(_parameters(description, "")) for description in (there, here))
    names = [name for name in before | after if before.get(name) != after.get(name)]
    found = [(name, before.get(name), after.get(name)) for name in names]
    if before.get("experiment") != after.get("experiment"):
        return [entry for entry in found if entry[0] == "experiment"]
    alone = {name.removesuffix(".source") for name in before.keys() ^ after.keys() if name.endswith(".source")}
    found = [entry for entry in found if not entry[0].startswith(tuple(f"{label}." for label in alone))]
    return [entry for entry in found if entry[0].split(".")[0] not in DERIVED] or found


def _parameters(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Yield name and value of every parameter: an experiment's name, its design's fields, labels of models, theirs."""
    if isinstance(value, dict):
        for name, item in value.items():
            if not path and name in NOTES:
                continue
            if (path, name) == ("experiment", "name"):
                yield "experiment", item
            else:
                inner = name in ("settings", "design", "network")
                yield from _parameters(item, path if inner else f"{path}.{name}".lstrip("."))
    elif path == "models":
        yield path, [model["label"] if isinstance(model, dict) else model for model in value]
        for model in value if value and isinstance(value[0], dict) else ():
            label = model["label"] if len(value) > 1 else model["label"].partition(":")[0]  # a single one has its name
            yield from _parameters({name: model[name] for name in ("source", "network", "processor")}, label)
    else:
        yield path, value


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
                self.write_json(NAME, there)
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
        listed = read_json(self.path(FAILURES)) if self.path(FAILURES).exists() else []
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
            self.write_json(NAME, {**read_description(self.folder), RENDERERS: self.renderers})
        if trial.cpu not in self._cpus:
            self._cpus.append(trial.cpu)
            self.write_json(NAME, {**read_description(self.folder), CPUS: self._cpus})
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
        """Note that the trials are done, and when."""
        self.write_json(NAME, {**read_description(self.folder), ENDED: now()})

    def table(self, name: str) -> pl.DataFrame:
        """Return the rows of the ``trials``, or of the ``frames``, so far, in order of trial, then model."""
        return read_table(self.folder, name) if has_tables(self.folder) else pl.DataFrame(schema=self._schemas[name])
