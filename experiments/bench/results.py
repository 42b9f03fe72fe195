"""Tables of a run: one row per trial, one per frame, written whole and atomically after every trial."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet as pq

from experiments.bench.trial import FrameColumns, TrialResult

TRIAL_SCHEMA = pa.schema(
    {
        "experiment": pa.string(),
        "trial": pa.int64(),
        "repeat": pa.int64(),
        "seed": pa.int64(),
        "model": pa.string(),
        "motion": pa.string(),
        "speed_cm_s": pa.float64(),
        "distance_cm": pa.float64(),
        "angle_deg": pa.float64(),
        "direction": pa.string(),
        "spikes": pa.int64(),
        "firing_rate_hz": pa.float64(),
        "peak_hs": pa.float64(),
        "trough_hs": pa.float64(),
        "peak_vs": pa.float64(),
        "trough_vs": pa.float64(),
        "achieved_speed_cm_s": pa.float64(),
        "path_error_mm": pa.float64(),
        "closest_cm": pa.float64(),
        "frames": pa.int64(),
        "wall_s": pa.float64(),
    }
)

FRAME_SCHEMA = pa.schema(
    {
        "trial": pa.int64(),
        "frame": pa.int64(),
        **{
            field.name: pa.int64() if field.name.endswith("spikes") else pa.float64()
            for field in dataclasses.fields(FrameColumns)
        },
    }
)


class RunFolder:
    """The files of one run. Every file is complete at every moment: written beside its place, then renamed into it.

    Raises ``OSError`` when the folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.recordings = folder / "recordings"
        self._trials: list[dict[str, Any]] = []
        self._frames: list[pa.Table] = []

    def create(self, description: Mapping[str, Any]) -> None:
        """Make the folder with its ``experiment.json``.

        Raises ``FileExistsError`` if it holds a run already, which is never overwritten; of two runs that begin
        at once, one gets it.
        """
        self.recordings.mkdir(parents=True, exist_ok=True)
        try:
            if self.path("trials.parquet").exists():
                raise FileExistsError
            with self.path("experiment.json").open("x", encoding="utf-8") as file:
                file.write(_json(description))
        except FileExistsError:
            raise FileExistsError(f"{self.folder} already holds a run: choose another --out, or remove it") from None

    def path(self, name: str) -> Path:
        """Path of a file in the folder."""
        return self.folder / name

    def add(self, result: TrialResult) -> None:
        """Append a finished trial and bring both tables up to date."""
        self._trials.append(trial_row(result))
        self._frames.append(frame_table(result))
        order = sorted(range(len(self._trials)), key=lambda i: self._trials[i]["trial"])
        # Frames first: whenever this is cut short, a trial that has its row has its frames.
        self._write_table("frames.parquet", pa.concat_tables([self._frames[i] for i in order]))
        self._write_table("trials.parquet", pa.Table.from_pylist([self._trials[i] for i in order], TRIAL_SCHEMA))

    def trials(self) -> list[dict[str, Any]]:
        """The rows so far, in order of trial."""
        return sorted(self._trials, key=lambda row: row["trial"])

    def frames(self) -> pa.Table:
        """The per-frame table so far."""
        return pa.concat_tables(self._frames) if self._frames else FRAME_SCHEMA.empty_table()

    def write_text(self, name: str, text: str) -> None:
        """Write a text file atomically."""
        partial = self.path(name + ".part")
        partial.write_text(text, encoding="utf-8")
        partial.replace(self.path(name))

    def write_json(self, name: str, value: Mapping[str, Any]) -> None:
        """Write a JSON file atomically, indented for reading."""
        self.write_text(name, _json(value))

    def write_rows(self, name: str, rows: Sequence[Mapping[str, Any]]) -> None:
        """Write rows as CSV atomically."""
        partial = self.path(name + ".part")
        pa.csv.write_csv(pa.Table.from_pylist(list(rows)), partial)
        partial.replace(self.path(name))

    def _write_table(self, name: str, table: pa.Table) -> None:
        partial = self.path(name + ".part")
        pq.write_table(table, partial)
        partial.replace(self.path(name))


def trial_row(result: TrialResult) -> dict[str, Any]:
    """The row of ``trials.parquet``: what was set, then what came out."""
    spec, condition = result.spec, result.spec.condition
    set_values = {
        "experiment": spec.experiment,
        "trial": spec.index,
        "repeat": spec.repeat,
        "seed": spec.seed,
        "model": spec.settings.model,
        **dataclasses.asdict(condition),
    }
    return {name: set_values[name] if name in set_values else getattr(result, name) for name in TRIAL_SCHEMA.names}


def frame_table(result: TrialResult) -> pa.Table:
    """The rows of ``frames.parquet`` of one trial."""
    columns = {field.name: getattr(result.columns, field.name) for field in dataclasses.fields(FrameColumns)}
    index = {"trial": [result.spec.index] * result.frames, "frame": range(result.frames)}
    return pa.table({**index, **columns}, schema=FRAME_SCHEMA)


def read_trials(folder: Path) -> list[dict[str, Any]]:
    """The rows of a run's ``trials.parquet``; ``FileNotFoundError`` where there is none."""
    rows: list[dict[str, Any]] = pq.read_table(folder / "trials.parquet").to_pylist()
    return rows


def group(rows: Iterable[Mapping[str, Any]], *keys: str) -> dict[tuple[Any, ...], list[Mapping[str, Any]]]:
    """Rows by the values of ``keys``, groups in order of first appearance."""
    groups: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def _json(value: Mapping[str, Any]) -> str:
    return json.dumps(value, indent=2, default=_plain) + "\n"


def _plain(value: Any) -> Any:
    """What JSON does not know: dataclasses become objects, paths text."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return dataclasses.asdict(value)
    return str(value)
