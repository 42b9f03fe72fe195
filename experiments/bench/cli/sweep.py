"""The command ``colias sweep``. Heavy imports happen when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.cli import options

if TYPE_CHECKING:
    from experiments.bench.run.runs import Resources

MODEL_CLAIMS = "model-claims"


def sweep(
    experiment: Annotated[
        str,
        typer.Argument(
            metavar="EXPERIMENT|STUDY",
            help="Experiments, names or .py files, several joined by commas; or a study that colias list shows,"
            " or the .py file of one.",
        ),
    ],
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=V1,V2",
            help="An axis: values of a parameter. KEY+KEY moves several together; KEY.first and KEY.last are the"
            " ends of a parameter of several values. Once or twice. A study has its own.",
        ),
    ] = None,
    claims: Annotated[
        str | None,
        typer.Option(metavar="C13,C19", help="Claims to judge; otherwise all that are declared about the model."),
    ] = None,
    measure: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,NAME",
            help="Numbers, with the claims of --claims or alone: spikes in each condition, peak-speed-potential,"
            " peak-speed-count of crossings at several speeds, peak-hs of clips.",
        ),
    ] = None,
    repeats: Annotated[
        int | None,
        typer.Option(help="Trials of each condition in a replicate; otherwise the experiment's number. Not of clips."),
    ] = None,
    replicates: Annotated[
        int | None,
        typer.Option(help="Replicates, each with a seed of its own; otherwise 1, or the study's number."),
    ] = None,
    seed: options.Seed = 0,
    out: options.Out = None,
    assignments: options.Assignments = None,
    model: Annotated[
        list[str] | None,
        typer.Option(
            "--model",
            metavar="MODEL",
            help="A model judged, otherwise dsnn: a name or a .py file, or dsnn:w_i=1. Repeatable; of clips just one.",
        ),
    ] = None,
    pictures: options.OwnPictures = None,
    other_code: options.OtherCode = False,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    medium: options.For = "web",
    quiet: options.Quiet = False,
) -> int:
    """Run replicates of experiments at every point of a grid, and count in how many each claim holds.

    A replicate has all conditions, or clips, at one seed; replicate k has the seed --seed + k. Points that differ in
    parameters of models alone share their frames. Writes the trials, outcomes.csv (a row per point, model, claim and
    replicate), counts.csv, NAME.json and a figure. A study is a grid in a file; in the folder of a reproduction the
    next report shows it. The exit status is 0 whatever the counts are, and 1 if trials failed.
    """
    import dataclasses

    from experiments.bench import sweep as sweeps
    from experiments.bench import sweep_plan
    from experiments.bench.report.terminal import tell_troubles
    from experiments.bench.run.errors import UsageError
    from experiments.bench.study import called

    means = options.resources(workers, cluster, quiet, other_code)
    if experiment == MODEL_CLAIMS:
        return _model_claims(model or ["all"], options.results_folder(out, MODEL_CLAIMS), seed, means)
    study = None if over else called(experiment)
    if study is None:
        listed = [[name for name in (text or "").split(",") if name] for text in (claims, measure)]
        study = sweeps.typed(
            experiment, over or (), listed[0], listed[1], model or ("dsnn",), assignments or (), repeats,
            1 if replicates is None else replicates,
        )  # fmt: skip
    else:
        given = {"--claims": claims, "--measure": measure, "--set": assignments, "--model": model}
        if option := next((name for name, value in given.items() if value is not None), ""):
            raise UsageError(f"{option}: the study {study.name} has its own")
        if repeats is not None and study.repeats is None:
            raise UsageError(f"--repeats {repeats}: a replicate has each clip once; --replicates has more seeds")
        study = dataclasses.replace(study, replicates=study.replicates if replicates is None else replicates,
                                    repeats=study.repeats if repeats is None else repeats)  # fmt: skip
    plan = sweep_plan.planned(study, seed, pictures=options.own_pictures(pictures))
    name = f"sweep-{'-'.join(plan.experiments)}" if study.name == sweeps.NAME else study.name
    folder = options.run_folder(out, name)
    result = sweeps.run(plan, folder, means)
    if not quiet:
        from experiments.bench.report.sweep import show

        show(result, folder)
    return options.EXIT_FAILED if result.failures or tell_troubles(result.troubles()) else 0


def _model_claims(names: list[str], folder: Path, seed: int, means: Resources) -> int:
    """Judge the claims of models' own papers, and show them."""
    from experiments.bench.report.terminal import out_console, show_places, show_verdict
    from experiments.bench.reproduce import judge_models

    verdicts, failures = judge_models(folder, names, seed, means)
    if not means.quiet:
        for verdict in verdicts:
            show_verdict(verdict, model=True)
        out_console.print()
        show_places({"verdicts": folder / "model_claims.json"})
    return options.EXIT_FAILED if failures else 0
