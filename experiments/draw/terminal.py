"""What commands print of runs: verdicts, silent models, and where everything is."""

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import polars as pl
from rich.text import Text

from experiments.base import console, palette
from experiments.judge.controls import MEANS
from experiments.judge.verdict import Count, Verdict
from experiments.store.tables import PEAKS

SIGNS: Mapping[str, str] = {state: sign for state, (*_, sign) in palette.VERDICTS.items()}
"""State of a verdict, as colours have it -> the sign that stands before it: colour alone tells no verdict."""


def seen_as(count: Count) -> str:
    """Return the state whose sign and colour a count has: without a word, whether it held in all, some or none."""
    if count.state != "counted":
        return count.state
    return "sometimes" if count.holds and count.fails else "holds" if count.holds else "fails"


def not_run(verdicts: Iterable[Verdict]) -> str:
    """Return the claims for which what they need was not run or shown, each reason once: ``C1, C2 (reason)``."""
    reasons: dict[str, list[str]] = {}
    for verdict in filter(is_unshown, verdicts):
        reasons.setdefault(verdict.outcome.deciding, []).append(verdict.id)
    return "; ".join(f"{', '.join(dict.fromkeys(names))} ({why})" for why, names in reasons.items())


def is_unshown(verdict: Verdict) -> bool:
    """Return whether a claim was not judged in any replicate, for want of what it needs."""
    return not verdict.count.judged and verdict.outcome.verdict == "not shown"


def show_verdicts(verdicts: Sequence[Verdict], *, model: bool = False, provenance: str = "") -> None:
    """Print verdicts as a table: the claim, in how many replicates it held, the number that decided, what it needs.

    A sentence follows for each that did not hold, and one line for all that were not run. The rest is in
    ``claims.json``.

    Parameters
    ----------
    verdicts
        The verdicts.
    model
        Whether to name the model that each is about.
    provenance
        Where the trials come from; empty where they are simulated.
    """
    rows, sentences = [], []
    for verdict in verdicts:
        if is_unshown(verdict):
            continue
        state, word = seen_as(verdict.count), re.split(" replicate|[;,]", verdict.count.sentence())[0]
        sign = Text(f"{SIGNS[state]} {word}", palette.VERDICTS[state][2])
        name = f"{verdict.id} ({verdict.model})" if model and verdict.model else verdict.id
        rows.append((f"{name} {verdict.title}".rstrip(), sign, *verdict.numbers))
        text = f"{verdict.title or verdict.says}; {verdict.outcome.deciding}" * (state != "holds")
        if verdict.equal is not None and verdict.outcome.equal is not None:
            text += f"; on equal terms {verdict.equal.sentence()}: {verdict.outcome.equal.deciding}"
        if text:
            sentences.append(Text.assemble((name, "b"), f" {word}: {text.removeprefix('; ')}"))
    if rows:
        names = ["claim", "verdict", "number", "what it needs"]
        console.show(pl.DataFrame(rows, names, orient="row"), provenance)
    for line in sentences:
        console.out_console.print(line)
    if missing := not_run(verdicts):
        console.out_console.print(f"not judged: {missing}")


def show_silent(rows: Iterable[Mapping[str, Any]]) -> None:
    """Print which models are silent: whose potentials are 0 in all rows, and how dark and bright their frames were."""
    by_model: dict[str, list[Mapping[str, Any]]] = {}
    for row in rows:
        by_model.setdefault(row["model"], []).append(row)
    for model, seen in sorted(by_model.items()):
        if not any(row.get(end) for row in seen for end in (*PEAKS, "peak_target")):
            greys = [row[end] for row in seen for end in ("darkest", "brightest") if row.get(end) is not None]
            range_of = f"; its frames had grey levels from {min(greys)} to {max(greys)}" if greys else ""
            console.out_console.print(f"{model} is silent: all its potentials are 0{range_of}")


def show_controls(table: pl.DataFrame) -> None:
    """Print the table of a run's controls, if it has one."""
    if table.height:
        columns = ("model", "response", "word", "n", *MEANS, "p")
        known = [name for name in columns if table[name].null_count() < table.height]
        console.show(table.select(known), "\nis it vision? trials and their controls")
        for row in table.drop_nulls("says").iter_rows(named=True):
            console.out_console.print(f"{row['model']}, {row['response']}: {row['word']} ({row['says']})")
