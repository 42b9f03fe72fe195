"""The command ``colias run``. Heavy imports happen when it runs."""

from __future__ import annotations

from pathlib import Path
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

if TYPE_CHECKING:
    from experiments.bench.offline import OfflineReport
    from experiments.bench.trials import Report


def run_experiment(
    context: typer.Context,
    experiment: Annotated[
        str | None,
        typer.Argument(
            help="A name that colias list shows, or the path of a .py file.", autocompletion=experiment_names
        ),
    ] = None,
    again: Annotated[
        Path | None,
        typer.Option(metavar="RUN", help="Repeat this run instead, and compare every row."),
    ] = None,
    repeats: Repeats = None,
    seed: Seed = 0,
    out: Out = None,
    assignments: Assignments = None,
    model: Models = None,
    only: Only = False,
    eyes: Annotated[
        str,
        typer.Option(metavar="one|both", help="both: the robot's modelled eye too, MODEL@ov7670."),
    ] = "one",
    pictures: OwnPictures = None,
    recordings: Annotated[bool, typer.Option(help="Write a Rerun recording of each trial.")] = True,
    live: Annotated[
        bool,
        typer.Option("--live", help="Show trials in a Rerun viewer while they run."),
    ] = False,
    viewer: Annotated[
        str | None,
        typer.Option(metavar="HOST:PORT", help="The address of that viewer."),
    ] = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    medium: For = "web",
    quiet: Quiet = False,
) -> int:
    """Run an experiment, and write tables, figure, verdicts and recordings into a folder.

    Every model sees the same frames: dsnn, or the models that the experiment declares. Finished trials are kept
    when a run is interrupted; the same command with that folder as --out does the rest.
    """
    from experiments.bench import registry
    from experiments.bench.api import perform
    from experiments.bench.report.terminal import tell_troubles
    from experiments.bench.run.errors import UsageError
    from experiments.bench.sources.clips import OfflineExperiment

    if again is not None:
        from experiments.bench.cli.again import repeat_run

        sources = {name: context.get_parameter_source(name) for name in context.params}
        typed = {name for name, source in sources.items() if source and source.name == "COMMANDLINE"}
        if others := sorted(typed - {"again", "out", "workers", "medium", "quiet"}):
            raise UsageError(f"--again repeats a run as it was: leave out {', '.join(others)}")
        return repeat_run(context, again, out, workers, quiet)
    if experiment is None:
        raise UsageError("colias run: give an experiment, or --again RUN")
    declared = registry.find(experiment)
    means = resources(workers, cluster, quiet, other_code)
    folder = run_folder(out, declared.name)
    report = perform(
        declared, folder, means, recordings=recordings, live=viewer or live, models=model or (), only=only,
        settings=assignments or (), repeats=repeats, seed=seed, eyes=eyes, pictures=own_pictures(pictures),
    )  # fmt: skip
    if not quiet:
        _show(report, recordings and (not isinstance(declared, OfflineExperiment) or declared.recorded))
    broken = tell_troubles((verdict.id, verdict.trouble) for verdict in report.verdicts)
    return EXIT_FAILED if report.failures or broken else 0


def _show(report: Report | OfflineReport, recordings: bool) -> None:
    """Print what a run of either kind amounts to."""
    from experiments.bench.cli import robot_table
    from experiments.bench.offline import OfflineReport

    if isinstance(report, OfflineReport):
        _show_clips(report, recordings)
    else:
        robot_table.show(report, recordings)


def _show_clips(report: OfflineReport, recorded: bool) -> None:
    """Print the peaks of every clip at the first seed, the verdicts, and where everything is."""
    from rich.table import Table

    from experiments.bench.report.terminal import count, out_console, show_files, show_table, show_verdicts

    table = Table(title="potentials of each clip, first seed", title_justify="left", box=None, header_style="bold",
                  pad_edge=False)  # fmt: skip
    counted = "HS spikes" if all(row["spikes"] == row["hs_spikes"] for row in report.rows) else "spikes"
    for name in ("clip", "model", "HS", "VS", "looming", counted):
        table.add_column(name, justify="left" if name in ("clip", "model") else "right", no_wrap=True)
    for row in (row for row in report.rows if row["repeat"] == 0):
        ranges = (f"{row[f'trough_{system}']:+z.3f} .. {row[f'peak_{system}']:+z.3f}" for system in ("hs", "vs"))
        spikes = "-" if row["spikes"] is None else f"{row['spikes']}"
        table.add_row(row["clip"], row["model"], *ranges, f"{row['peak_looming']:.2f}", spikes)
    show_table(table)
    out_console.print()
    show_verdicts(report.verdicts, model=False)
    names = [*(["figure.png"] if report.rows else []), "trials.parquet", *(["claims.json"] if report.verdicts else [])]
    done = count(len({row["trial"] for row in report.rows}), "clip")
    show_files(report.folder, names, bool(recorded and report.rows), done)
