"""Scores of models with their intervals, on the terminal: a row for each model, the best on top."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import polars as pl

from experiments.bench.report import terminal
from experiments.bench.stats.tests import Score

PRINTED = 3
"""Measures in one table."""


def show(table: pl.DataFrame, measures: Sequence[str], title: str) -> None:
    """Print scores with their intervals.

    Parameters
    ----------
    table
        A row for each model; for each measure the columns ``NAME``, ``NAME_low`` and ``NAME_high``.
    measures
        Their names.
    title
        Of the first table.
    """
    for first in range(0, len(measures), PRINTED):
        part = measures[first : first + PRINTED]
        rows = [{"model": row["model"], **{name: _score(row, name) for name in part}} for row in table.to_dicts()]
        terminal.show(pl.DataFrame(rows), title if not first else "")


def _score(row: Mapping[str, Any], name: str) -> str:
    value, low, high = (math.nan if row[key] is None else row[key] for key in (name, f"{name}_low", f"{name}_high"))
    return "" if math.isnan(value) else str(Score(value, low, high, 0))
