"""Summary of a table of trials: a row per group and quantity."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from experiments.bench.run.rows import group, known
from experiments.bench.stats.checks import is_number
from experiments.bench.stats.tests import summarise


def summary_rows(
    rows: Iterable[Mapping[str, Any]], keys: Sequence[str], quantities: Iterable[str], signed: Collection[str]
) -> list[dict[str, Any]]:
    """Summarise quantities of trials in groups: n, mean, sd, median, 95 % interval of the mean.

    Parameters
    ----------
    rows
        Of ``trials.parquet``.
    keys
        Columns by whose values the rows are grouped.
    quantities
        Columns to summarise. A group in which one has no number has no row of it.
    signed
        Those that can be negative: of the others no interval goes below 0.

    Returns
    -------
    list of dict
        A row per group and quantity: ``keys``, ``quantity``, and the fields of `experiments.bench.stats.tests.Summary`.
    """
    table = []
    for values_of_keys, chosen in group(rows, *keys).items():
        for quantity in quantities:
            values = [row[quantity] for row in chosen if is_number(row.get(quantity))]
            if values:
                summary = dataclasses.asdict(summarise(values, -math.inf if quantity in signed else 0.0))
                numbers = {name: known(number) for name, number in summary.items()}
                table.append({**dict(zip(keys, values_of_keys, strict=True)), "quantity": quantity, **numbers})
    return table
