"""The command ``colias watch``. It imports what is heavy when it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.cli import options
from experiments.bench.run import interrupts

if TYPE_CHECKING:
    import polars as pl

    from experiments.bench.result import Run


def watch(
    source: Annotated[
        str, typer.Argument(help="A video, a camera's index from 0, a folder of pictures or a stimulus.")
    ],
    model: options.Models = None,
    only: options.Only = False,
    assignments: options.Assignments = None,
    size: options.Size = None,
    fps: Annotated[float | None, typer.Option(help="Rate of the models; otherwise 30, whatever the source's.")] = None,
    seconds: Annotated[float | None, typer.Option(help="How much to show; otherwise all.")] = None,
    seed: options.Seed = 0,
    jitter: options.Jitter = 0.0,
    judge: Annotated[bool, typer.Option("--judge", help="Judge claim C12 by optical flow; takes longer.")] = False,
    out: options.Out = None,
    recordings: options.Recordings = True,
    view: Annotated[
        bool | None,
        typer.Option("--view/--no-view", help="Stream to a Rerun viewer; otherwise where there is a screen."),
    ] = None,
    quiet: options.Quiet = False,
) -> int:
    """Show a video, a camera, pictures or a stimulus to models, a step a frame, and say when what moved which way.

    The command's own model is dsnn. Models see 320 px along the longer side, of a stimulus its own size, or --size. A
    file is taken as fast as it decodes. Thresholds are the paper's off-line ones, which belong to 30 steps a second:
    responses grow with the square of the rate, so --fps changes what passes them.
    Exit status: 1 if a film ended early or a model failed, 130 if interrupted; what was seen until then is in the
    folder.
    """
    from colias_sim.gl import has_screen
    from experiments.bench import watch as watching
    from experiments.bench.report import viewer

    if view:
        viewer.require_screen("watch: ", "give --no-view")
    trial = watching.plan(
        source, model or (), assignments or (), only=only, size=options.width_height(size), fps=fps,
        seconds=seconds, seed=seed, jitter_px=jitter, judge=judge,
    )  # fmt: skip
    folder = options.results_folder(out, "watch")
    wanted = has_screen() if view is None else view
    report = watching.run(trial, folder, recordings=recordings, view=wanted, quiet=quiet)
    if not quiet:
        show(report)
    failed = report.failures.height or report.description[watching.EARLY]
    return options.EXIT_FAILED if failed else interrupts.STATUS if trial.condition.stopped else 0


def show(run: Run) -> None:
    """Print the intervals of motion, what each model came to, the verdicts, and where everything is."""
    from experiments.bench.report import terminal
    from experiments.bench.report.terminal import count, show_files, show_verdicts
    from experiments.bench.run.rows import COUNTS, PEAKS
    from experiments.bench.sources.motion import GRADES

    if not run.done:
        return
    terminal.show(run.summary, "motion over T" if run.summary.height else "motion over T: none")
    terminal.show(
        run.trials.head(1).select("source", "width", "height", "fps", "frames", "seconds"), "as models saw it"
    )
    terminal.show(_filled(run.trials.select("model", *COUNTS, *PEAKS)), "each model")
    if run.description["judged"]:
        terminal.show(_filled(run.trials.select("model", *GRADES)), "HS and optical flow, with 95 % intervals")
    show_verdicts(run.verdicts, model=len(run.models) > 1)
    show_files(run.folder, count(run.trials["frames"][0], "frame"))


def _filled(table: pl.DataFrame) -> pl.DataFrame:
    """Return a table without the columns that have only nulls."""
    return table.select(column for column in table if column.null_count() < table.height)
