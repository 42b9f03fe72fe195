"""The command ``colias tune``. It imports what is heavy when it runs."""

from __future__ import annotations

from typing import Annotated

import typer

from experiments.bench.cli import options

ONE_OF = "Only this one: speed, size, contrast, frequency, direction, l-over-v or disc"
ALONG = "The curve of this stimulus, or of a .py file's, along --over; of --curve too."


def tune(
    model: options.Models = None,
    only: options.Only = False,
    curve: Annotated[list[str] | None, typer.Option(help=f"{ONE_OF}. Repeatable.")] = None,
    stimulus: Annotated[str | None, typer.Option(metavar="NAME|FILE", help=ALONG)] = None,
    over: Annotated[
        str | None, typer.Option(metavar="NAME.PARAM=V1,V2", help="That parameter, and its values.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the gratings' phase, 0 or more.")] = 0,
    out: options.Out = None,
    assignments: options.Assignments = None,
    other_code: options.OtherCode = False,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    medium: options.For = "web",
    quiet: options.Quiet = False,
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
    from experiments.bench import tune as curves
    from experiments.bench.report import tuning
    from experiments.bench.report.terminal import show_places
    from experiments.bench.run.errors import UsageError
    from experiments.bench.run.models import COMPARED, shown_models
    from experiments.bench.sources.clips import find_stimulus

    if (stimulus is None) != (over is None):
        raise UsageError(f"--stimulus and --over go together, got {stimulus or over} alone")
    entry = None if stimulus is None else find_stimulus(stimulus)
    models = shown_models(COMPARED, model, only)
    plan = curves.plan(models, curve or (), assignments or (), seed, entry, over or "")
    folder, means = options.run_folder(out, "tune"), options.resources(workers, cluster, quiet, other_code)
    with means.pool(rendering=False) as pool:
        points, preferences, failures = curves.run(plan, folder, pool, means)
    figures = curves.draw(plan, folder, points, preferences)
    if not quiet:
        tuning.show(preferences)
        show_places({**figures, "tables": folder / "tuning.csv"})
    return options.EXIT_FAILED if failures else 0
