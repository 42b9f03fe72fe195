"""The command ``colias sweep``. Heavy imports happen when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.cli.options import (
    EXIT_FAILED,
    Assignments,
    Cluster,
    Models,
    Only,
    OtherCode,
    Quiet,
    Repeats,
    Seed,
    Workers,
    new_folder,
    resources,
)


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Run an experiment over a grid of parameters, on the same stimuli.")(sweep)


def sweep(
    experiment: Annotated[str, typer.Argument(help="A name that [b]colias list[/b] shows, or the path of a .py file.")],
    over: Annotated[list[str], typer.Option(metavar="KEY=V1,V2", help="Values of a parameter. Repeatable: a grid.")],
    repeats: Repeats = None,
    seed: Seed = 0,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results, otherwise runs/sweep-NAME-TIME; goes on with one begun.")
    ] = None,
    assignments: Assignments = None,
    model: Models = None,
    only: Only = False,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    quiet: Quiet = False,
) -> int:
    """Run every combination of the values; tabulate (sweep.csv) and draw (figure.svg, .png) them together.

    Equal trials of different points have equal seeds: the same stimuli, start poses and noise. KEY may be a parameter
    of any model shown; models that a point does not vary ride along. The command's own model is dsnn, or those
    that the experiment declares.
    """
    from experiments.bench import registry
    from experiments.bench.engine.models import shown_models
    from experiments.bench.robot.sweep import grid, table
    from experiments.bench.robot.sweep.run import run

    declared = registry.load(experiment)
    points = grid.grid(over, assignments or ())
    models = shown_models(declared.models, model, only)
    parts = grid.parts(declared, models, points, assignments or (), repeats, seed)
    folder = new_folder(out, f"sweep-{declared.name}")
    swept = run(parts, points, declared.varies, folder, resources(workers, cluster, quiet, other_code))
    if not quiet:
        table.show(swept)
    return EXIT_FAILED if swept.failed else 0
