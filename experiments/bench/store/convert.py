"""Tables of runs for other programs: CSV, NumPy's .npz without pickles, MATLAB's .mat."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.csv

from experiments.bench.run.errors import UsageError
from experiments.bench.store.description import short
from experiments.bench.store.files import read_parquet

LONGEST_FIELD = 63
"""Characters of a field's name in MATLAB."""


def read_file(path: Path) -> pa.Table:
    """Read one table: a .parquet or .csv file, as ``colias watch --table`` writes them; `UsageError` for another."""
    try:
        if path.suffix == ".csv":
            return pyarrow.csv.read_csv(path, convert_options=pyarrow.csv.ConvertOptions(strings_can_be_null=True))
        if path.suffix != ".parquet":
            raise UsageError(f"{path}: no table: its name should end in .parquet or .csv")
        return read_parquet(path)
    except pa.ArrowException as error:
        raise UsageError(f"{path}: cannot be read ({short(error)})") from None


def write(tables: Mapping[str, pa.Table], folder: Path, kind: str) -> list[Path]:
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


def array(column: pa.ChunkedArray) -> npt.NDArray[Any]:
    """Return a column as an array of numbers, truth values or texts, never of objects."""
    if pa.types.is_string(column.type):
        return np.array([value or "" for value in column.to_pylist()], dtype=np.str_)
    if column.null_count or pa.types.is_null(column.type):
        return np.array([np.nan if value is None else value for value in column.to_pylist()], np.float64)
    return np.asarray(column.to_numpy())


def _csv(path: Path, table: pa.Table) -> None:
    pyarrow.csv.write_csv(table, path)


def _npz(path: Path, table: pa.Table) -> None:
    columns = {name: array(table[name]) for name in table.column_names}
    np.savez_compressed(path, allow_pickle=False, **columns)


def _mat(path: Path, table: pa.Table) -> None:
    from scipy import io  # not before: it takes its time to load

    columns = {}
    for name, field in zip(table.column_names, fields(table.column_names), strict=True):
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
