"""The command ``colias import``. Heavy imports happen when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.cli.options import EXIT_FAILED, Assignments, Quiet, results_folder


def import_log(
    log: Annotated[Path, typer.Argument(help="The log, a CSV; see docs/back-from-the-robot.md.")],
    frames: Annotated[
        Path | None, typer.Option(help="Folder of the trials' frames: trial-0003/000000.pgm ..., or trial-0003.raw.")
    ] = None,
    experiment: Annotated[str, typer.Option(help="The experiment whose conditions the trials show.")] = "speed",
    out: Annotated[Path | None, typer.Option(help="New folder for the run; otherwise runs/NAME-measured-TIME.")] = None,
    ran: Annotated[
        list[str] | None,
        typer.Option(metavar="MODEL", help="What the robot ran, where the log does not name a registered model: a name"
                     " or a .py file. Otherwise dsnn. Repeatable."),
    ] = None,
    model: Annotated[
        list[str] | None,
        typer.Option(metavar="MODEL", help="Show the robot's frames to this model of the bench. Repeatable."),
    ] = None,
    assignments: Assignments = None,
    recordings: Annotated[bool, typer.Option(help="Write a Rerun recording of each trial.")] = True,
    quiet: Quiet = False,
) -> int:  # fmt: skip
    """Make a run of what a real Colias has sent, with the tables, statistics, figure and claims of a simulated one.

    Everything is checked before anything is written, and what is written is whole. The run is marked as measured.
    Claims are judged by the same judges and bounds, where the log has the conditions that they need.
    """
    from experiments.bench import registry
    from experiments.bench.cli import robot_table as table
    from experiments.bench.measured.run import perform, prepare

    declared = registry.load(experiment)
    folder = results_folder(out, f"{declared.name}-measured")
    plan = prepare(
        declared, log, pictures=frames, ran=ran or (), models=model or (), assignments=assignments or ()
    )  # fmt: skip
    report = perform(plan, folder, recordings=recordings, quiet=quiet)
    if not quiet:
        table.show(report, recordings)
    return EXIT_FAILED if report.failures else 0
