"""The command ``colias reproduce``. Heavy imports happen when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.cli.options import (
    EXIT_FAILED,
    Cluster,
    For,
    Models,
    Only,
    OtherCode,
    OwnPictures,
    Quiet,
    Seed,
    Workers,
    own_pictures,
    resources,
    results_folder,
)


def reproduce(
    quick: Annotated[
        bool,
        typer.Option(
            "--quick",
            help="A taste: two short replicates, no moves, no grids of clips; the report names what it leaves out.",
        ),
    ] = False,
    full: Annotated[
        bool,
        typer.Option(
            "--full",
            help="40 replicates with the robot, 20 of clips, instead of 5, so that claims have a word; more episodes.",
        ),
    ] = False,
    robot_only: Annotated[
        bool, typer.Option("--robot-only", help="Just the paper's trials with the robot: neither clips nor behaviours.")
    ] = False,
    seed: Seed = 0,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the report, otherwise runs/reproduce-TIME; goes on with one begun.")
    ] = None,
    model: Models = None,
    only: Only = False,
    experiment: Annotated[
        list[str] | None, typer.Option(help="An experiment to add: a name or a .py file. Repeatable.")
    ] = None,
    pictures: OwnPictures = None,
    fidelity: Annotated[bool, typer.Option("--fidelity", hidden=True)] = False,
    detectors: Annotated[bool, typer.Option("--detectors", hidden=True)] = False,
    onboard: Annotated[bool, typer.Option("--onboard", hidden=True)] = False,
    models: Annotated[list[str] | None, typer.Option("--models", hidden=True)] = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    medium: For = "web",
    quiet: Quiet = False,
) -> int:
    """Run replicates of the paper's experiments, and one with each thing moved; write one page about it.

    A replicate is the paper's own design at one seed: ten repeats of each condition. Each claim is judged in each.

    The command's own models, in the trials with the robot, are dsnn and dsn2017, beside the looming detectors where a
    claim is about them. Most claims are about dsnn: --only needs it among the models.
    The reflexes of colias behave are played too, and claims of our own about them judged. report.html needs no
    network; claims.json, sensitivity.json and behaviours.json have the verdicts. The exit status is 0 whatever they
    are, and 1 if trials failed.
    """
    from experiments.bench.run.errors import UsageError
    from experiments.bench.run.settings import check_counts

    tables = {"fidelity": fidelity, "detectors": detectors, "onboard": onboard}
    for name in (name for name, used in tables.items() if used):
        raise UsageError(f"reproduce --{name}: it is colias sweep {name} now")
    if models:
        named = "".join(f" --model {name}" for name in models if name != "all")
        raise UsageError(f"reproduce --models: it is colias sweep model-claims{named} now")
    if quick and full:
        raise UsageError("--quick and --full: give one of them")
    check_counts(seed)
    means = resources(workers, cluster, quiet, other_code)
    from experiments.bench import reproduce as whole
    from experiments.bench.report import page
    from experiments.bench.report.terminal import out_console, show_places, show_verdict
    from experiments.bench.stats.count import totals

    scale = whole.QUICK if quick else whole.FULL if full else whole.USUAL
    models_shown = whole.models_shown(model, only)
    folder, walls = results_folder(out, "reproduce"), own_pictures(pictures)
    plans = whole.planned(scale, seed, models_shown, experiment or (), robot_only, only, walls)
    result = whole.reproduce(folder, plans, means)
    report = page.write(result)
    if not quiet:
        for verdict in (*result.claims, *result.own_claims):
            show_verdict(verdict, model=False)
        summary = "; ".join(totals([(verdict.id, verdict.count) for verdict in result.claims]))
        out_console.print(f"\n{summary}\n", markup=False)
        show_places({"report": report})
    return EXIT_FAILED if any(result.failures.values()) else 0
