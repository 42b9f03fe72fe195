"""The summary of a run, and its comparisons of models, as tables."""

from __future__ import annotations

from typing import TYPE_CHECKING

import polars as pl

from experiments.bench.run.errors import UsageError
from experiments.bench.sources.conditions import Condition
from experiments.bench.stats.tests import Summary
from experiments.bench.store.description import short
from experiments.bench.store.kinds import CLIPS
from experiments.bench.store.rows import schema_of

if TYPE_CHECKING:
    from experiments.bench.store.record import Record

COMPARISONS = "comparisons.csv"

_QUANTITY = pl.Schema({"quantity": str}) | schema_of(Summary)
ROBOT_SCHEMA = pl.Schema({"model": str}) | schema_of(Condition) | _QUANTITY
COMPARISON_SCHEMA = schema_of(Condition) | pl.Schema({
    "model": str, "against": str, "n": int, "mean_difference": float, "rank_biserial": float, "test": str, "p": float,
    "p_holm": float,
})  # fmt: skip
CLIP_SCHEMA = pl.Schema({"model": str, "clip": str}) | _QUANTITY


def read(run: Record) -> pl.DataFrame:
    """Read the table that sums up a run; of trials no rows where it has none yet.

    Raises `UsageError` where a run of its kind has no such table, or this one has none yet.
    """
    path = run.folder / run.kind.summary
    if not run.kind.summary:
        raise UsageError(f"{run.folder}: {run.kind.what} has no summary")
    if not path.exists():
        if run.kind.robot:
            return pl.DataFrame(schema=ROBOT_SCHEMA)
        raise UsageError(f"{run.folder}: no {path.name} there: the run has not come to it")
    schema = ROBOT_SCHEMA if run.kind.robot else CLIP_SCHEMA if run.kind is CLIPS else None
    return _of_csv(run, run.kind.summary, schema)


def comparisons(run: Record) -> pl.DataFrame:
    """Read the paired tests of a run's models; no rows where nothing was to be paired.

    Raises `UsageError` where a run of its kind has no such table, or it cannot be read.
    """
    if not run.kind.robot:
        raise UsageError(f"{run.folder}: {run.kind.what} has no comparisons: runs of trials with the robot have them")
    if not (run.folder / COMPARISONS).exists():
        return pl.DataFrame(schema=COMPARISON_SCHEMA)
    return _of_csv(run, COMPARISONS, COMPARISON_SCHEMA)


def _of_csv(run: Record, name: str, schema: pl.Schema | None) -> pl.DataFrame:
    try:
        return pl.read_csv(run.folder / name, schema_overrides=schema, infer_schema_length=None, glob=False)
    except (OSError, pl.exceptions.PolarsError) as error:
        raise UsageError(f"{run.folder}: {name} cannot be read ({short(error)})") from None
