"""The summary of a run as an Arrow table."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING

import pyarrow as pa
import pyarrow.csv

from experiments.bench.engine.errors import UsageError
from experiments.bench.judging.statistics import Summary, summarise
from experiments.bench.robot.rows import ConditionRow
from experiments.bench.store.description import short
from experiments.bench.store.rows import group, known, schema_of

if TYPE_CHECKING:
    from experiments.bench.store.record import Record

CLIP_QUANTITIES = ("spikes", "peak_hs", "trough_hs", "peak_vs", "trough_vs", "peak_looming")

_NUMBERS = {field.name: pa.int64() if field.name == "n" else pa.float64() for field in dataclasses.fields(Summary)}
_CONDITIONS = {field.name: field.type for field in schema_of(ConditionRow)}
ROBOT_SCHEMA = pa.schema({"model": pa.string(), **_CONDITIONS, "quantity": pa.string(), **_NUMBERS})
CLIP_SCHEMA = pa.schema({"model": pa.string(), "clip": pa.string(), "quantity": pa.string(), **_NUMBERS})


def read(run: Record) -> pa.Table:
    """Read the table that sums up a run; of trials no rows where it has not come to one.

    Raises `UsageError` where a run of its kind has no such table, or this one has not come to it.
    """
    path = run.folder / run.kind.summary
    if not run.kind.summary:
        raise UsageError(f"{run.folder}: {run.kind.what} has no summary")
    if not path.exists():
        if run.kind.robot:
            return ROBOT_SCHEMA.empty_table()
        raise UsageError(f"{run.folder}: no {path.name} there: the run has not come to it")
    types = pyarrow.csv.ConvertOptions(column_types=ROBOT_SCHEMA if run.kind.robot else None, strings_can_be_null=True)
    try:
        return pyarrow.csv.read_csv(path, convert_options=types)
    except (OSError, pa.ArrowException) as error:
        raise UsageError(f"{run.folder}: {path.name} cannot be read ({short(error)})") from None


def of_clips(trials: pa.Table) -> pa.Table:
    """Summarise clips over seeds: a row per model, clip and quantity that the model has."""
    rows = [
        {"model": model, "clip": clip, "quantity": quantity,
         **{name: known(value) if isinstance(value, float) else value
            for name, value in dataclasses.asdict(summarise(values)).items()}}
        for (model, clip), clip_rows in group(trials.to_pylist(), "model", "clip").items()
        for quantity in CLIP_QUANTITIES
        if (values := [row[quantity] for row in clip_rows if row[quantity] is not None])
    ]  # fmt: skip
    return pa.Table.from_pylist(rows, CLIP_SCHEMA)
