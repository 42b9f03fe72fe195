"""Comparison of the rows of two runs, bit for bit."""

from __future__ import annotations

from typing import Any

import polars as pl

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


def _of_table(name: str, there: pl.DataFrame, here: pl.DataFrame) -> str:
    there, here = (table.drop(UNREPEATABLE, strict=False) for table in (there, here))
    if odd := sorted({*there.columns} ^ {*here.columns}):
        return f"{name}: the column {odd[0]} is only {'there' if odd[0] in there.columns else 'here'}"
    if there.height != here.height:
        return f"{name}: {there.height} rows there and {here.height} here"
    for row, (before, now) in enumerate(zip(there.iter_rows(), here.select(there.columns).iter_rows(), strict=True)):
        for column, one, other in zip(there.columns, before, now, strict=True):
            if not _same(one, other):
                where = ", ".join(f"{key} {there[key][row]}" for key in ("trial", "model") if key in there.columns)
                values = f"{repr(one)[:SHOWN]} there and {repr(other)[:SHOWN]} here"
                return f"{name}: row {row} ({where}): {column} is {values}"
    return ""


def _same(before: Any, now: Any) -> bool:
    return before is now or repr(before) == repr(now)  # of a number the shortest text of its bits: 0.0 is not -0.0
