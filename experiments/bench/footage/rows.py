"""A table with a row per frame and model, written while frames come in, so that its length takes no memory."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq

from dsnn import Response
from experiments.bench.footage.video import Picture
from experiments.bench.store.places import part

SCHEMA = pa.schema(
    {
        "frame": pa.int64(),
        "time_s": pa.float64(),
        "model": pa.string(),
        "hs": pa.float64(),
        "vs": pa.float64(),
        "hs_spikes": pa.int64(),
        "vs_spikes": pa.int64(),
        "looming": pa.float64(),
        "looming_spikes": pa.int64(),
        "azimuth": pa.float64(),
    }
)
ENDINGS = (".csv", ".parquet")
ROWS_AT_ONCE = 4096


def frame_row(picture: Picture, label: str, answer: Response) -> tuple[int | float | str, ...]:
    """Return a model's answer to a frame as a row, in the order of `SCHEMA`."""
    a = answer
    potentials = (a.hs, a.vs, a.hs_spikes, a.vs_spikes, a.looming, a.looming_spikes, a.azimuth)
    return picture.frame, picture.time_s, label, *potentials


class FrameTable:
    """The table at ``path``, CSV or Parquet by its ending, of the models ``labels``.

    It is written beside its place, as NAME.part, and gets the place when it is complete, by `close`. Raises
    ``OSError`` where it cannot be written.
    """

    note = ""

    def __init__(self, path: Path, labels: Sequence[str]) -> None:
        self._path, self._labels = path, labels
        self._partial = part(path)
        kind = pa.csv.CSVWriter if path.suffix == ".csv" else pq.ParquetWriter
        self._writer = kind(str(self._partial), SCHEMA)
        self._rows: list[tuple[int | float | str, ...]] = []

    def add(self, picture: Picture, answers: Sequence[Response | None]) -> None:
        """Take a frame and the models' answers to it; a model that went wrong has no row."""
        for label, a in zip(self._labels, answers, strict=True):
            if a is None:
                continue
            self._rows.append(frame_row(picture, label, a))
        if len(self._rows) >= ROWS_AT_ONCE:
            self._flush()

    def close(self) -> None:
        """Write what is left, and put the table in its place."""
        if self._rows:
            self._flush()
        self._writer.close()
        self._partial.replace(self._path)

    def _flush(self) -> None:
        columns = dict(zip(SCHEMA.names, zip(*self._rows, strict=True), strict=True))
        self._rows.clear()
        self._writer.write_table(pa.Table.from_pydict(columns, SCHEMA))
