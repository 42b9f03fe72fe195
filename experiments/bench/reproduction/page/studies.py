"""The studies on the page: in how many replicates each claim held at each point, and their further tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from experiments.bench.stats.count import REASONS
from experiments.bench.studies.table import cell_text

LONG = 60
"""Letters from which the texts of a column stand below the table."""


@dataclass(frozen=True, slots=True)
class Cell:
    """The count of replicates in which a claim held at one point of a study.

    Parameters
    ----------
    style
        The class of the page that has its colour.
    text
        The count; of a single replicate the word.
    detail
        The interval of the share of replicates, and why some could not be judged.
    same
        Whether the count is that of the first row.
    """

    style: str
    text: str
    detail: str
    same: bool


@dataclass(frozen=True, slots=True)
class Table:
    """A further table: the columns, the rows, and texts that are too long for a cell, each with its row's name."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    texts: tuple[tuple[str, str, str], ...]


@dataclass(frozen=True, slots=True)
class StudySection:
    """A study on the page.

    Parameters
    ----------
    name, title
        Its anchor, and what it is.
    design
        How many replicates of how many trials there are.
    row_name
        What a row is.
    claims
        The columns.
    rows
        The name of each point and model, and a cell for each claim.
    tables
        Its further tables.
    """

    name: str
    title: str
    design: str
    row_name: str
    claims: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Cell, ...]], ...]
    tables: tuple[Table, ...]


def study_section(study: Mapping[str, Any]) -> StudySection:
    """Return what the page shows of a study, from what its ``NAME.json`` holds."""
    counts = study["counts"]
    claims = tuple(dict.fromkeys(row["claim"] for row in counts))
    several = len({row["model"] for row in counts}) > 1
    by_row: dict[str, dict[str, Mapping[str, Any]]] = {}
    for row in counts:
        name = ", ".join([*row["point"].values(), *([row["model"]] if several else [])])
        by_row.setdefault(name, {})[row["claim"]] = row
    first = next(iter(by_row.values()), {})
    rows = tuple((name, tuple(_cell(row[claim], first[claim]) for claim in claims)) for name, row in by_row.items())
    repeats = "/".join(str(number) for number in dict.fromkeys(study["repeats"]))
    number = study["replicates"]
    design = f"{number} replicate{'s' if number != 1 else ''} of {repeats} repeats each, from seed {study['seed']}"
    row_name = ", ".join([*study["axes"], *(["model"] if several else [])])
    tables = tuple(_table(title, table_rows) for title, table_rows in study["tables"].items() if table_rows)
    return StudySection(study["study"], study["summary"], design, row_name, claims, rows, tables)


def _cell(row: Mapping[str, Any], first: Mapping[str, Any]) -> Cell:
    reasons = {str(reason): row[reason] for reason in REASONS if row[reason]}
    of_half = row["unknown constants"] and not row["holds"]  # the DSNN's half: where that fails the claim does
    judged = 0 if of_half else row["holds"] + row["fails"]
    same = all(row[name] == first[name] for name in ("holds", "fails", *REASONS))
    word = row["word"] or _only(row, reasons)
    if row["replicates"] == 1:
        return Cell(_style(word), word, "", same)
    interval = "" if row["low"] is None else f"{100 * row['low']:.0f} to {100 * row['high']:.0f} %"
    detail = "; ".join([interval, *(f"{reason} in {number}" for reason, number in reasons.items())]).removeprefix("; ")
    return Cell(_style(word), f"{row['holds']} of {judged}" if judged else "not judged", detail, same)


def _style(word: str) -> str:
    """The class of the page that has a cell's colour: without a word there are just counts."""
    return word if word in ("holds", "fails", "sometimes") else "unjudged" if word else "counted"


def _only(row: Mapping[str, Any], reasons: Mapping[str, int]) -> str:
    """Return the outcome of a claim in all replicates, in a word; empty where they differ."""
    words = [word for word in ("holds", "fails") if row[word]] + list(reasons)
    return words[0] if len(words) == 1 else ""


def _table(title: str, rows: list[Mapping[str, Any]]) -> Table:
    names = list(rows[0])
    long = [name for name in names if any(len(cell_text(row[name])) > LONG for row in rows)]
    short = [name for name in names if name not in long]

    def called(row: Mapping[str, Any]) -> str:
        return ", ".join([row[name] for name in short if isinstance(row[name], str)][:2])

    texts = tuple((called(row), name, row[name]) for row in rows for name in long if row[name])
    return Table(title, tuple(short), tuple(tuple(cell_text(row[name]) for name in short) for row in rows), texts)
