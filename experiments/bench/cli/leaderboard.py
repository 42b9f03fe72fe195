"""The command ``colias leaderboard``. It imports what is heavy when it runs."""

from __future__ import annotations

from typing import Annotated

import typer

from experiments.bench.cli.options import (
    EXIT_FAILED,
    Cluster,
    For,
    Models,
    Only,
    OtherCode,
    Out,
    Quiet,
    Seed,
    Workers,
    resources,
    run_folder,
)
from experiments.bench.figures.media import Medium


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Rank the models, and yours, on the same trials and clips.")(leaderboard)


def leaderboard(
    model: Models = None,
    only: Only = False,
    repeats: Annotated[int | None, typer.Option(help="Trials of each condition; otherwise 5.")] = None,
    seed: Seed = 0,
    out: Out = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    medium: For = Medium.WEB,
    quiet: Quiet = False,
) -> int:
    """Show every model the same robot trials and the clips of its kind, time them in turns, and rank them.

    90 robot trials: crossings both ways at 4, 6, 10 cm/s and 6, 10 cm, straight approach and recession at these
    speeds. To models that answer by direction 24 clips on an even ground, 60 before clutter and 20 of clutter alone
    (shifting, swaying, trembling). To looming models 48 clips on an even ground and 160 before what moves: looming,
    receding, crossing, and gratings and backgrounds alone. The two kinds are ranked apart. Writes leaderboard.csv and
    figure.svg and .png of direction, looming.csv, looming.svg and .png, and a folder of tables for each set of clips.
    Every number has its 95 % interval. The command's own models are those registered, but dsnn-reference. Exit status:
    1 if trials failed; the others count.
    """
    from experiments.bench.leaderboard import run as board
    from experiments.bench.leaderboard import table as leaderboard_table
    from experiments.bench.run.models import COMPARED, shown_models

    folder = run_folder(out, "leaderboard")
    means = resources(workers, cluster, quiet, other_code)
    models = shown_models(COMPARED, model, only)
    result = board.run(folder, models, repeats, seed, means)
    if not quiet:
        leaderboard_table.show(result)
    return EXIT_FAILED if result.failures else 0
