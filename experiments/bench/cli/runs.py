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
    many of its trials are finished, and how its claims came out. Imported logs are marked.
    A folder that cannot be read is named in a line.
    """
    from rich.markup import escape
    from rich.table import Table

    from experiments.bench.core.terminal import error_console, out_console
    from experiments.bench.public.listing import runs as listed

    rows = listed(folder).to_pylist()
    table = Table(box=None, header_style="bold", pad_edge=False)
    imported = any(row["provenance"] not in (None, "simulated") for row in rows)
    for name in (
        "run",
        "when",
        "seed",
        "trials",
        "models",
        "changed",
        "verdicts",
        *(["provenance"] if imported else []),
    ):
        table.add_column(name, overflow="fold", no_wrap=name == "when")
    for row in (row for row in rows if row["trouble"] is None):
        place = Path(row["run"])
        name = str(place.relative_to(folder)) if place != folder and place.is_relative_to(folder) else row["run"]
        failed = f", {row['failures']} failed" if row["failures"] else ""
        whole = row["done"] == row["planned"]
        trials = f"{row['done']}" if whole else f"[yellow]{row['done']} of {row['planned']}[/yellow]"
        table.add_row(
            escape(name), f"{row['when'].astimezone():%Y-%m-%d %H:%M}",
            f"{row['seed']}" if row["provenance"] == "simulated" else "-", f"{trials}{failed}",
            escape(row["models"]), escape(row["changed"]), row["verdicts"],
            *([escape(row["provenance"])] if imported else []),
        )  # fmt: skip
    if table.row_count:
        out_console.print(table)
    elif not rows:
        error_console.print(f"no runs in {folder}", soft_wrap=True, markup=False)
    for row in (row for row in rows if row["trouble"] is not None):
        error_console.print(f"damaged: {row['trouble']}", soft_wrap=True, markup=False)
    return 0
