"""The command ``colias fit``. Heavy imports happen when it runs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from experiments.bench.cli.options import (
    EXIT_FAILED,
    Assignments,
    Cluster,
    For,
    OtherCode,
    Out,
    Quiet,
    Seed,
    Workers,
    resources,
    run_folder,
)
from experiments.bench.figures.media import Medium

if TYPE_CHECKING:
    from experiments.bench.studies.fitting.fit import Fit


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Search for parameters under which claims are kept, and judge the best anew.")(fit)


def fit(
    experiment: Annotated[
        str,
        typer.Argument(
            help="Names that [b]colias list[/b] shows, or paths of .py files; several joined by commas. Or a fit that"
            " ships, whose box and claims are written down. [b]leaderboard[/b] or [b]tuning[/b]: their numbers."
        ),
    ],
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=A..B",
            help="A parameter that is free: between two ends, one of several values as KEY=V1,V2, or in its whole legal"
            " range as KEY. KEY.first and KEY.last are the ends of a parameter of several values; KEY+KEY=A..B gives"
            " several parameters one value. Repeatable.",
        ),
    ] = None,
    claims: Annotated[
        str | None,
        typer.Option(
            metavar="C13,C19", help="Claims to keep; otherwise all that the experiments declare about the model."
        ),
    ] = None,
    trials: Annotated[
        int | None,
        typer.Option(help="Settings to search, rounded up to whole batches of twice --share; otherwise 400."),
    ] = None,
    share: Annotated[
        int | None,
        typer.Option(help="Settings of the network that are shown the frames of one rendering; otherwise 10."),
    ] = None,
    sample: Annotated[
        int | None,
        typer.Option(help="Settings that fill the box evenly, for the share that keeps all; otherwise 64."),
    ] = None,
    held_out: Annotated[
        int | None,
        typer.Option(help="Replicates in which the winner and the ten next best are judged anew; otherwise 20."),
    ] = None,
    maximise: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="What to make large: slack (otherwise) or kept, the number of claims kept; or a measure, as colias map"
            " has them, or a column of the table of leaderboard or tuning. Repeatable: several give a front.",
        ),
    ] = None,
    minimise: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="A measure to make small, as false_alarms. Repeatable.")
    ] = None,
    sampler: Annotated[
        str | None, typer.Option(help="What chooses the settings: tpe or random; otherwise tpe.")
    ] = None,
    repeats: Annotated[
        int | None,
        typer.Option(
            help="Trials of each condition in a replicate of search and sample; otherwise the experiment's own number,"
            " which the judging anew always has. Not of clips."
        ),
    ] = None,
    replicates: Annotated[
        int | None, typer.Option(help="Replicates that each setting is searched by; otherwise 1.")
    ] = None,
    seed: Seed = 0,
    out: Out = None,
    assignments: Assignments = None,
    model: Annotated[
        str | None,
        typer.Option(
            "--model", metavar="MODEL", help="The model, otherwise dsnn: a name or a .py file, or dsnn:w_i=1."
        ),
    ] = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    medium: For = Medium.WEB,
    quiet: Quiet = False,
) -> int:
    """Search a box of parameters for settings under which all claims are kept together, or measures are largest.

    What is searched for is the least slack over claims and replicates, in smallest differences, or what --maximise and
    --minimise name. The winner and the ten next best are then judged anew at seeds that the search never saw, and only
    that is a result: a claim is fitted, or it is not; a measure is better than the model's as it is, or it is not. The
    share of the box in which all is kept comes from settings that fill it evenly, with its interval. Needs Optuna: the
    extra [b]\\[fit][/b]. Writes fit.html, fit.csv, anew.csv, fit.json, fit.svg, fit.png, and a folder of trials for
    each batch. With the same --out it goes on, also to more --trials.
    """
    import dataclasses

    from experiments.bench.run.errors import UsageError
    from experiments.bench.studies.fitting import run, table
    from experiments.bench.study import fits, shipped

    if experiment in fits():
        if over or claims or assignments or model or maximise or minimise:
            raise UsageError(f"{experiment}: its box, claims, model and settings are written down; leave out --over,"
                             " --claims, --maximise, --minimise, --set and --model")  # fmt: skip
        asked = shipped(experiment, "FIT")
    else:
        asked = _typed(experiment, over or [], claims, model or "dsnn", assignments or [], maximise, minimise)
    numbers: dict[str, Any] = {
        "trials": trials,
        "share": share,
        "sample": sample,
        "held_out": held_out,
        "sampler": sampler,
        "search_repeats": repeats,
    }
    study = asked.study if replicates is None else dataclasses.replace(asked.study, replicates=replicates)
    asked = dataclasses.replace(
        asked, study=study, **{name: value for name, value in numbers.items() if value is not None}
    )
    plan = run.planned(asked, seed)
    folder = run_folder(out, asked.study.name)
    fitted = run.run(plan, folder, resources(workers, cluster, quiet, other_code))
    table.write(fitted, folder)
    if not quiet:
        table.show(fitted, folder)
    return EXIT_FAILED if fitted.failures else 0


def _typed(
    experiment: str,
    over: list[str],
    claims: str | None,
    model: str,
    assignments: list[str],
    maximise: list[str] | None,
    minimise: list[str] | None,
) -> Fit:
    """Return the fit that was typed."""
    from experiments.bench import registry
    from experiments.bench.run.errors import UsageError
    from experiments.bench.studies.fitting.fit import BOARDS, SLACK, Fit
    from experiments.bench.study import Study

    names = [name for name in experiment.split(",") if name]
    if not names:
        raise UsageError("EXPERIMENT: expected one name or more, joined by commas, for example general,speed")
    ids = [name for name in (claims or "").split(",") if name]
    if claims is not None and not ids:
        raise UsageError("--claims: expected ids joined by commas, for example C13,C19")
    large, small = tuple(maximise or ()), tuple(minimise or ())
    declared = "-".join(name if name in BOARDS else registry.find(name).name for name in names)
    summary = f"parameters for {', '.join((*large, *small))}" if large or small else "parameters that keep claims"
    return Fit(
        Study(
            f"fit-{declared}", summary, claims=tuple(ids), experiments=tuple(names),
            models=(model,), assignments=tuple(assignments), repeats=None, replicates=1, every_trial=False,
        ),
        tuple(over),
        maximise=large or (() if small else (SLACK,)),
        minimise=small,
    )  # fmt: skip
