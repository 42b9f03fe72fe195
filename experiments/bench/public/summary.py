"""The summary of a run, and its comparisons of models, as Arrow tables."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import pyarrow as pa
import pyarrow.csv

from experiments.bench.run.errors import UsageError
from experiments.bench.sources.conditions import Condition
from experiments.bench.stats.tests import Summary, summarise
from experiments.bench.store.description import short
from experiments.bench.store.rows import group, known, schema_of

if TYPE_CHECKING:
    from experiments.bench.store.record import Record

COMPARISONS = "comparisons.csv"
LOWEST = {"spikes": 0.0}
"""Quantity -> the least that it can be, below which no interval goes."""
CLIP_QUANTITIES = ("spikes", "peak_hs", "trough_hs", "peak_vs", "trough_vs", "peak_looming")

_NUMBERS = {field.name: pa.int64() if field.name == "n" else pa.float64() for field in dataclasses.fields(Summary)}
_CONDITIONS = {field.name: field.type for field in schema_of(Condition)}
ROBOT_SCHEMA = pa.schema({"model": pa.string(), **_CONDITIONS, "quantity": pa.string(), **_NUMBERS})
COMPARISON_SCHEMA = pa.schema(
    {
        **_CONDITIONS,
        **dict.fromkeys(("model", "against"), pa.string()),
        "n": pa.int64(),
        **dict.fromkeys(("mean_difference", "rank_biserial"), pa.float64()),
        "test": pa.string(),
        **dict.fromkeys(("p", "p_holm"), pa.float64()),
    }
)
CLIP_SCHEMA = pa.schema({"model": pa.string(), "clip": pa.string(), "quantity": pa.string(), **_NUMBERS})


def read(run: Record) -> pa.Table:
    """Read the table that sums up a run; of trials no rows where it has none yet.

    Raises `UsageError` where a run of its kind has no such table, or this one has none yet.
    """
    path = run.folder / run.kind.summary
    if not run.kind.summary:
        raise UsageError(f"{run.folder}: {run.kind.what} has no summary")
    if not path.exists():
        if run.kind.robot:
            return ROBOT_SCHEMA.empty_table()
        raise UsageError(f"{run.folder}: no {path.name} there: the run has not come to it")
    return _of_csv(run, run.kind.summary, ROBOT_SCHEMA if run.kind.robot else None)


def comparisons(run: Record) -> pa.Table:
    """Read the paired tests of a run's models; no rows where nothing was to be paired.

    Raises `UsageError` where a run of its kind has no such table, or it cannot be read.
    """
    if not run.kind.robot:
        raise UsageError(f"{run.folder}: {run.kind.what} has no comparisons: runs of trials with the robot have them")
    if not (run.folder / COMPARISONS).exists():
        return COMPARISON_SCHEMA.empty_table()
    return _of_csv(run, COMPARISONS, COMPARISON_SCHEMA)


def _of_csv(run: Record, name: str, schema: pa.Schema | None) -> pa.Table:
    types = pyarrow.csv.ConvertOptions(column_types=schema, strings_can_be_null=True)
    try:
        return pyarrow.csv.read_csv(run.folder / name, convert_options=types)
    except (OSError, pa.ArrowException) as error:
        raise UsageError(f"{run.folder}: {name} cannot be read ({short(error)})") from None


def of_clips(trials: pa.Table) -> pa.Table:
    """Summarise clips over seeds: a row per model, clip and quantity that the model has."""
    rows = [
        {"model": model, "clip": clip, "quantity": quantity,
         **{name: known(value) if isinstance(value, float) else value
            for name, value in dataclasses.asdict(summarise(values, LOWEST.get(quantity, -math.inf))).items()}}
        for (model, clip), clip_rows in group(trials.to_pylist(), "model", "clip").items()
        for quantity in CLIP_QUANTITIES
        if (values := [row[quantity] for row in clip_rows if row[quantity] is not None])
    ]  # fmt: skip
    return pa.Table.from_pylist(rows, CLIP_SCHEMA)
