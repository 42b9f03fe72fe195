"""The command ``colias tune``. It imports what is heavy when it runs."""

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
    Workers,
    resources,
    run_folder,
)
from experiments.bench.figures.media import Medium


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Measure tuning curves: speed, size, contrast, frequency, direction, l/v.")(tune)


def tune(
    model: Models = None,
    only: Only = False,
    curve: Annotated[
        list[str] | None,
        typer.Option(help="Only this one: speed, size, contrast, frequency, direction or l-over-v. Repeatable."),
    ] = None,
    stimulus: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE", help="The curve of this stimulus, or of a .py file's, along --over; of --curve too."
        ),
    ] = None,
    over: Annotated[
        str | None,
        typer.Option(metavar="NAME.PARAM=V1,V2", help="The parameter of --stimulus that varies, and its values."),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the gratings' phase, 0 or more.")] = 0,
    out: Out = None,
    assignments: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Set a parameter of a model or of --stimulus. Repeatable."),
    ] = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    medium: For = Medium.WEB,
    quiet: Quiet = False,
) -> int:
    """Show every model objects and gratings at every speed, size, contrast, frequency and direction.

    Clips of 144x108 px at 30 frames/s, models with the paper's off-line parameters. A direction
    model's response is the mean of (hs, vs), projected on the direction of the motion, over the
    second half of the moving frames; a looming detector's its peak above rest. Looming models
    are shown approaches too, dark and light, at six ratios l/v of half-size to speed. A preference
    within the noise of its measure is told as not defined. A figure for each curve, tuning.csv with
    every point, preferences.csv with a row a model. The command's own models are those registered,
    but dsnn-reference.

    A stimulus of --stimulus moves as its truth says: a response is projected on the direction of the
    mean velocity of its object, or else of its background; on rightward where its truth gives none.
    """
    from experiments.bench.run.errors import UsageError
    from experiments.bench.run.models import COMPARED, shown_models
    from experiments.bench.sources import clips as stimuli
    from experiments.bench.tuning import run as tuning_run
    from experiments.bench.tuning import table as tuning_table

    if (stimulus is None) != (over is None):
        missing, given = ("--over", "--stimulus") if over is None else ("--stimulus", "--over")
        raise UsageError(f"{given} {stimulus or over}: it goes with {missing}")
    models = shown_models(COMPARED, model, only)
    entry = None if stimulus is None else stimuli.find_stimulus(stimulus)
    plan = tuning_run.plan(models, curve or (), assignments or (), seed, entry, over or "")
    folder = run_folder(out, "tune")
    means = resources(workers, cluster, quiet, other_code)
    with means.pool(rendering=False) as pool:
        report = tuning_run.run(plan, folder, pool, means)
    if not quiet:
        tuning_table.show(report)
    return EXIT_FAILED if report.failures else 0
