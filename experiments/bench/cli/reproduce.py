"""The command ``colias reproduce``. Heavy imports happen when it runs."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from experiments.bench.cli.options import (
    EXIT_FAILED,
    Cluster,
    Models,
    Only,
    OtherCode,
    Quiet,
    Seed,
    Workers,
    new_folder,
    resources,
)

if TYPE_CHECKING:
    from experiments.bench.engine.batch import Resources


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Run the paper's experiments and report which claims hold.")(reproduce)


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
        typer.Option("--full", help="40 replicates instead of 5, so that claims have a word; more episodes."),
    ] = False,
    robot_only: Annotated[
        bool, typer.Option("--robot-only", help="Just the paper's trials with the robot: neither clips nor behaviours.")
    ] = False,
    fidelity: Annotated[
        bool,
        typer.Option(
            "--fidelity",
            help="Instead: C13 to C20 and C29 with the robot's true eye and wheels, in 20 replicates;"
            " with --quick in two short ones.",
        ),
    ] = False,
    detectors: Annotated[
        bool,
        typer.Option(
            "--detectors",
            help="Instead: C21 of every looming detector and preset, in the bright and the dim arena, in 20 replicates;"
            " with --quick in two short ones.",
        ),
    ] = False,
    onboard: Annotated[
        bool,
        typer.Option(
            "--onboard",
            help="Instead: C13 to C20 in the arithmetic of the robot's own processor, in several formats, in 20"
            " replicates; with --quick in two short ones.",
        ),
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
    models: Annotated[
        list[str] | None,
        typer.Option(
            "--models", help="Instead: the claims of these models' own papers, on clips. A name, or all. Repeatable."
        ),
    ] = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    quiet: Quiet = False,
) -> int:
    """Run replicates of the paper's experiments, and one with each thing moved; write one page about it.

    A replicate is the paper's own design at one seed: ten repeats of each condition. Each claim is judged in each.

    The command's own models, in the trials with the robot, are dsnn and dsn2017, beside the looming detectors where a
    claim is about them. Most claims are about dsnn: --only needs it among the models.
    With --models none of this is run: the clips that the named models' own papers are about are shown to them instead.
    The reflexes of [b]colias behave[/b] are played too, and claims of our own about them judged. report.html needs no
    network; claims.json, sensitivity.json and behaviours.json have the verdicts. The exit status is 0 whatever they
    are, and 1 if trials failed.
    """
    from experiments.bench.engine.errors import UsageError
    from experiments.bench.engine.settings import check_counts

    if quick and full:
        raise UsageError("--quick and --full: give one of them")
    check_counts(seed)
    means = resources(workers, cluster, quiet, other_code)
    whole_only = full or robot_only or bool(model or experiment or only)
    tables = {"--models": bool(models), "--fidelity": fidelity, "--detectors": detectors,
              "--onboard": onboard}  # fmt: skip
    chosen = [option for option, used in tables.items() if used]
    if len(chosen) > 1:
        raise UsageError(f"{' and '.join(chosen)}: give one of them")
    if models:
        given = {"--quick": quick, "--full": full, "--robot-only": robot_only, "--model": model, "--only": only,
                 "--experiment": experiment}  # fmt: skip
        for option in (option for option, used in given.items() if used):
            raise UsageError(f"--models and {option}: the claims of models have clips of their own")
        return _models(models, new_folder(out, "model-claims"), seed, means)
    if chosen:
        if whole_only:
            raise UsageError(f"{chosen[0]}: goes with --quick, --seed, --out, --workers, --cluster and --quiet alone")
        study = _fidelity if fidelity else _detectors if detectors else _onboard
        return study(quick, seed, out, means)
    from experiments.bench.closed_loop import table as closed_loop_table
    from experiments.bench.engine.terminal import out_console, show_places
    from experiments.bench.reproduction import plan, report, table
    from experiments.bench.reproduction import reproduce as whole
    from experiments.bench.reproduction.onboard import table as onboard_table

    scale = plan.QUICK if quick else plan.FULL if full else plan.USUAL
    shown = whole.models_shown(model, only)
    folder = new_folder(out, "reproduce")
    result = whole.reproduce(folder, scale, seed, shown, means, experiment or (), robot_only, only)
    page = report.write(result)
    if not quiet:
        table.show_claims(result.claims, result.pooled, result.scale.name)
        closed_loop_table.show_claims(result.own_claims)
        out_console.print()
        if result.onboard:
            onboard_table.show(result.onboard)
        show_places({"report": page})
    return EXIT_FAILED if result.failed else 0


def _size(quick: bool, replicates: int) -> tuple[int, int]:
    """How many replicates of a table, and trials of each condition in one."""
    from experiments.bench.reproduction import plan

    return (plan.QUICK.replicates, plan.QUICK.repeats) if quick else (replicates, plan.WHOLE)


def _fidelity(quick: bool, seed: int, out: Path | None, means: Resources) -> int:
    """The table of claims over eyes and drives, printed anew after every replicate."""
    from experiments.bench.engine.terminal import out_console, show_places
    from experiments.bench.figures import plotting
    from experiments.bench.reproduction import table
    from experiments.bench.reproduction.eye import fidelity, figure

    folder = new_folder(out, "fidelity")
    show = (lambda _: None) if means.quiet else table.show_fidelity
    result = fidelity.run(folder, *_size(quick, fidelity.REPLICATES), seed, means, show)
    picture = plotting.save(figure.draw(result), folder, "fidelity")
    if not means.quiet:
        out_console.print()
        show_places({"table": folder / "fidelity.json", "figure": picture})
    return EXIT_FAILED if result.failures else 0


def _detectors(quick: bool, seed: int, out: Path | None, means: Resources) -> int:
    """The table of C21 over detectors and arenas, then the causes."""
    from experiments.bench.reproduction.detectors import study, table

    return _study(study, table.show, quick, seed, new_folder(out, "detectors"), means, table.show_causes)


def _onboard(quick: bool, seed: int, out: Path | None, means: Resources) -> int:
    """The table of claims over formats of numbers."""
    from experiments.bench.reproduction.onboard import study, table

    return _study(study, table.show, quick, seed, new_folder(out, "onboard"), means)


def _study(
    study: Any, show: Callable[[Any], None], quick: bool, seed: int, folder: Path, means: Resources,
    show_causes: Callable[[Any], None] = lambda _: None,
) -> int:  # fmt: skip
    """Run a study, whose module this is given, and print its table anew after every replicate."""
    from experiments.bench.engine.terminal import out_console, show_places

    shown = (lambda _: None) if means.quiet else show
    result = study.run(folder, *_size(quick, study.REPLICATES), seed, means, shown)
    if not means.quiet:
        out_console.print()
        show_causes(result)
        show_places({"table": folder / study.FILE})
    return EXIT_FAILED if result.failures else 0


def _models(names: list[str], folder: Path, seed: int, means: Resources) -> int:
    """Judge the claims of models' own papers, and show them."""
    from experiments.bench.engine.terminal import out_console, show_places
    from experiments.bench.reproduction import table
    from experiments.bench.reproduction.models import run as model_claims

    verdicts, failures = model_claims.run(folder, names, seed, means)
    if not means.quiet:
        table.show_model_claims(verdicts)
        out_console.print()
        show_places({"verdicts": folder / "model_claims.json"})
    return EXIT_FAILED if failures else 0
