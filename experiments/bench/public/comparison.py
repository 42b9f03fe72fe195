"""Differences of two runs: in their parameters, and in what models answered on equal trials."""

from __future__ import annotations

import html
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import Any

import polars as pl

from experiments.bench.public.result import Run, load
from experiments.bench.run.models import family
from experiments.bench.sources.clips import SHOWN, TRIALS
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.rows import TRIAL_SCHEMA
from experiments.bench.stats.tests import Test, contrast, holm, paired
from experiments.bench.store import provenance
from experiments.bench.store.description import BEGUN, COMMAND, ENDED, KIND, LONGEST, RESUMED, THRESHOLDS
from experiments.bench.store.kinds import CLIPS
from experiments.bench.store.rows import group, table

CLIP_COLUMNS = ("stimulus", "clip", *SHOWN)
PARAMETER_SCHEMA = pl.Schema(dict.fromkeys(("parameter", "first", "second"), str))
_TESTED = pl.Schema({
    "model": str, "against": str, "n": int, "mean_first": float, "mean_second": float, "mean_difference": float,
    "rank_biserial": float, "test": str, "p": float, "p_holm": float,
})  # fmt: skip

_SHOWN = ("n", "mean_first", "mean_second", "mean_difference", "rank_biserial", "p_holm")
"""Columns of the results that are printed, beside the model and the conditions that differ."""

Rows = Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class Comparison:
    """Differences of two runs.

    Attributes
    ----------
    first, second
        The runs.
    parameters
        A row per parameter that differs: ``parameter``, as ``--set`` names it, and its value in ``first`` and
        ``second``, as JSON; null where a run has none.
    results
        A row per model and condition that both runs have trials of: ``n`` equal trials (the same seed and condition),
        ``mean_first`` and ``mean_second`` spikes a trial, ``mean_difference`` (the first less the second), the
        rank-biserial correlation, and Wilcoxon's signed-rank test; ``p_holm`` is corrected for the number of rows.
        Where a run was imported from a log and no seeds pair its trials, those of a condition are independent: the
        test is Mann-Whitney's, ``rank_biserial`` is Cliff's delta, and ``n`` is the smaller number of trials.
    note
        Why there are no results; empty where there are.
    code
        What computed the second run (``now``) otherwise than the first (``there``), in words; empty if nothing that
        numbers depend on.
    """

    first: Run
    second: Run
    parameters: pl.DataFrame
    results: pl.DataFrame
    note: str = ""
    code: str = ""

    def __repr__(self) -> str:
        count = f"{self.parameters.height} parameters differ"
        result = self.note or f"{self.results.height} paired tests"
        return f"<Comparison {self.first.folder} with {self.second.folder}: {count}; {result}>"

    def __str__(self) -> str:
        conditions = self.results.columns[: self.results.columns.index("model")] if self.results.height else []
        varied = [name for name in conditions if self.results[name].n_unique() > 1]
        numbers = self.results.select(*varied, *(["model", *_SHOWN] if self.results.height else []))
        with pl.Config(tbl_rows=-1, tbl_cols=-1, tbl_width_chars=200, fmt_str_lengths=40, tbl_formatting="MARKDOWN",
                       tbl_hide_dataframe_shape=True, tbl_hide_column_data_types=True):  # fmt: skip
            return "\n".join([repr(self), *(str(shown) for shown in (self.parameters, numbers) if shown.height)])

    def _repr_html_(self) -> str:
        parts = [f"<p>{html.escape(repr(self)[1:-1])}</p>"]
        for shown in (self.parameters, self.results):
            rows = [shown.columns, *shown.rows()]
            cells = ("".join(f"<td>{html.escape(_said(cell))}</td>" for cell in row) for row in rows)
            parts.append(f"<table>{''.join(f'<tr>{row}</tr>' for row in cells)}</table>")
        return "".join(parts)


def _said(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def compare(first: Run | str | os.PathLike[str], second: Run | str | os.PathLike[str]) -> Comparison:
    """Say how two runs differ in their parameters and, on equal trials, in their spikes.

    Equal trials have the same seed and the same condition: runs of one experiment and one seed under other settings
    have them all. Models are paired by label; where the runs share none and each has one model, these two are paired.

    Parameters
    ----------
    first, second
        Runs, or their folders.

    Returns
    -------
    Comparison
        The parameters that differ, and a paired test for each model and condition that both have.

    Raises
    ------
    UsageError
        A folder holds no run, or its tables cannot be read.

    Examples
    --------
    >>> from experiments import compare, run
    >>> usual, changed = run("speed"), run("speed", settings={"dsnn.n_con": 6})
    >>> compare(usual, changed).results
    """
    one, other = (run if isinstance(run, Run) else load(run) for run in (first, second))
    differing = [
        {"parameter": name, "first": _json(here), "second": _json(there)}
        for name, here, there in _parameters(one, other)
    ]
    columns, kinds = (CLIP_COLUMNS, TRIALS) if one.kind is CLIPS else (CONDITION_COLUMNS, TRIAL_SCHEMA)
    results, note = _results(one, other, columns)
    schema = pl.Schema({name: kinds[name] for name in columns}) | _TESTED
    differences, tests = table(differing, PARAMETER_SCHEMA), table(results, schema)
    return Comparison(one, other, differences, tests, note, _code(one, other))


def _json(value: Any) -> str | None:
    text = None if value is None else json.dumps(value)
    return text if text is None or len(text) <= LONGEST else f"{text[:LONGEST]}..."


def _code(one: Run, other: Run) -> str:
    try:
        return provenance.difference(one.description, other.description)
    except (KeyError, TypeError):
        return ""


def _parameters(one: Run, other: Run) -> Iterator[tuple[str, Any, Any]]:
    """Name and both values of every parameter that differs."""
    here, there = (dict(_flat(_plain(run.description))) for run in (one, other))
    if one.models != other.models:
        yield "models", one.models, other.models
    for a, b in _pairs(one, other):
        networks = [_networks(run).get(label, {}) for run, label in ((one, a), (other, b))]
        name = a if a == b else family(a) if family(a) == family(b) else f"{a} | {b}"
        here |= {f"{name}.{key}": value for key, value in networks[0].items()}
        there |= {f"{name}.{key}": value for key, value in networks[1].items()}
    for name in [*here, *(name for name in there if name not in here)]:
        if here.get(name) != there.get(name):
            yield name, here.get(name), there.get(name)


def _plain(description: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of a run but its models', named as ``--set`` names them."""
    aside = (*provenance.KEYS, KIND, BEGUN, ENDED, COMMAND, RESUMED, THRESHOLDS, "changed", "trials", "models")
    left = {key: value for key, value in description.items() if key not in aside}
    if "measured" in left:
        left.pop("seed", None)  # an imported log has none
    declared = left.pop("experiment", {})
    settings = left.pop("settings", {})
    if isinstance(settings, Mapping):
        left |= {name: value for name, value in settings.items() if isinstance(value, Mapping)}
    else:
        left["settings"] = settings
    if not isinstance(declared, Mapping):
        return {"experiment": declared, **left}
    entry = {name: declared.get(name) for name in ("name", "varies") if name in declared}
    claims = declared.get("claims")
    if isinstance(claims, list):
        entry["claims"] = [claim.get("id") if isinstance(claim, Mapping) else claim for claim in claims]
    design = declared.get("design")
    return {"experiment": {**entry, **(design if isinstance(design, Mapping) else {})}, **left}


def _flat(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for name, item in value.items():
            yield from _flat(item, f"{path}.{name}".lstrip("."))
    elif isinstance(value, list) and any(isinstance(item, Mapping | list) for item in value):
        for index, item in enumerate(value):
            yield from _flat(item, f"{path}[{index}]")
    else:
        yield path, value


def _networks(run: Run) -> dict[str, dict[str, Any]]:
    """Label of a model -> its source and parameters."""
    settings = run.description.get("settings")
    listed = run.description.get("models") or (settings.get("models", ()) if isinstance(settings, Mapping) else ())
    return {
        model["label"]: {"source": model.get("source"), **model["network"]} for model in listed
        if isinstance(model.get("network"), Mapping)
    }  # fmt: skip


def _pairs(one: Run, other: Run) -> list[tuple[str, str]]:
    """Labels of the models that belong together, of the first run and of the second."""
    both = [(label, label) for label in one.models if label in other.models]
    return both or (list(zip_longest(one.models, other.models)) if len(one.models) == len(other.models) == 1 else [])


def _results(one: Run, other: Run, columns: Sequence[str]) -> tuple[list[dict[str, Any]], str]:
    """Return a row per model and condition, and why there are none."""
    for run in (one, other):
        if not run.kind.robot and run.kind is not CLIPS:
            return [], f"nothing to pair: {run.folder} is of {run.kind.what}, which no trials pair"
    if not (one.done and other.done):
        return [], f"nothing to pair: {(other if one.done else one).folder} has no finished trial"
    tables = [run.trials for run in (one, other)]
    needed = {"model", "seed", "spikes", *columns[:2]}
    for run, trials in zip((one, other), tables, strict=True):
        lacking = sorted(needed - {*trials.columns})
        if lacking:
            kinds = f"{one.name} and {other.name}" if one.name != other.name else one.name
            return [], f"nothing to pair: {run.folder} has no column {lacking[0]} ({kinds})"
    columns = [name for name in columns if all(name in trials.columns for trials in tables)]
    needed |= set(columns)
    pairs = _pairs(one, other)
    if not pairs:
        labels = f"{', '.join(one.models)} and {', '.join(other.models)}"
        return [], f"nothing to pair: the runs share no model, and have more than one ({labels})"
    rows = [trials.select(sorted(needed)).to_dicts() for trials in tables]
    results = [row for pair in pairs for row in _of_models(rows[0], rows[1], pair, columns)]
    if not results and {one.provenance, other.provenance} != {"simulated"}:
        results = [row for pair in pairs for row in _independent(rows[0], rows[1], pair, columns)]
    if not results:
        silent = [
            run.folder
            for run, run_rows in zip((one, other), rows, strict=True)
            if all(r["spikes"] is None for r in run_rows)
        ]
        if silent:
            return [], f"nothing to pair: no model of {silent[0]} spikes"
        known = one.seed is not None and other.seed is not None
        why = f": the seeds are {one.seed} and {other.seed}" if known and one.seed != other.seed else ""
        return [], f"nothing to pair: no trial of the one has the seed and condition of one of the other{why}"
    for row, p in zip(results, holm([row["p"] for row in results]), strict=True):
        row["p_holm"] = p
    return results, ""


def _of_models(one: Rows, other: Rows, pair: tuple[str, str], columns: Sequence[str]) -> Iterator[dict[str, Any]]:
    """Yield a row per condition that two models, one of each run, were both shown at the same seeds."""
    matching = {(row["seed"], *(row[name] for name in columns)): row["spikes"] for row in other
                if row["model"] == pair[1] and row["seed"] is not None}  # fmt: skip
    for condition, trials in group([row for row in one if row["model"] == pair[0]], *columns).items():
        both = [
            (row["spikes"], matching[key]) for row in trials if (key := (row["seed"], *condition)) in matching
            and row["spikes"] is not None and matching[key] is not None
        ]  # fmt: skip
        if not both:
            continue
        first, second = ([float(spikes[i]) for spikes in both] for i in (0, 1))
        yield _tested(condition, columns, pair, first, second, len(both), paired(first, second))


def _independent(one: Rows, other: Rows, pair: tuple[str, str], columns: Sequence[str]) -> Iterator[dict[str, Any]]:
    """Yield a row per condition that two models, one of each run, were both shown, in trials that nothing pairs."""
    theirs = group([row for row in other if row["model"] == pair[1]], *columns)
    for condition, ours in group([row for row in one if row["model"] == pair[0]], *columns).items():
        first, second = ([float(row["spikes"]) for row in rows if row["spikes"] is not None]
                         for rows in (ours, theirs.get(condition, ())))  # fmt: skip
        if first and second:
            n = min(len(first), len(second))
            yield _tested(condition, columns, pair, first, second, n, contrast(first, second))


def _tested(
    condition: Sequence[Any], columns: Sequence[str], pair: tuple[str, str], first: Sequence[float],
    second: Sequence[float], n: int, test: Test,
) -> dict[str, Any]:  # fmt: skip
    """Return the row of one test."""
    means = sum(first) / len(first), sum(second) / len(second)
    return {
        **dict(zip(columns, condition, strict=True)), "model": pair[0], "against": pair[1], "n": n,
        "mean_first": means[0], "mean_second": means[1], "mean_difference": means[0] - means[1],
        "rank_biserial": test.effect, "test": test.name, "p": test.p,
    }  # fmt: skip
