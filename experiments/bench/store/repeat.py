"""Comparison of the rows of two runs, bit for bit."""

from __future__ import annotations

from itertools import zip_longest
from typing import Any

import pyarrow as pa

from experiments.bench.store.files import UNREPEATABLE
from experiments.bench.store.record import Record

SHOWN = 60
"""Characters of a value in a difference."""


def first_difference(there: Record, here: Record) -> str:
    """Say where the rows of two runs differ first.

    Parameters
    ----------
    there, here
        The runs. Columns that no two runs have alike (`UNREPEATABLE`) are left out.

    Returns
    -------
    str
        In a line: table, row, trial and model, column and both values; empty where every row is equal, bit for bit.

    Raises
    ------
    UsageError
        A table cannot be read.
    """
    before, now = there.tables(), here.tables()
    if odd := sorted(before.keys() ^ now.keys()):
        return f"the table {odd[0]} is only {'there' if odd[0] in before else 'here'}"
    differing = (_of_table(f"{name}.parquet", before[name], now[name]) for name in before)
    return next(filter(None, differing), "")


def _of_table(name: str, there: pa.Table, here: pa.Table) -> str:
    columns, others = (
        [column for column in table.schema.names if column not in UNREPEATABLE] for table in (there, here)
    )
    if odd := sorted({*columns} ^ {*others}):
        return f"{name}: the column {odd[0]} is only {'there' if odd[0] in columns else 'here'}"
    if there.num_rows != here.num_rows:
        return f"{name}: {there.num_rows} rows there and {here.num_rows} here"
    rows = {column: row for column in columns if (row := _row(there[column], here[column])) is not None}
    if not rows:
        return ""
    column = min(rows, key=lambda column: rows[column])
    row = rows[column]
    where = ", ".join(f"{key} {there[key][row]}" for key in ("trial", "model") if key in columns)
    before, now = (repr(table[column][row].as_py())[:SHOWN] for table in (there, here))
    return f"{name}: row {row} ({where}): {column} is {before} there and {now} here"


def _row(there: pa.ChunkedArray, here: pa.ChunkedArray) -> int | None:
    """Return the first row in which two columns differ; ``None`` if none."""
    pairs = zip_longest(there.to_pylist(), here.to_pylist())
    return next((row for row, (before, now) in enumerate(pairs) if not _same(before, now)), None)


def _same(before: Any, now: Any) -> bool:
    return before is now or repr(before) == repr(now)  # of a number the shortest text of its bits: 0.0 is not -0.0
