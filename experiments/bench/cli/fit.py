"""The command ``colias fit``. Heavy imports happen when it runs."""

from __future__ import annotations

from typing import Annotated

import typer

from experiments.bench.cli.options import (
    EXIT_FAILED,
    Assignments,
    Cluster,
    OtherCode,
    Out,
    Quiet,
    Seed,
    Workers,
    resources,
    run_folder,
)


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Search for parameters under which claims are kept, and judge the best anew.")(fit)


def fit(
    experiment: Annotated[
        str,
        typer.Argument(help="Names that [b]colias list[/b] shows, or paths of .py files; several joined by commas."),
    ],
    over: Annotated[
        list[str],
        typer.Option(
            metavar="KEY=A..B",
            help="A parameter that is free: between two ends, one of several values as KEY=V1,V2, or in its whole legal"
            " range as KEY. KEY.first and KEY.last are the ends of a parameter of several values. Repeatable.",
        ),
    ],
    claims: Annotated[
        str | None,
        typer.Option(
            metavar="C13,C19", help="Claims to keep; otherwise all that the experiments declare about the model."
        ),
    ] = None,
    trials: Annotated[
        int, typer.Option(help="Settings to search, rounded up to whole batches of twice --share.")
    ] = 400,
    share: Annotated[
        int, typer.Option(help="Settings of the network that are shown the frames of one rendering.")
    ] = 10,
    sample: Annotated[int, typer.Option(help="Settings that fill the box evenly, for the share that keeps all.")] = 64,
    held_out: Annotated[
        int, typer.Option("--held-out", help="Replicates in which the winner and the ten next best are judged anew.")
    ] = 20,
    sampler: Annotated[str, typer.Option(help="What chooses the settings: tpe or random.")] = "tpe",
    repeats: Annotated[
        int | None,
        typer.Option(
            help="Trials of each condition in a replicate; otherwise the experiment's own number. Not of clips."
        ),
    ] = None,
    replicates: Annotated[int, typer.Option(help="Replicates that each setting is searched by.")] = 1,
    seed: Seed = 0,
    out: Out = None,
    assignments: Assignments = None,
    model: Annotated[
        str, typer.Option("--model", metavar="MODEL", help="The model: a name or a .py file, or dsnn:w_i=1.")
    ] = "dsnn",
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    quiet: Quiet = False,
) -> int:
    """Search a box of parameters for settings under which all claims are kept together.

    What is searched for is the least slack over claims and replicates, in smallest differences. The winner and the ten
    next best are then judged anew at seeds that the search never saw, and only that is a result: a claim is fitted, or
    it is not. The share of the box in which all is kept comes from settings that fill it evenly, with its interval.
    Needs Optuna: the extra [b]\\[fit][/b]. Writes fit.csv, anew.csv, fit.json, fit.svg, fit.png, and a folder of trials
    for each batch. With the same --out it goes on, also to more --trials.
    """
    from experiments.bench import registry
    from experiments.bench.engine.errors import UsageError
    from experiments.bench.studies.fitting import run, table
    from experiments.bench.studies.fitting.fit import Fit
    from experiments.bench.studies.study import Study

    names = [name for name in experiment.split(",") if name]
    if not names:
        raise UsageError("EXPERIMENT: expected one name or more, joined by commas, for example general,speed")
    declared = [registry.find(name) for name in names]
    ids = [name for name in (claims or "").split(",") if name]
    if claims is not None and not ids:
        raise UsageError("--claims: expected ids joined by commas, for example C13,C19")
    study = Study(
        "fit", "parameters that keep claims", claims=tuple(ids), experiments=tuple(names), models=(model,),
        assignments=tuple(assignments or ()), repeats=repeats, replicates=replicates, every_trial=False,
    )  # fmt: skip
    asked = Fit(study, tuple(over), trials, share, sample, held_out, sampler)  # type: ignore[arg-type]  # checked there
    plan = run.planned(asked, seed)
    folder = run_folder(out, f"fit-{'-'.join(entry.name for entry in declared)}")
    fitted = run.run(plan, folder, resources(workers, cluster, quiet, other_code))
    table.write(fitted, folder)
    if not quiet:
        table.show(fitted, folder)
    return EXIT_FAILED if fitted.failures else 0
