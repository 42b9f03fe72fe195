"""The commands ``colias import`` and ``colias camera``. Heavy imports happen when they run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.cli import options


def import_log(
    log: Annotated[Path, typer.Argument(help="The log, a CSV with a row per frame.")],
    frames: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="The trials' frames: trial-0003/000000.pgm and so on.")
    ] = None,
    experiment: Annotated[str, typer.Option(help="The experiment whose conditions the trials show.")] = "speed",
    ran: Annotated[
        list[str] | None,
        typer.Option(metavar="MODEL", help="What the robot ran; otherwise what the log says, or dsnn. Repeatable."),
    ] = None,
    model: options.Models = None,
    assignments: options.Assignments = None,
    out: options.Out = None,
    quiet: options.Quiet = False,
) -> int:  # fmt: skip
    """Make a run of what a real Colias has sent, with the tables, figure and verdicts of a simulated one.

    The run is marked as measured. The same judges and bounds apply.

    colias import log.csv --experiment speed --set experiment.speeds_cm_s=20,30
    """
    from experiments.bench import registry
    from experiments.bench.cli import tables
    from experiments.bench.robot_side import import_log as importing

    declared = registry.load(experiment)
    folder = options.run_folder(out, f"{declared.name}-measured")
    plan, trials = importing.plan(declared, log, frames, ran or (), model or (), assignments or ())
    report = importing.run(plan, trials, log, folder, quiet=quiet)
    if not quiet:
        tables.show_trials(report)
    return options.EXIT_FAILED if report.failures.height else 0


def camera(
    folder: Annotated[Path, typer.Argument(help="It has folders of pictures (.pgm, .png): still*, edge*, loop*.")],
    fps: Annotated[float, typer.Option(min=1.0, max=1000.0, help="Frames per second of edge*.")] = 30.0,
    gain: Annotated[float, typer.Option(min=0.1, max=16.0, help="The camera's gain; 1.5 on Colias.")] = 1.0,
) -> int:
    """Measure a camera from frames that it took, and print the settings that make the simulated eye like it."""
    from experiments.bench.report.terminal import error_console, out_console, show
    from experiments.bench.robot_side.calibrate import measure

    measured, notes = measure(folder, fps, gain)
    show(measured.drop("settings"), f"camera of {folder}")
    for note in notes:
        error_console.print(f"note: {note}", soft_wrap=True, markup=False)
    settings = [text for texts in measured["settings"] for text in texts]
    for text in [*([f"camera.gain={gain:g}"] if settings and gain != 1.0 else []), *settings]:
        out_console.print(f"--set {text}", soft_wrap=True, markup=False)
    return 0
