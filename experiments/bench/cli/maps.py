"""The command ``colias map``, and what became of ``colias sweep``. Heavy imports happen when it runs."""

from __future__ import annotations

from typing import Annotated

import typer

from experiments.bench.cli.options import (
    EXIT_FAILED,
    Assignments,
    Cluster,
    For,
    OtherCode,
    Out,
    OwnPictures,
    Quiet,
    Seed,
    Workers,
    own_pictures,
    resources,
    run_folder,
)
from experiments.bench.figures.media import Medium


def register(app: typer.Typer) -> None:
    """Put the commands into ``app``."""
    app.command("map", short_help="Claims and numbers over a grid of parameters, in whole replicates.")(map_claims)
    app.command("sweep", hidden=True, context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(
        sweep
    )


def sweep(context: typer.Context) -> int:
    """Name the command that took over."""
    from experiments.bench.run.errors import UsageError

    raise UsageError("colias sweep: it is colias map EXPERIMENT --over KEY=V1,V2 --measure spikes now")


def map_claims(
    experiment: Annotated[
        str,
        typer.Argument(help="Names that [b]colias list[/b] shows, or paths of .py files; several joined by commas."),
    ],
    over: Annotated[
        list[str],
        typer.Option(
            metavar="KEY=V1,V2",
            help="An axis: values of a parameter. KEY+KEY moves several together; KEY.first and KEY.last are the"
            " ends of a parameter of several values. Once or twice.",
        ),
    ],
    claims: Annotated[
        str | None,
        typer.Option(
            metavar="C13,C19", help="Claims to judge; otherwise all that the experiments declare about the model."
        ),
    ] = None,
    measure: Annotated[
        str | None,
        typer.Option(
            metavar="NAME,NAME",
            help="Numbers to map, beside the claims of --claims or alone: spikes in each condition,"
            " peak-speed-potential, peak-speed-count of crossings at several speeds, peak-hs of clips.",
        ),
    ] = None,
    repeats: Annotated[
        int | None,
        typer.Option(
            help="Trials of each condition in a replicate; otherwise the experiment's own number. Not of clips."
        ),
    ] = None,
    replicates: Annotated[int, typer.Option(help="Replicates, each with a seed of its own.")] = 1,
    seed: Seed = 0,
    out: Out = None,
    assignments: Assignments = None,
    model: Annotated[
        list[str] | None,
        typer.Option(
            "--model",
            metavar="MODEL",
            help="A model judged, otherwise dsnn: a name or a .py file, or dsnn:w_i=1. Repeatable; of clips just one.",
        ),
    ] = None,
    pictures: OwnPictures = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    medium: For = Medium.WEB,
    quiet: Quiet = False,
) -> int:
    """Run whole replicates of the experiments at every point of a grid, and count in how many each claim holds.

    The experiments have a robot, or all are off-line ones, whose clips have keys such as cluttered.grey. A replicate
    has all conditions at one seed; replicate k has the seed --seed + k. A claim is judged on the first of the
    experiments that declares it, for each model. Experiments without claims show the mean number of spikes
    in each condition. Points that differ in the network alone share their frames. Writes counts.csv, map.json, map.svg,
    map.png and the trials.
    """
    from experiments.bench import registry
    from experiments.bench.engine.terminal import tell_troubles
    from experiments.bench.run.errors import UsageError
    from experiments.bench.studies import run, table
    from experiments.bench.studies.study import Study

    names = [name for name in experiment.split(",") if name]
    if not names:
        raise UsageError("EXPERIMENT: expected one name or more, joined by commas, for example general,speed")
    declared = [registry.find(name) for name in names]
    named = [name for name in (claims or "").split(",") if name]
    if claims is not None and not named:
        raise UsageError("--claims: expected ids joined by commas, for example C13,C19")
    numbers = [name for name in (measure or "").split(",") if name]
    if measure is not None and not numbers:
        raise UsageError("--measure: expected names joined by commas, for example peak-speed-potential")
    study = Study(
        "map", "claims and numbers over a grid of parameters", claims=tuple(named), measures=tuple(numbers),
        experiments=tuple(names), over=tuple(over), models=tuple(dict.fromkeys(model or ("dsnn",))),
        assignments=tuple(assignments or ()), repeats=repeats, replicates=replicates, every_trial=False,
    )  # fmt: skip
    plan = run.planned(study, seed, pictures=own_pictures(pictures))
    folder = run_folder(out, f"map-{'-'.join(entry.name for entry in declared)}")
    counts = run.run(plan, folder, resources(workers, cluster, quiet, other_code))
    if not quiet:
        table.show(counts, folder, "map")
    broken = tell_troubles((cell.claim, cell.trouble) for cell in counts.cells)
    return EXIT_FAILED if counts.failures or broken else 0
