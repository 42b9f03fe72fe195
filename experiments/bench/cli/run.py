"""The command ``colias run``. Heavy imports happen when it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.cli.options import (
    EXIT_FAILED,
    Assignments,
    Cluster,
    For,
    Models,
    Only,
    OtherCode,
    Out,
    OwnPictures,
    Quiet,
    Repeats,
    Seed,
    Workers,
    experiment_names,
    own_pictures,
    resources,
    run_folder,
)
from experiments.bench.figures.media import Medium

if TYPE_CHECKING:
    from experiments.bench.clips.summary import OfflineReport
    from experiments.bench.robot.summary import Report


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command("run", short_help="Run an experiment: trials, recordings, tables, figure, verdicts.")(run_experiment)


def run_experiment(
    experiment: Annotated[
        str,
        typer.Argument(
            help="A name that [b]colias list[/b] shows, or the path of a .py file.", autocompletion=experiment_names
        ),
    ],
    repeats: Repeats = None,
    seed: Seed = 0,
    out: Out = None,
    assignments: Assignments = None,
    model: Models = None,
    only: Only = False,
    eyes: Annotated[
        str,
        typer.Option(help="both: each model sees the same physics by the robot's modelled eye too (MODEL@ov7670)."),
    ] = "one",
    pictures: OwnPictures = None,
    recordings: Annotated[bool, typer.Option(help="Write a Rerun recording of each trial.")] = True,
    live: Annotated[
        bool,
        typer.Option("--live", help="Stream trials into a Rerun viewer while they run: the open one, or a new one."),
    ] = False,
    viewer: Annotated[
        str | None,
        typer.Option(metavar="HOST:PORT", help="Stream them to the viewer at this address, which implies --live."),
    ] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Check everything, say what would be done, and write nothing.")
    ] = False,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    medium: For = Medium.WEB,
    quiet: Quiet = False,
) -> int:
    """Run an experiment and write its results into a folder.

    Every model sees the same frames. The command's own model is dsnn, or those that the experiment declares.
    Trials already finished stay readable if the run is interrupted, and the same command with that folder as --out
    does the rest. Results do not depend on the number of workers.

    The folder has trials.parquet (a row per trial and model), frames.parquet (a row per frame), summary.csv (a row per
    condition), claims.json (the verdicts), run.json (every parameter, the seed, the versions), figure.svg and
    figure.png (every repeat visible), and recordings/ (one .rrd per trial).
    """
    from experiments.bench import registry
    from experiments.bench.clips.experiment import OfflineExperiment
    from experiments.bench.engine.terminal import tell_troubles
    from experiments.bench.public.run import RunRequest, perform, planned

    declared = registry.find(experiment)
    means = resources(workers, cluster, quiet, other_code)
    folder = run_folder(out, declared.name)
    asked = RunRequest(model or (), only, assignments or (), repeats, seed, eyes, own_pictures(pictures))
    if dry_run:
        from experiments.bench.cli.dry_run import say

        say(planned(declared, asked), folder, recordings, other_code)
        return 0
    report = perform(declared, asked, folder, means, recordings=recordings, live=viewer or live)
    if not quiet:
        _show(report, recordings and (not isinstance(declared, OfflineExperiment) or declared.recorded))
    broken = tell_troubles((verdict.id, verdict.trouble) for verdict in report.verdicts)
    return EXIT_FAILED if report.failures or broken else 0


def _show(report: Report | OfflineReport, recordings: bool) -> None:
    """Print what a run of either kind amounts to."""
    from experiments.bench.clips import table as clips_table
    from experiments.bench.clips.summary import OfflineReport
    from experiments.bench.robot import table as robot_table

    if isinstance(report, OfflineReport):
        clips_table.show(report, recordings)
    else:
        robot_table.show(report, recordings)
