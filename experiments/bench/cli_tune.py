"""The command ``colias tune``. Like `cli`, it imports what is heavy when it runs."""

from __future__ import annotations

import datetime
from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.options import Cluster, Models, Only, OtherCode, Quiet, Workers, worker_count


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Measure tuning curves: speed, size, contrast, frequency, direction.")(tune)


def tune(
    model: Models = None,
    only: Only = False,
    curve: Annotated[
        list[str] | None,
        typer.Option(help="Only this one: speed, size, contrast, frequency or direction. Repeatable."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the gratings' phase, 0 or more.")] = 0,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results, otherwise runs/tune-TIME; goes on with one begun.")
    ] = None,
    assignments: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Set a model's parameter. Repeatable.")
    ] = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    quiet: Quiet = False,
) -> int:
    """Show every model objects and gratings at every speed, size, contrast, frequency and direction.

    Clips of 144x108 px at 30 frames/s, models with the paper's off-line parameters. A direction
    model's response is the mean of (hs, vs), projected on the direction of the motion, over the
    second half of the moving frames; a looming detector's its peak above rest. A figure for
    each curve, tuning.csv with every point, preferences.csv with a row a model. The command's
    own models are those registered, but dsnn-reference.
    """
    from experiments.bench import console, console_tune, tuning_run
    from experiments.bench.model_option import COMPARED, shown_models
    from experiments.bench.pool import open_pool

    made = tuning_run.plan(shown_models(COMPARED, model, only), curve or (), assignments or (), seed)
    folder = out or Path("runs") / f"tune-{datetime.datetime.now().strftime('%Y%m%d-%H%M%S')}"
    means = console.Means(worker_count(workers), cluster, quiet, other_code)
    with open_pool(means.workers, means.cluster) as pool:
        report = tuning_run.run(made, folder, pool, means)
    if not quiet:
        console_tune.show(report)
    return 1 if report.failures else 0
