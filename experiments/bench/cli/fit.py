"""The command ``colias fit``. Heavy imports happen when it runs."""

from __future__ import annotations

from typing import Annotated, Any

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


def fit(
    experiment: Annotated[
        str,
        typer.Argument(
            help="Names that colias list shows, or paths of .py files; several joined by commas. Or a fit that"
            " ships. leaderboard or tuning: their numbers."
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
        typer.Option(metavar="C13,C19", help="Claims to keep; otherwise all that are declared about the model."),
    ] = None,
    trials: Annotated[
        int | None, typer.Option(min=1, help="Settings to search, in whole batches of twice --share; otherwise 400.")
    ] = None,
    share: Annotated[
        int | None,
        typer.Option(min=1, help="Settings of the network that share the frames of a rendering; otherwise 10."),
    ] = None,
    sample: Annotated[
        int | None, typer.Option(min=1, help="Settings that fill the box evenly, for its share; otherwise 64.")
    ] = None,
    held_out: Annotated[
        int | None, typer.Option(min=1, help="Replicates in which the best are judged anew; otherwise 20.")
    ] = None,
    maximise: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="What to make large: slack (otherwise), kept, a measure as colias sweep has them, or a column of"
            " leaderboard or tuning. Repeatable: several give a front.",
        ),
    ] = None,
    minimise: Annotated[list[str] | None, typer.Option(metavar="NAME", help="A measure to make small.")] = None,
    sampler: Annotated[str | None, typer.Option(help="What chooses the settings: tpe (otherwise) or random.")] = None,
    repeats: Annotated[
        int | None,
        typer.Option(
            min=1, help="Trials of each condition in search and sample; the judging anew has all. Not of clips."
        ),
    ] = None,
    replicates: Annotated[
        int | None, typer.Option(min=1, help="Replicates that each setting is searched by; otherwise 1.")
    ] = None,
    seed: Seed = 0,
    out: Out = None,
    assignments: Assignments = None,
    model: Annotated[
        str | None, typer.Option("--model", metavar="MODEL", help="The model, otherwise dsnn: a name or a .py file.")
    ] = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    medium: For = "web",
    quiet: Quiet = False,
) -> int:
    r"""Search a box of parameters for settings under which all claims are kept together, or measures are largest.

    The winner and the ten next best are then judged anew at seeds that the search never saw, and only that is a result.
    The share of the box in which all is kept comes from settings that fill it evenly. Needs Optuna: the extra
    [fit]. Writes fit.csv, anew.csv, fit.json and a figure, and a folder of trials for each batch. With the
    same --out it goes on, also to more --trials.
    """
    import dataclasses

    from experiments.bench import fit as fits
    from experiments.bench import study as studies
    from experiments.bench.report import fit as report
    from experiments.bench.run.errors import UsageError

    numbers: dict[str, Any] = {"trials": trials, "share": share, "sample": sample, "held_out": held_out,
                               "sampler": sampler, "search_repeats": repeats}  # fmt: skip
    given = {name: value for name, value in numbers.items() if value is not None}
    if experiment in studies.names("FIT"):
        if over or claims or assignments or model or maximise or minimise:
            raise UsageError(f"{experiment}: its box, goals, model and settings are written down in its file")
        asked = studies.shipped(experiment, "FIT")
        study = asked.study if replicates is None else dataclasses.replace(asked.study, replicates=replicates)
        asked = dataclasses.replace(asked, study=study, **given)
    else:
        asked = fits.typed(experiment, tuple(over or ()), tuple(filter(None, (claims or "").split(","))),
                           model or "dsnn", tuple(assignments or ()), tuple(maximise or ()), tuple(minimise or ()),
                           replicates or 1, given)  # fmt: skip
    plan = fits.planned(asked, seed)
    folder = run_folder(out, asked.study.name)
    fitted = fits.run(plan, folder, resources(workers, cluster, quiet, other_code))
    if not quiet:
        report.show(fitted, folder)
    return EXIT_FAILED if fitted.failures else 0
