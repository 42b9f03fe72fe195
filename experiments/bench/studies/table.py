"""A study on the terminal: its counts and numbers, how much of a grid a claim holds on, and further tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from experiments.bench.engine.terminal import out_console, show_line, show_places, show_table
from experiments.bench.studies.counts import (
    SIGNS,
    TOGETHER,
    ClaimCell,
    Counts,
    Number,
    by_claim,
    by_measure,
    reaches,
    regions,
)
from experiments.bench.studies.figure import row_label
from experiments.bench.studies.run import TABLE

LONG = 60
"""Letters from which a text of a further table is printed as a line of its own."""


def show(counts: Counts, folder: Path, name: str) -> None:
    """Print a study: the tables, and where everything is.

    Parameters
    ----------
    counts
        The study's result.
    folder, name
        Where its files are, and what they are called.
    """
    show_counts(counts)
    out_console.print()
    places: dict[str, object] = {"figure": folder / f"{name}.png", "table": folder / TABLE}
    if counts.failures:
        places["failures"] = folder / "failures.json"
    show_places(places)


def show_counts(counts: Counts) -> None:
    """Print the tables of a study."""
    if counts.plan.axes and all(axis.of_keys for axis in counts.plan.axes):
        _show_grids(counts)
    else:
        _show_matrix(counts)
    for title, rows in counts.tables.items():
        show_rows(title, rows)


def _show_grids(counts: Counts) -> None:
    """Print a table over the axes for each claim and measure."""
    for title, cells in by_claim(counts.cells).items():
        what = "all claims together" if cells[0].claim == TOGETHER else f"{title}, judged on {cells[0].experiment}"
        out_console.print(f"{what}: held in n of {len(cells[0].outcomes)}", markup=False, style="bold")
        show_table(_grid(counts, cells))
        out_console.print()
    for title, numbers in by_measure(counts.numbers).items():
        unit = f", {numbers[0].measure.unit}" if numbers[0].measure.unit else ""
        about = f"{title}{unit}: {numbers[0].measure.says}, in {numbers[0].experiment}"
        out_console.print(about, markup=False, style="bold")
        show_table(_grid(counts, numbers))
        out_console.print()
    directions = zip(("across", "down"), counts.plan.axes, strict=False)
    show_line("; ".join(f"{way}: {' '.join(axis.words())}" for way, axis in directions), 4)
    for line in (*regions(counts.cells), *reaches(counts.numbers)):
        out_console.print(line, markup=False)
    _show_marks(counts)
    if any(number.mark for number in counts.numbers):
        out_console.print(f"*: what the lines above say of a number; {TABLE} has it for each point", markup=False)


def _show_marks(counts: Counts) -> None:
    if any(cell.unjudged for cell in counts.cells):
        out_console.print(f"?: not judged in some replicate; {TABLE} says why", markup=False)
    for sign, words in SIGNS.items():
        if any(sign in cell.signs for cell in counts.cells):
            out_console.print(f"{sign}: {words}", markup=False)


def _grid(counts: Counts, cells: Sequence[ClaimCell] | Sequence[Number]) -> Table:
    """Return the first axis across, the second down from its highest level, as in the figure."""
    across, up = (*counts.plan.axes, None)[:2]
    assert across is not None
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in ("", *across.labels):
        table.add_column(name, justify="right")
    by_point = {cell.point.values: cell for cell in cells}
    for level in reversed(up.labels) if up else ("",):
        row = [by_point[((across.name, label), *(((up.name, level),) if up else ()))] for label in across.labels]
        table.add_row(level, *map(_marked, row))
    return table


def _show_matrix(counts: Counts) -> None:
    """Print a row for each point and model, a column for each claim."""
    plan, several = counts.plan, len({model for _, model in counts.plan.judged}) > 1
    claims = list(dict.fromkeys(cell.claim for cell in counts.cells))
    table = Table(box=None, header_style="bold", pad_edge=False, title=f"held in k of {plan.replicates} replicates")
    table.add_column(", ".join([*(axis.name for axis in plan.axes), *(["model"] if several else [])]), no_wrap=True)
    for claim in claims:
        table.add_column(claim, justify="right", no_wrap=True)
    by_place = {(cell.point, cell.model, cell.claim): cell for cell in counts.cells}
    for point, model in plan.judged:
        cells = [by_place[point, model, claim] for claim in claims]
        table.add_row(row_label(point, model if several else ""), *(_marked(cell).partition("/")[0] + _mark(cell)
                                                                    for cell in cells))  # fmt: skip
    show_table(table)
    _show_marks(counts)


def _mark(cell: ClaimCell) -> str:
    return f"{'v' if 'silent model' in cell.count.unjudged else ''}{'?' if cell.unjudged else ''}"


def _marked(cell: ClaimCell | Number) -> str:
    """Return a cell with what marks it."""
    if isinstance(cell, Number):
        return f"{cell.text()}{'*' if cell.mark else ''}"
    return f"{cell.text()}{'?' if cell.unjudged else ''}"


def show_rows(title: str, rows: Sequence[Mapping[str, Any]]) -> None:
    """Print a further table of a study; a column of long texts comes below it, a line for each row."""
    if not rows:
        return
    names = list(rows[0])
    long = [name for name in names if any(len(cell_text(row[name])) > LONG for row in rows)]
    short = [name for name in names if name not in long]
    out_console.print(f"\n{title}", markup=False, style="bold")
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in short:
        table.add_column(name, justify="left" if isinstance(rows[0][name], str) else "right")
    for row in rows:
        table.add_row(*(cell_text(row[name]) for name in short))
    show_table(table)
    for name in long:
        for row in (row for row in rows if row[name]):
            first = [cell_text(row[column]) for column in short if isinstance(row[column], str)][:2]
            show_line(f"{', '.join(first)}: {row[name]}", 4)


def cell_text(value: Any) -> str:
    """Return a value of a further table as it is shown: three digits of a number, several with commas."""
    if value is None:
        return "-"
    if isinstance(value, float):
        return f"{value:.3g}"
    if isinstance(value, list | tuple):
        return ", ".join(cell_text(item) for item in value)
    return str(value)
