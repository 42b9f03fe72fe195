"""The one reader of runs: what a folder of any kind holds, read when it is asked for."""

from __future__ import annotations

import contextlib
import dataclasses
import datetime
import re
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import polars as pl

from experiments.bench.run.errors import UsageError
from experiments.bench.run.folder import has_tables, read_table
from experiments.bench.store import parameters, provenance
from experiments.bench.store.description import BEGUN, KIND, begun, read_description, write_new
from experiments.bench.store.files import read_parquet
from experiments.bench.store.kinds import FOOTAGE, MEASURED, Kind, kind_of

DEEPEST = 3
"""Levels of folders that are looked through for runs: a sweep's parts are one down."""


@dataclasses.dataclass(frozen=True, repr=False)
class Record:
    """A run of any kind, finished or not, as its files say.

    Attributes
    ----------
    folder
        Where its files are; of footage the table or the recording itself, or a folder of recordings.
    description
        ``run.json``: every parameter, the seed, and what computed it. Empty of footage, and of a folder that
        only holds runs.
    kind
        What kind of run it is. What makes no sense of a kind raises `UsageError` in one line.
    """

    folder: Path
    description: Mapping[str, Any]
    kind: Kind

    @classmethod
    def read(cls, path: Path) -> Self:
        """Read what a folder holds, or a file of footage.

        Parameters
        ----------
        path
            The folder or the file.

        Returns
        -------
        Self
            The run. Its tables are read when they are asked for.

        Raises
        ------
        UsageError
            There is no run.
        """
        if path.is_file():
            if path.suffix not in (".rrd", ".parquet", ".csv"):
                raise UsageError(f"{path} is no run: give its folder, or a table or recording of footage")
            return cls(path, {}, FOOTAGE)
        if not begun(path) and any(path.glob("*.rrd")):
            return cls(path, {}, FOOTAGE)
        parts = next(part_folders(path), None) is not None
        there = {} if parts and not begun(path) else read_description(path)
        kind = kind_of(path, there)
        return cls(path, there, kind)

    @cached_property
    def trials(self) -> pl.DataFrame:
        """A row per trial (or clip, or episode) and model; changed parameters have columns such as ``dsnn.n_con``.

        Raises
        ------
        UsageError
            No trial is finished, or the file cannot be read. The other tables raise it too.
        """
        return self._table("trials")

    @cached_property
    def frames(self) -> pl.DataFrame:
        """A row per frame and model."""
        return self._table("frames")

    @property
    def recordings(self) -> list[Path]:
        """The paths of its Rerun recordings, in order of trial: ``colias view PATH`` shows one."""
        if self.folder.is_file():
            return [self.folder] if self.folder.suffix == ".rrd" else []
        return recordings_in(self.folder)

    @cached_property
    def parts(self) -> list[Self]:
        """The runs in its folders, of a leaderboard, a sweep or a reproduction; none of others."""
        return [self.read(folder) for folder in part_folders(self.folder)] if self.kind.parts else []

    def tables(self) -> dict[str, pl.DataFrame]:
        """Return the tables of trials and frames.

        Returns
        -------
        dict of str to polars.DataFrame
            Name -> table; of a whole those of its parts, with the part's folder before the name.

        Raises
        ------
        UsageError
            No trial is finished, or a table cannot be read.
        """
        if self.kind is FOOTAGE:
            return {self.folder.stem: self.frames}
        if not self.kind.parts:
            return {"trials": self.trials, "frames": self.frames}
        return {
            f"{part.folder.relative_to(self.folder)}/{name}": table
            for part in self.parts if part.done
            for name, table in part.tables().items()
        }  # fmt: skip

    @property
    def name(self) -> str:
        """The experiment's name."""
        declared = self.description.get("experiment", self.kind.name)
        return str(declared["name"] if isinstance(declared, Mapping) else declared)

    @property
    def seed(self) -> int | None:
        """The seed of the whole run; ``None`` where none is known, as of a log: its trials have their own or none."""
        return None if self.kind is MEASURED or "seed" not in self.description else int(self.description["seed"])

    @property
    def planned(self) -> int:
        """Number of trials that the run is to have."""
        if self.kind.parts:
            return sum(part.planned for part in self.parts)
        return int(self.description.get("trials", 0))

    @property
    def done(self) -> int:
        """Number of trials that are finished."""
        if self.kind.parts:
            return sum(part.done for part in self.parts)
        return self._table("trials", ["trial"])["trial"].n_unique() if has_tables(self.folder) else 0

    @property
    def begun(self) -> datetime.datetime | None:
        """The time at which it was begun, UTC; ``None`` where nothing says it, as of footage."""
        return datetime.datetime.fromisoformat(self.description[BEGUN]) if BEGUN in self.description else None

    @property
    def commit(self) -> str | None:
        """The commit that it was begun with, and whether there were changes; ``None`` outside a git checkout."""
        source = self.description.get("source")
        return provenance.commit(source) if isinstance(source, Mapping) else None

    @property
    def models(self) -> list[str]:
        """The labels of its models, or of its behaviours."""
        listed = self.description.get("models") or (self.description.get("settings") or {})
        listed = listed.get("models", ()) if isinstance(listed, Mapping) else listed
        behaviours = [Path(name).stem for name in self.description.get("behaviours", ())]
        return behaviours or [str(model["label"]) for model in listed]

    @property
    def changed(self) -> str:
        """The parameters that are not at their defaults: ``dsnn.n_con=6``; empty if none."""
        return parameters.in_words(self.description.get("changed") or {})

    @property
    def provenance(self) -> str:
        """The origin of its trials: ``simulated``, or of an imported log ``measured``, say."""
        measured = self.description.get("measured")
        return str(measured["provenance"]) if isinstance(measured, Mapping) else "simulated"

    def _table(self, name: str, columns: list[str] | None = None) -> pl.DataFrame:
        if self.kind.parts:
            names = ", ".join(part.folder.name for part in self.parts) or "none"
            raise UsageError(f"{self.folder}: {self.kind.what} has no table of {name} itself; its parts are: {names}")
        if self.kind is FOOTAGE:
            return self._footage(name)
        if not has_tables(self.folder):
            raise UsageError(f"{self.folder}: no {name}.parquet there: no trial of it is finished")
        return read_table(self.folder, name, columns)

    def _footage(self, name: str) -> pl.DataFrame:
        if name != "frames" or not self.folder.is_file() or self.folder.suffix == ".rrd":
            raise UsageError(f"{self.folder}: no table of {name} there: colias watch --table writes one of frames")
        csv = self.folder.suffix == ".csv"
        return pl.read_csv(self.folder, infer_schema_length=None) if csv else read_parquet(self.folder)


def begin_whole(folder: Path, kind: Kind) -> None:
    """Make the folder of a command whose parts are runs of their own, and say its kind there, if it does not yet.

    Its parts say what they are runs of, and refuse another run each.

    Raises
    ------
    UsageError
        The folder holds a run of another kind.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if begun(folder) or next(part_folders(folder), None) is not None:
        there = Record.read(folder).kind
        if there is not kind:
            raise UsageError(f"{folder}: holds {there.what}, not {kind.what}; choose another --out")
    if not begun(folder):
        with contextlib.suppress(FileExistsError):  # another process has just begun there: its parts are locked
            write_new(folder, {KIND: kind.name, "experiment": kind.name, "versions": provenance.versions()})


def recordings_in(folder: Path) -> list[Path]:
    """Return the paths of the recordings in a folder, which need not be a run's: each can be seen by itself."""
    return sorted([*folder.glob("*.rrd"), *folder.glob("recordings/*.rrd")])


def part_folders(folder: Path) -> Iterator[Path]:
    """Yield the runs in a folder that are parts of a whole, of each its folder, down to `DEEPEST` levels."""
    yield from _runs_below(folder, DEEPEST)


def _runs_below(folder: Path, deep: int) -> Iterator[Path]:
    try:
        inside = sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
    except OSError:
        return
    for path in inside if deep else ():
        if begun(path):
            yield path
        else:
            yield from _runs_below(path, deep - 1)


def recording(source: Path, trial: int | None) -> Path:
    """Find the recording that is meant.

    Parameters
    ----------
    source
        An .rrd file, or the folder of a run.
    trial
        The number of a trial or episode; ``None`` for a file, and for the first one that a folder has.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    UsageError
        If there is none, in one line that says which there are.
    """
    if source.is_file():
        if trial is not None:
            raise UsageError(f"--trial {trial}: {source} is one recording; a run's folder has several")
        return source
    if not source.is_dir():
        raise UsageError(f"{source}: no such file or folder")
    recordings = {_number(path): path for path in recordings_in(source)}
    if not recordings:
        names = ", ".join(part.name for part in part_folders(source))
        parts = f"; its parts are: {names}" if names else ""
        raise UsageError(f"{source}: no .rrd recordings in it; runs make them unless told --no-recordings{parts}")
    if trial is None:
        return next(iter(recordings.values()))
    if trial not in recordings:
        numbers = [number for number in recordings if isinstance(number, int)]
        legal = f"{min(numbers)} .. {max(numbers)}, {len(numbers)} of them" if numbers else "none: they have no numbers"
        raise UsageError(f"--trial {trial}: {source} has no recording of it (recorded: {legal})")
    return recordings[trial]


def _number(path: Path) -> int | str:
    """Return the number in a recording's name; its whole name where there is none."""
    digits = re.fullmatch(r"\D*(\d+)", path.stem)
    return int(digits[1]) if digits else path.stem
