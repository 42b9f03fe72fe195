"""The two tables of a run on the disk: each whole, and the parts that were written since.

A run writes what it finished as a new part, and joins all parts into the whole tables when it ends. What a kill leaves
is so a whole table and some parts, or parts alone. Of a trial the newest part counts, then the whole table: so a join
or a removal that was cut short changes nothing, and a trial that was done again replaces its rows and frames together.
"""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa

from experiments.bench.store.files import read_parquet

TABLES = ("trials", "frames")
PARTS = "parts"
"""The folder of the parts, which is there while a run is, and after a kill."""
ATTEMPTS = 5
"""Of a reader whose files are joined meanwhile by the process that writes them."""


def file_name(name: str, part: int | None) -> str:
    """Return where a table is in a run's folder: its ``part``, or ``None``: the whole one."""
    return f"{name}.parquet" if part is None else f"{PARTS}/{name}-{part:04d}.parquet"


def parts_of(folder: Path) -> list[int]:
    """Return the numbers of the parts that have rows, the oldest first."""
    names = (re.fullmatch(r"trials-(\d+)\.parquet", path.name) for path in (folder / PARTS).glob("trials-*.parquet"))
    return sorted(int(match[1]) for match in names if match)


def sources(folder: Path) -> Iterator[int | None]:
    """Yield what a run's rows are to be read from, in order of precedence: the parts from the newest, then the whole.

    The whole table is one of them where it is there.
    """
    yield from reversed(parts_of(folder))
    if (folder / file_name("trials", None)).is_file():
        yield None


def present(folder: Path) -> bool:
    """Return whether a folder holds the tables of a run, whole or in parts."""
    return next(sources(folder), -1) != -1


def read(folder: Path, name: str, columns: Sequence[str] | None = None) -> pa.Table:
    """Read a table of a run, whole or in parts, in the order of its trials.

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
    Exception
        Any, of files that are no tables.
    """
    for _ in range(ATTEMPTS):
        with contextlib.suppress(FileNotFoundError):
            return _read(folder, name, columns)
    return _read(folder, name, columns)


def _read(folder: Path, name: str, columns: Sequence[str] | None) -> pa.Table:
    parts = parts_of(folder)
    whole = folder / file_name(name, None)
    if not parts:
        return read_parquet(whole, columns)
    wanted = None if columns is None else list(dict.fromkeys(["trial", *columns]))
    known: set[int] = set()
    tables = []
    for part in sources(folder):
        trials = set(read_parquet(folder / file_name("trials", part), ["trial"])["trial"].to_pylist()) - known
        table = read_parquet(folder / file_name(name, part), wanted)
        tables.append(table.filter(pa.array(np.isin(table["trial"].to_numpy(), sorted(trials)), pa.bool_())))
        known |= trials
    joined = pa.concat_tables(tables)
    joined = joined.take(np.argsort(joined["trial"].to_numpy(), kind="stable"))
    return joined if columns is None else joined.select(list(columns))


def remove_parts(folder: Path) -> None:
    """Remove all parts, as the whole tables hold what they did.

    Rows go first, the oldest part before the others: at every moment the newest of a trial counts, with its frames.
    """
    parts = folder / PARTS
    if not parts.is_dir():
        return
    for number in parts_of(folder):
        (folder / file_name("trials", number)).unlink()
    for path in parts.iterdir():
        path.unlink()
    parts.rmdir()
