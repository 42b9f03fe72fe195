"""Two runs held against each other: the parameters that differ, and paired tests of spikes on equal trials."""

import json
import os
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import polars as pl

from dsnn import CHANNELS
from experiments.base.console import error_console
from experiments.declare.conditions import CONDITION_COLUMNS
from experiments.judge.tests import contrast, holm, paired
from experiments.kinds.result import Run, load
from experiments.show.clips import SHOWN, TRIALS
from experiments.show.trial_rows import TRIAL_SCHEMA
from experiments.store.folder import DERIVED, differences
from experiments.store.provenance import UNREPEATABLE
from experiments.store.tables import table

CLIP_COLUMNS = ("stimulus", "clip", *SHOWN)
ROUNDING = 1e-5
"""How much a number may differ by rounding, as a part of its size."""
TEST_COLUMNS = pl.Schema({
    "model": str, "against": str, "n": int, "mean_first": float, "mean_second": float, "mean_difference": float,
    "rank_biserial": float, "test": str, "p": float, "p_holm": float,
})  # fmt: skip


def compare(
    first: Run | str | os.PathLike[str], second: Run | str | os.PathLike[str]
) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Return the parameters in which two runs differ, and tests of their spikes on equal trials.

    Equal trials have the same seed and the same condition: runs of one experiment and one seed under other settings
    have them all. Models are paired by label; where the runs share none and each has one model, these two are paired. A
    label does not tell what ``--set`` changed: ``parameters`` does.

    Parameters
    ----------
    first, second
        Runs, or their folders.

    Returns
    -------
    parameters : polars.DataFrame
        A row per parameter that differs: ``parameter``, as ``--set`` names it, and its value in ``first`` and
        ``second``, as JSON. ``code``, the digest of what computed them, is among them.
    results : polars.DataFrame
        A row per model and condition of which both runs have equal trials: ``n`` of them, ``mean_first`` and
        ``mean_second`` spikes a trial, ``mean_difference`` (the first less the second), the rank-biserial correlation,
        and Wilcoxon's signed-rank test; ``p_holm`` is corrected for the number of rows. Where a run was imported from
        a log and no seeds pair its trials, those of a condition are independent: the test is Mann-Whitney's,
        ``rank_biserial`` is Cliff's delta, and ``n`` is the smaller number of trials. No rows where no trials are
        equal.

    Raises
    ------
    UsageError
        A folder holds no run, or no finished trial.

    Examples
    --------
    >>> from experiments import compare, run
    >>> usual, changed = run("speed"), run("speed", settings={"dsnn.n_con": 6})
    >>> parameters, results = compare(usual, changed)
    """
    one, other = (run if isinstance(run, Run) else load(run) for run in (first, second))
    found = [entry for entry in differences(one.description, other.description)
             if entry[0].split(".")[0] not in DERIVED]  # fmt: skip
    codes = [run.description.get("code") for run in (one, other)]
    if codes[0] != codes[1]:
        found.append(("code", codes[0], codes[1]))
    texts = [(name, json.dumps(here), json.dumps(there)) for name, here, there in found]
    parameters = pl.DataFrame(texts, dict.fromkeys(("parameter", "first", "second"), pl.String), orient="row")
    columns, kinds = (CLIP_COLUMNS, TRIALS) if one.kind == "clips" else (CONDITION_COLUMNS, TRIAL_SCHEMA)
    results = _results(one, other, columns) if one.kind in ("clips", "trials", "measured") else []
    if not results:
        error_console.print("no trial is in both runs: these share a model's label, and conditions and seeds of trials")
    return parameters, corrected(results, pl.Schema({name: kinds[name] for name in columns}) | TEST_COLUMNS)


def _results(one: Run, other: Run, columns: Sequence[str]) -> list[dict[str, Any]]:
    """Return a row per model and condition."""
    shared = {*one.trials.columns} & {*other.trials.columns}
    if not {"seed", "spikes", *columns[:2]} <= shared:
        return []
    columns = [name for name in columns if name in shared]
    pairs = [(label, label) for label in one.models if label in other.models]
    if not pairs and len(one.models) == len(other.models) == 1:
        pairs = [(one.models[0], other.models[0])]
    rows = [row for pair in pairs for row in tested(one.trials, other.trials, pair, columns, "seed")]
    if rows or {one.provenance, other.provenance} == {"simulated"}:
        return rows
    return [row for pair in pairs for row in tested(one.trials, other.trials, pair, columns)]


def tested(
    one: pl.DataFrame, other: pl.DataFrame, pair: tuple[str, str], columns: Sequence[str], *by: str
) -> Iterator[dict[str, Any]]:
    """Test the spikes of two models, one of each table of trials, in each condition that both were shown.

    Parameters
    ----------
    one, other
        Tables of trials.
    pair
        The models' labels.
    columns
        Those of a condition.
    *by
        Columns whose values pair the trials of a condition; without, they are independent.

    Yields
    ------
    dict
        A row per condition; p is not corrected: see `corrected`.
    """
    keys = [*columns, *by]
    spikes = [
        trials.filter(model=model).drop_nulls(["spikes", *by])
        .group_by(keys, maintain_order=True).agg(pl.col("spikes").cast(float).alias(name))
        for trials, model, name in zip((one, other), pair, ("first", "second"), strict=True)
    ]  # fmt: skip
    shared = spikes[0].join(spikes[1], on=keys, nulls_equal=True, maintain_order="left")
    for row in shared.group_by(columns, maintain_order=True).agg(pl.col("first", "second").explode()).to_dicts():
        first, second = row.pop("first"), row.pop("second")
        test = paired(first, second) if by else contrast(first, second)
        means = sum(first) / len(first), sum(second) / len(second)
        yield {
            **row, "model": pair[0], "against": pair[1],
            "n": min(len(first), len(second)), "mean_first": means[0], "mean_second": means[1],
            "mean_difference": means[0] - means[1], "rank_biserial": test.effect, "test": test.name, "p": test.p,
        }  # fmt: skip


def corrected(rows: Sequence[dict[str, Any]], schema: Mapping[str, Any]) -> pl.DataFrame:
    """Return rows of `tested` as a table with ``p_holm``, corrected for the number of rows."""
    p_values = holm([row["p"] for row in rows])
    return table([{**row, "p_holm": p} for row, p in zip(rows, p_values, strict=True)], schema)


def first_difference(there: Run, here: Run, part: float = 0.0) -> str:
    """Return where the tables of two runs differ first: table, trial, model, column, both values; empty if nowhere.

    Columns that no two runs have alike (`UNREPEATABLE`) are left out. So are differences between floats of up to
    ``part`` of their size: of the largest that the model has in the column, or of a potential in any such column.
    """
    for name in ("trials", "frames"):
        before, after = (getattr(run, name).drop(UNREPEATABLE, strict=False) for run in (there, here))
        if before.schema != after.schema or before.height != after.height:
            return f"{name}.parquet has {before.shape} rows and columns there and {after.shape} here"
        floats = [column for column, kind in before.schema.items() if kind.is_float()]
        potentials = [column for column in floats if {*column.split("_")} & {*CHANNELS}]
        for column in before.columns:
            odd = before[column].ne_missing(after[column])
            if part and odd.any() and column in floats:
                sizes = pl.max_horizontal(pl.col(potentials if column in potentials else [column]).abs())
                slack = part * before.select(sizes.max().over("model")).to_series()
                odd &= ((before[column] - after[column]).abs() > slack).fill_null(True)
            if (row := odd.arg_max()) is not None and odd[row]:
                where = ", ".join(f"{key} {before[key][row]}" for key in ("trial", "model"))
                return f"{name}.parquet, {where}: {column} is {before[column][row]} there and {after[column][row]} here"
    return ""
