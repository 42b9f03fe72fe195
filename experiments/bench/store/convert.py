"""Tables of runs for other programs: CSV, NumPy's .npz without pickles, MATLAB's .mat."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import polars as pl

from experiments.bench.run.errors import UsageError
from experiments.bench.store.description import short
from experiments.bench.store.files import read_parquet

LONGEST_FIELD = 63
"""Characters of a field's name in MATLAB."""


def read_file(path: Path) -> pl.DataFrame:
    """Read one table: a .parquet or .csv file, as ``colias watch --table`` writes them; `UsageError` for another."""
    try:
        if path.suffix == ".csv":
            return pl.read_csv(path, infer_schema_length=None, glob=False)
        if path.suffix != ".parquet":
            raise UsageError(f"{path}: no table: its name should end in .parquet or .csv")
        return read_parquet(path)
    except pl.exceptions.PolarsError as error:
        raise UsageError(f"{path}: cannot be read ({short(error)})") from None


def write(tables: Mapping[str, pl.DataFrame], folder: Path, kind: str) -> list[Path]:
    """Write tables into a folder.

    Parameters
    ----------
    tables
        Name -> table.
    folder
        Where to.
    kind
        ``csv``, ``npz`` or ``mat``: a file for each table. In ``npz`` and ``mat`` a column is an array; a number that
        is not known is NaN there, so a column of whole numbers that lacks some becomes one of floats, and a text
        that is not known is empty.

    Returns
    -------
    list of Path
        The files.
    """
    paths = []
    for name, table in tables.items():
        path = folder / f"{name}.{kind}"
        path.parent.mkdir(parents=True, exist_ok=True)
        _WRITERS[kind](path, table)
        paths.append(path)
    return paths


def array(column: pl.Series) -> npt.NDArray[Any]:
    """Return a column as an array of numbers, truth values or texts, never of objects."""
    if column.dtype == pl.String:
        return column.fill_null("").to_numpy().astype(np.str_)
    return column.cast(pl.Float64).to_numpy() if column.has_nulls() else column.to_numpy()


def _csv(path: Path, table: pl.DataFrame) -> None:
    table.write_csv(path)


def _npz(path: Path, table: pl.DataFrame) -> None:
    columns = {name: array(table[name]) for name in table.columns}
    np.savez_compressed(path, allow_pickle=False, **columns)


def _mat(path: Path, table: pl.DataFrame) -> None:
    from scipy import io  # not before: it takes its time to load

    columns = {}
    for name, field in zip(table.columns, fields(table.columns), strict=True):
        values = array(table[name])
        columns[field] = values.astype(object) if values.dtype.kind == "U" else values  # texts are a cell array
    io.savemat(path, {re.sub(r"\W", "_", path.stem): columns}, long_field_names=True, oned_as="column")


def fields(names: list[str]) -> list[str]:
    """Return names that MATLAB can have for fields: ``dsnn.n_con`` is ``dsnn_n_con``; no two are equal."""
    legal_names: list[str] = []
    for name in names:
        plain = re.sub(r"\W", "_", name)
        candidate = plain = (plain if plain[:1].isalpha() else f"c_{plain}")[:LONGEST_FIELD]
        number = 1
        while candidate in legal_names:
            number += 1
            candidate = f"{plain[: LONGEST_FIELD - 4]}_{number}"
        legal_names.append(candidate)
    return legal_names


_WRITERS = {"csv": _csv, "npz": _npz, "mat": _mat}
KINDS = tuple(_WRITERS)
