"""The command ``colias leaderboard``. Like `cli`, it imports what is heavy when it runs."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.options import Cluster, Models, Only, OtherCode, Quiet, Seed, Workers, worker_count


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Rank the models, and yours, on the same trials and clips.")(leaderboard)


def leaderboard(
    model: Models = None,
    only: Only = False,
    repeats: Annotated[int | None, typer.Option(help="Trials of each condition; otherwise 5.")] = None,
    seed: Seed = 0,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of the results, otherwise runs/leaderboard-TIME; goes on with one begun."),
    ] = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    quiet: Quiet = False,
) -> int:
    """Show every model the same robot trials and the same clips, time them in turns, and rank them.

    90 robot trials: crossings both ways at 4, 6, 10 cm/s and 6, 10 cm, straight approach and recession at these
    speeds. 24 clips on an even ground, 60 before clutter and 20 of clutter alone (shifting, swaying, trembling).
    Writes leaderboard.csv, figure.svg and .png, and a folder of tables for each kind. Every number has its 95 %
    interval. The command's own models are those registered, but dsnn-reference. Exit status: 1 if trials failed; the
    others count.
    """
    from experiments.bench import console, console_leaderboard
    from experiments.bench import leaderboard as board
    from experiments.bench.model_option import COMPARED, shown_models

    stamp = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    folder = out or Path("runs") / f"leaderboard-{stamp}"
    means = console.Means(worker_count(workers), cluster, quiet, other_code)
    result = board.leaderboard(folder, shown_models(COMPARED, model, only), repeats, seed, means)
    if not quiet:
        console_leaderboard.show(result)
    return 1 if result.failures else 0
