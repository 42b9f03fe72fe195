"""Files that are whole at every moment: each is written beside its place, then renamed into it."""

from __future__ import annotations

import datetime
import hashlib
import json
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import polars as pl

from experiments.bench.store import provenance
from experiments.bench.store.description import NAME, to_json
from experiments.bench.store.places import replacing

_NAMING = threading.Lock()
_given: set[Path] = set()
"""Folders that this process has been told of: another thread may not have made its own yet."""


def new_folder(name: str) -> Path:
    """Return the path of a folder that is not there yet, under ``runs``: a run's name, and the time."""
    first = Path("runs") / f"{name}-{datetime.datetime.now().strftime('%Y%m%d-%H%M%S')}"
    path, number = first, 1
    with _NAMING:
        while path.exists() or path.absolute() in _given:  # of another run begun in the same second
            number += 1
            path = first.with_name(f"{first.name}-{number}")
        _given.add(path.absolute())
    return path


TABLE = "trials.parquet"
"""What the table of a run's trials is called."""
UNREPEATABLE = ("wall_s", "code")
"""Columns that differ between runs of equal numbers."""


def rows_hash(table: Path) -> str:
    """Return the SHA-256 of a table's rows, columns of `UNREPEATABLE` aside: that of all figures drawn from it."""
    return hash_of(read_parquet(table))


def hash_of(rows: pl.DataFrame) -> str:
    """Return the SHA-256 of rows, columns of `UNREPEATABLE` aside."""
    digest = hashlib.sha256()
    for column in rows.drop(UNREPEATABLE, strict=False):
        digest.update(json.dumps([column.name, column.to_list()], default=str).encode())
    return digest.hexdigest()


def tables_of(run: Path) -> list[Path]:
    """Return the tables of a run's trials: its own, or those of its parts in the order in which they ended."""
    whole = run / TABLE
    if whole.is_file():
        return [whole]
    return sorted(run.glob(f"*/{TABLE}"), key=lambda path: path.stat().st_mtime)


def tables_hash(tables: Sequence[Path]) -> str:
    """Return the `rows_hash` of a run's only table; of several that of their hashes, by the names of their folders."""
    if len(tables) == 1:
        return rows_hash(tables[0])
    hashes = {table.parent.name: rows_hash(table) for table in tables}
    return hashlib.sha256(json.dumps(hashes, sort_keys=True).encode()).hexdigest()


def drawn_from(tables: Sequence[Path]) -> str:
    """Say which rows a figure is drawn from, and which commit computed them; empty where there are none.

    Parameters
    ----------
    tables
        Tables of a run's trials, each in the folder that describes it: see `tables_of`.

    Returns
    -------
    str
        ``rows SHA-256 of trials.parquet, commit NAME``: what the figure's file notes as its source.
    """
    try:
        source = json.loads((tables[0].parent / NAME).read_text(encoding="utf-8"))["source"]
        rows = tables_hash(tables)
    except (OSError, ValueError, LookupError, TypeError, pl.exceptions.PolarsError):
        return ""  # a folder of a report, or of a run that is not over
    return f"rows {rows} of {TABLE}, commit {provenance.commit(source) or 'unknown'}"


def read_parquet(path: Path, columns: list[str] | None = None) -> pl.DataFrame:
    """Read a Parquet file, or the named columns of it: ``*`` or ``a=1`` in its path are names like any other."""
    return pl.read_parquet(path, columns=columns, glob=False, hive_partitioning=False)


class Files:
    """The files of a folder. Every method raises ``OSError`` where the folder cannot be written."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def path(self, name: str) -> Path:
        """Return the path of a file in the folder."""
        return self.folder / name

    def write_text(self, name: str, text: str) -> None:
        """Write a text file."""
        self.write_bytes(self.path(name), text.encode())

    def write_json(self, name: str, value: Any) -> None:
        """Write a JSON file, indented for reading; dataclasses become objects."""
        self.write_text(name, to_json(value))

    def write_rows(self, name: str, rows: Sequence[Mapping[str, Any]]) -> None:
        """Write rows as CSV."""
        with replacing(self.path(name)) as partial:
            pl.DataFrame(rows, infer_schema_length=None).write_csv(partial)

    def write_table(self, name: str, table: pl.DataFrame) -> None:
        """Write a table as Parquet."""
        with replacing(self.path(name)) as partial:
            table.write_parquet(partial)

    def write_bytes(self, path: Path, data: bytes) -> None:
        """Write a file at ``path``, in the folder or below it."""
        with replacing(path) as partial:
            partial.write_bytes(data)
