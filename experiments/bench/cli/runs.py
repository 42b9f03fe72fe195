"""The command ``colias runs``. Heavy imports happen when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="List the runs in a folder: when, what, seed, changed parameters, verdicts.")(runs)


def runs(folder: Annotated[Path, typer.Argument(help="Where runs are.")] = Path("runs")) -> int:
    """List the runs in a folder, oldest first, down to the parts of sweeps and reproductions.

    For each: when it was begun, its experiment, seed and models, the parameters that are not at their defaults, how
    many of its trials are finished, how its claims came out, and the commit it was begun with. Imported logs are
    marked. A run of another version is named in a line, with the version that reads it.
    """
    from rich.table import Table
    from rich.text import Text

    from experiments.bench.engine.terminal import error_console, show_table
    from experiments.bench.public.listing import runs as listed

    rows = listed(folder).to_dicts()
    table = Table(box=None, header_style="bold", pad_edge=False)
    imported = any(row["provenance"] not in (None, "simulated") for row in rows)
    columns = ("run", "begun", "experiment", "seed", "trials", "models", "changed", "verdicts", "commit")
    for name in (*columns, *(["provenance"] if imported else [])):
        table.add_column(name, no_wrap=name == "begun")
    for row in (row for row in rows if row["trouble"] is None):
        place = Path(row["run"])
        name = str(place.relative_to(folder)) if place != folder and place.is_relative_to(folder) else row["run"]
        failed = f", {row['failures']} failed" if row["failures"] else ""
        whole = row["done"] == row["planned"]
        trials = f"{row['done']}" if whole else Text(f"{row['done']} of {row['planned']}", "yellow")
        begun = f"{row['when'].astimezone():%Y-%m-%d %H:%M}"
        table.add_row(
            name, begun, row["experiment"], "-" if row["seed"] is None else f"{row['seed']}",
            Text.assemble(trials, failed), row["models"], row["changed"], row["verdicts"], row["commit"] or "-",
            *([row["provenance"]] if imported else []),
        )  # fmt: skip
    if table.row_count:
        show_table(table)
    elif not rows:
        error_console.print(f"no runs in {folder}", soft_wrap=True, markup=False)
    for row in (row for row in rows if row["trouble"] is not None):
        error_console.print(f"{row['trouble']}", soft_wrap=True, markup=False)
    return 0
