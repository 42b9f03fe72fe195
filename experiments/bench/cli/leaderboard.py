"""The command ``colias leaderboard``. It imports what is heavy when it runs."""

from __future__ import annotations

from typing import Annotated

import typer

from experiments.bench.cli import options


def leaderboard(
    model: options.Models = None,
    only: options.Only = False,
    repeats: Annotated[int | None, typer.Option(help="Trials of each condition; otherwise 5.")] = None,
    seed: options.Seed = 0,
    out: options.Out = None,
    other_code: options.OtherCode = False,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    medium: options.For = "web",
    quiet: options.Quiet = False,
) -> int:
    """Show every model the same robot trials and the clips of its kind, time them in turns, and rank them.

    90 robot trials: crossings both ways at 4, 6, 10 cm/s and 6, 10 cm, straight approach and recession at these
    speeds. Models of direction are shown 24 clips on an even ground, 60 before clutter and 20 of clutter alone
    (shifting, swaying, trembling), looming models 48 clips on an even ground and 160 before what moves: looming,
    receding, crossing, and gratings and backgrounds alone. The two kinds are ranked apart: leaderboard.csv and
    looming.csv have the scores with their 95 % intervals, and figures of the same names show them. A folder for each
    set of clips has the tables. The command's own models are those registered, but dsnn-reference. Exit status: 1 if
    trials failed; the others count.
    """
    from experiments.bench import leaderboard as board
    from experiments.bench.report import scoreboard
    from experiments.bench.report.terminal import show_line, show_places
    from experiments.bench.run.models import COMPARED, shown_models

    planned = board.plan(shown_models(COMPARED, model, only), repeats, seed)
    folder = options.run_folder(out, "leaderboard")
    boards, failures = board.run(planned, folder, options.resources(workers, cluster, quiet, other_code))
    if not quiet:
        for name, table in boards.items():
            scoreboard.show(table, board.PANELS[name], board.finding(name, table))
            show_line(f"{board.NOTE} Empty: does not apply, or no response.")
            show_places({"figure": folder / f"{board.FILES[name]}.png", "table": folder / f"{board.FILES[name]}.csv"})
    return options.EXIT_FAILED if failures else 0
