"""Write files whole or not at all: each is written as NAME.part, then renamed."""

import contextlib
import dataclasses
import datetime
import io
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, count
from pathlib import Path
from typing import Any

import polars as pl

from dsnn.stimuli import StimulusEntry

NAME = "run.json"
"""The file that describes a run."""


def results_folder(out: str | os.PathLike[str] | None, name: str) -> Path:
    """Return the folder asked for, or the path of a new one under ``runs``: the run's name, and the time."""
    if out is not None:
        return Path(out)
    first = Path("runs") / f"{name}-{datetime.datetime.now().strftime('%Y%m%d-%H%M%S')}"
    further = (first.with_name(f"{first.name}-{number}") for number in count(2))  # of a run begun in the same second
    return next(path for path in chain([first], further) if not path.exists())


def part(place: Path) -> Path:
    """Return where a file is written until it is whole: NAME.part in the same folder."""
    return place.with_name(f"{place.name}.part")


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Write a file so that it has its name when it is whole, or not at all.

    Yields
    ------
    Path
        The part, NAME.part in the same folder. The caller writes it; after an error it is removed.
    """
    partial = part(path)
    try:
        yield partial
        partial.replace(path)
    except OSError as error:
        if error.errno:
            error.filename = error.filename or str(path)  # a write that fails names none
        raise
    finally:
        partial.unlink(missing_ok=True)


def read_parquet(path: Path | list[Path], columns: list[str] | None = None) -> pl.DataFrame:
    """Read Parquet files of one schema, or some columns of them; ``*`` and ``a=1`` in a path are names like others."""
    return pl.read_parquet(path, columns=columns, glob=False, hive_partitioning=False)


def read_json(path: Path) -> Any:
    """Read a JSON file."""
    return json.loads(path.read_text(encoding="utf-8"))


def to_json(value: Any) -> str:
    """Return indented JSON; dataclasses become objects."""
    return json.dumps(value, indent=2, default=plain) + "\n"


def plain(value: Any) -> Any:
    """Return what JSON has for a value: what its ``as_json`` returns, of a dataclass an object, else its text."""
    if hasattr(value, "as_json"):
        return value.as_json()
    if isinstance(value, StimulusEntry):
        return value.name
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        # A field that makes no two values differ is no parameter; one that came later may be left out where it is not
        # set, so that what was declared before it reads as it did.
        return {
            field.name: getattr(value, field.name)
            for field in dataclasses.fields(value)
            if field.compare and (getattr(value, field.name) or not field.metadata.get("where_set"))
        }
    return str(value)


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
        self.write_text(name, pl.DataFrame(rows, infer_schema_length=None).write_csv())

    def write_table(self, path: Path, table: pl.DataFrame) -> None:
        """Write a table as Parquet at ``path``, in the folder or below it."""
        table.write_parquet(data := io.BytesIO())  # of a full disk polars says only that it cannot compute
        self.write_bytes(path, data.getvalue())

    def write_bytes(self, path: Path, data: bytes) -> None:
        """Write a file at ``path``, in the folder or below it."""
        with replacing(path) as partial:
            partial.write_bytes(data)
