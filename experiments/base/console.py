"""Output of commands: the two consoles, progress with the time left, verdicts, and where results are.

The time left is estimated from a run's own first jobs, on this machine.
"""

from __future__ import annotations

import os
import shlex
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.progress import BarColumn, Progress
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    import polars as pl

BEGAN = time.monotonic()
"""When the command began, nearly."""
LINE_EVERY_S = 60.0
"""Seconds between lines of progress where there is no terminal to draw a bar on."""


_environ = {name: value for name, value in os.environ.items() if name != "COLUMNS" or value.strip("0")}
"""Some terminals and pipelines set COLUMNS to 0, where they do not know it: to Rich no letter then has a place."""
out_console, error_console = (
    Console(stderr=stderr, soft_wrap=True, highlight=False, emoji=False, markup=False, _environ=_environ)
    for stderr in (False, True)
)
"""They print texts as they are: the terminal breaks lines, and brackets are no markup."""


def count(number: int, thing: str) -> str:
    """Return ``1 trial``, ``2 trials``."""
    return f"{number} {thing}{'s' * (number != 1)}"


def show(rows: pl.DataFrame, title: str = "") -> None:
    """Print a table below its title: numbers right of texts, large ones with separators, blank what is null.

    Words stay whole, also where the terminal is too narrow for the table.
    """
    if title:
        out_console.print(Text(title, "italic"))
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name, kind in rows.schema.items():
        table.add_column(name, justify="right" if kind.is_numeric() else "left")
    for row in rows.rows():
        table.add_row(*(cell if isinstance(cell, Text) else _text(cell) for cell in row))
    for column in table.columns:
        words = " ".join(map(str, (column.header, *column.cells))).split()
        column.min_width = max(map(len, words))
    out_console.print(table)


def _text(cell: object) -> str:
    if isinstance(cell, float) and abs(cell) < 1000.0:
        return f"{cell:.3g}"
    if isinstance(cell, list | tuple):
        return ", ".join(map(_text, cell))
    return "" if cell is None else f"{cell:,.0f}" if isinstance(cell, int | float) else str(cell)


def print_troubles(judged: Iterable[tuple[str, str]]) -> bool:
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
        error_console.print(line)
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
    out_console.print(f"{done} in {time.monotonic() - BEGAN:.0f} s, in {folder}: {', '.join(names)}")


def show_places(places: Mapping[str, object]) -> None:
    """Print where results are: a line for each name and path."""
    for name, place in places.items():
        out_console.print(f"{name:<12}{place}")


@contextmanager
def progress(name: str, total: int, quiet: bool, things: str = "trials") -> Iterator[Callable[[], None]]:
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

    Yields
    ------
    callable
        To be called after each job.
    """
    bar = Progress("{task.description}", BarColumn(), "{task.fields[left]}", console=error_console, transient=True,
                   disable=quiet or not error_console.is_terminal)  # fmt: skip
    began_s = shown_s = time.monotonic()
    done = 0
    with bar:
        task = bar.add_task(f"{name}: {things}", total=total, left="")

        def advance() -> None:
            nonlocal done, shown_s
            done, now_s = done + 1, time.monotonic()
            left_min = (total - done) * (now_s - began_s) / done / 60.0
            left = f"{done} of {total}, about {left_min:.1f} min left"
            bar.update(task, advance=1, left=left)
            if bar.disable and not quiet and done < total and now_s - shown_s > LINE_EVERY_S:
                shown_s = now_s
                error_console.print(f"{name}: {things}: {left}")

        yield advance
