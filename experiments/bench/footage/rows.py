"""A table of what models responded to footage: a row per frame and model."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import polars as pl

from dsnn import Response
from experiments.bench.footage.video import Picture
from experiments.bench.run.files import part
from experiments.bench.run.rows import ResponseRow, schema_of

SCHEMA = pl.Schema({"frame": int, "time_s": float, "model": str}) | schema_of(ResponseRow)
FIELDS = tuple(ResponseRow.__annotations__)
ENDINGS = (".csv", ".parquet")
ROWS_AT_ONCE = 4096


class FrameTable:
    """The responses of the models ``labels``, a row per frame and model.

    Rows are packed while frames come in: three models take 26 MB an hour. With a ``path`` the table is written there by
    `close`, as CSV or Parquet by its ending; ``OSError`` is raised at once where it cannot be.
    """

    note = ""

    def __init__(self, labels: Sequence[str], path: Path | None = None) -> None:
        self._labels, self._path = labels, path
        self._rows: list[tuple[Any, ...]] = []
        self._tables = [pl.DataFrame(schema=SCHEMA)]
        if path is not None:
            part(path).touch()

    def add(self, picture: Picture, answers: Sequence[Response | None]) -> None:
        """Take a frame and the models' answers to it; a model that went wrong has no row."""
        for label, answer in zip(self._labels, answers, strict=True):
            if answer is not None:
                responses = (getattr(answer, name) for name in FIELDS)
                self._rows.append((picture.frame, picture.time_s, label, *responses))
        if len(self._rows) >= ROWS_AT_ONCE:
            self._pack()

    def table(self) -> pl.DataFrame:
        """Return the table so far."""
        self._pack()
        return pl.concat(self._tables)

    def close(self) -> None:
        """Write the table, and put it in its place."""
        if self._path is not None:
            write = pl.DataFrame.write_csv if self._path.suffix == ".csv" else pl.DataFrame.write_parquet
            write(self.table(), part(self._path))
            part(self._path).replace(self._path)

    def _pack(self) -> None:
        if self._rows:
            columns = zip(SCHEMA, zip(*self._rows, strict=True), strict=True)
            self._tables.append(pl.DataFrame(dict(columns), SCHEMA))
            self._rows.clear()
