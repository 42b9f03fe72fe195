"""Output of commands: the two consoles, progress with the time left, verdicts, and where results are.

The time left is estimated from a run's own first jobs, on this machine.
"""

from __future__ import annotations

import os
import re
import shlex
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

from rich.cells import cell_len
from rich.console import Console
from rich.measure import Measurement
from rich.progress import BarColumn, Progress, TextColumn
from rich.table import Table
from rich.text import Text

from experiments.bench.stats.count import Count, Kind
from experiments.bench.stats.verdict import Verdict

if TYPE_CHECKING:
    import polars as pl

BEGAN = time.monotonic()
"""When the command began, nearly."""
LINE_EVERY_S = 60.0
"""Seconds between lines of progress where there is no terminal to draw a bar on."""
MINUTES_FROM_S = 150.0

PIPE_WIDTH = 100
"""Columns of tables and sentences where there is no terminal, and ``COLUMNS`` does not say how many there are."""
INDENT = 4
"""Columns by which the other lines of a verdict are moved in."""


class _Console(Console):
    """Prints texts as they are: brackets in them are no markup. What has a style is a `rich.text.Text`."""

    def __init__(self, *, stderr: bool = False) -> None:
        stream = sys.stderr if stderr else sys.stdout
        known = "COLUMNS" in os.environ or (stream is not None and stream.isatty())
        width = None if known else PIPE_WIDTH
        super().__init__(stderr=stderr, highlight=False, emoji=False, markup=False, width=width)


out_console = _Console()
error_console = _Console(stderr=True)

VERDICT_COLOURS: Mapping[Kind, str] = {
    "holds": "green",
    "fails": "red",
    "sometimes": "yellow",
    "counted": "cyan",
    "unjudged": "yellow",
}


def count(number: int, thing: str) -> str:
    """Return ``1 trial``, ``2 trials``."""
    return f"{number} {thing}{'s' * (number != 1)}"


def coloured(count: Count) -> Text:
    """Return a claim's word, or its count without one, in its colour."""
    return Text(count.label, VERDICT_COLOURS[count.kind])


def show_line(line: str | Text, indent: int = 0) -> None:
    """Print a line, broken between words; its other lines begin ``indent`` to the right."""
    line = Text(line) if isinstance(line, str) else line
    starts, room = [0], out_console.width
    for word in re.finditer(r"\S+", line.plain):
        before = line.plain[starts[-1] : word.start()]
        if before.strip() and cell_len(before) + cell_len(word[0]) > room:
            starts.append(word.start())
            room = out_console.width - indent
    for place, (start, end) in enumerate(pairwise([*starts, len(line)])):
        part = line[start:end]
        part.rstrip()
        out_console.print(Text.assemble(" " * indent if place else "", part), soft_wrap=True)


def show_table(table: Table) -> None:
    """Print a table below its title; its words stay whole, also where the terminal is too narrow for it."""
    if table.title:
        show_line(Text(str(table.title), "italic"))
        table.title = None
    for column in table.columns:
        cells = (column.header, *column.cells)
        column.min_width = max(Measurement.get(out_console, out_console.options, cell).minimum for cell in cells)
    out_console.print(table, crop=False)


def show(rows: pl.DataFrame, title: str = "") -> None:
    """Print a table: numbers right of texts, large ones with separators, blank what is null."""
    table = Table(title=title or None, title_justify="left", box=None, header_style="bold", pad_edge=False)
    for name, kind in rows.schema.items():
        table.add_column(name, justify="right" if kind.is_numeric() else "left")
    for row in rows.rows():
        table.add_row(*map(_text, row))
    show_table(table)


def _text(cell: object) -> str:
    if isinstance(cell, float) and abs(cell) < 1000.0:
        return f"{cell:.3g}"
    if isinstance(cell, list | tuple):
        return ", ".join(map(_text, cell))
    return "" if cell is None else f"{cell:,.0f}" if isinstance(cell, int | float) else str(cell)


def show_verdicts(verdicts: Iterable[Verdict], *, model: bool, provenance: str = "") -> None:
    """Print verdicts, a sentence each; those on too few trials together, with the option that helps.

    Parameters
    ----------
    verdicts
        The verdicts.
    model, provenance
        As of `show_verdict`.
    """
    skipped: dict[str, int] = {}
    for verdict in verdicts:
        if verdict.outcome.least:
            skipped[verdict.id] = verdict.outcome.least
        else:
            show_verdict(verdict, model=model, provenance=provenance)
    if skipped:
        names, most = ", ".join(skipped), max(skipped.values())
        show_line(f"{count(len(skipped), 'claim')} skipped ({names}): need --repeats {most} or more", INDENT)


def show_verdict(verdict: Verdict, *, model: bool, provenance: str = "") -> None:
    """Print a verdict as one sentence: the claim, in how many replicates it held, and the number that decided.

    What else was measured stands in ``claims.json``.

    Parameters
    ----------
    verdict
        The verdict.
    model
        Whether to name the model that it is about.
    provenance
        Where the trials come from; empty where they are simulated.
    """
    from experiments.bench.stats.claim import title_of  # not before: it loads every claim

    who = f" ({verdict.model})" if model and verdict.model else ""
    count, origin = verdict.count, f" [{provenance}]" if provenance else ""
    label, sentence = coloured(count), count.sentence()
    if count.kind == "counted":
        label.plain, held = sentence, ""
    else:
        held = f" ({re.sub('^(held|failed|not judged)[;,] ', '', sentence)})"
    first = "replicate 0: " if count.replicates > 1 else ""
    told = [title_of(verdict), f"{first}{verdict.outcome.deciding}"]
    if verdict.equal is not None and verdict.outcome.equal is not None:
        told.append(f"on equal terms {verdict.equal.sentence()}: {verdict.outcome.equal.deciding}")
    line = Text.assemble((verdict.id, "b"), f"{who} ", label, held, origin, f": {'; '.join(told)}")
    show_line(line, INDENT)


def tell_troubles(judged: Iterable[tuple[str, str]]) -> bool:
    """Print a line for each claim whose judge, a user's own, went wrong.

    Parameters
    ----------
    judged
        The claims' ids, and what went wrong; empty where nothing did.

    Returns
    -------
    bool
        Whether one did.
    """
    lines = dict.fromkeys(f"claim {claim}: {trouble}" for claim, trouble in judged if trouble)
    for line in lines:
        error_console.print(line, soft_wrap=True, markup=False)
    return bool(lines)


def show_files(folder: Path, done: str) -> None:
    """Print the command that shows a run's recordings, then what was done, in what time, and the files of its folder.

    Parameters
    ----------
    folder
        Of the run.
    done
        What was done: ``4 trials``.
    """
    if any(folder.glob("recordings/*.rrd")):
        show_places({"recordings": f"colias view {shlex.quote(str(folder))}"})
    names = sorted(path.name for path in folder.iterdir() if path.suffix and not path.name.startswith("."))
    out_console.print(f"{done} in {time.monotonic() - BEGAN:.0f} s, in {folder}: {', '.join(names)}", soft_wrap=True)


def show_places(places: Mapping[str, object]) -> None:
    """Print where results are: a line for each name and path."""
    for name, place in places.items():
        out_console.print(f"{name:<12}{place}", soft_wrap=True, markup=False)


@contextmanager
def progress(
    name: str, total: int, quiet: bool, things: str = "trials", *, whole: float | None = None
) -> Iterator[Callable[..., None]]:
    """Show how far ``total`` jobs have got, and the time left.

    On a terminal that is a bar, elsewhere a line a minute.

    Parameters
    ----------
    name, things
        What is done, and what its jobs are called.
    total
        Number of jobs.
    quiet
        Whether to show nothing.
    whole
        Sum of the jobs' sizes, in any unit; otherwise all jobs count alike.

    Yields
    ------
    callable
        To be called with the size of each job that is finished, 1 by default.
    """
    size = float(total if whole is None else whole)
    bars = BarColumn(complete_style="cyan", finished_style="green", pulse_style="cyan")
    columns = (TextColumn("{task.description}", markup=False), bars, TextColumn("{task.fields[left]}"))
    bar = Progress(*columns, console=error_console, transient=True, disable=quiet or not error_console.is_terminal)
    began_s = shown_s = time.monotonic()
    done, amount = 0, 0.0
    with bar:
        task = bar.add_task(f"{name}: {things}", total=size, left="")

        def advance(more: float = 1.0) -> None:
            nonlocal done, amount, shown_s
            done, amount, now_s = done + 1, amount + more, time.monotonic()
            left_s = max(size - amount, 0.0) * (now_s - began_s) / amount
            left = f"about {left_s:.0f} s left" if left_s < MINUTES_FROM_S else f"about {left_s / 60:.0f} min left"
            bar.update(task, advance=more, left=f"{done} of {total}, {left}")
            if bar.disable and not quiet and done < total and now_s - shown_s > LINE_EVERY_S:
                shown_s = now_s
                error_console.print(f"{done} of {total} {things}, {left}", markup=False)

        yield advance
