"""The command ``colias study``. Heavy imports happen when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.cli.options import (
    EXIT_FAILED,
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
    results_folder,
    run_folder,
)
from experiments.bench.figures.media import Medium

if TYPE_CHECKING:
    from experiments.bench.run.runs import Resources

MODEL_CLAIMS = "model-claims"
QUICK = (2, 5)
"""Most replicates, and trials of each condition in one, of ``--quick``. It has at most half of a study's replicates."""


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Claims at every point of a grid that is written down.")(study)


def study(
    name: Annotated[str, typer.Argument(help="A study that [b]colias list[/b] shows, or the path of a .py file.")],
    quick: Annotated[bool, typer.Option("--quick", help="A taste: one or two short replicates.")] = False,
    replicates: Annotated[
        int | None, typer.Option(help="Replicates, each with a seed of its own; otherwise the study's own number.")
    ] = None,
    repeats: Annotated[
        int | None, typer.Option(help="Trials of each condition in a replicate; otherwise the study's own number.")
    ] = None,
    seed: Seed = 0,
    out: Out = None,
    model: Annotated[
        list[str] | None,
        typer.Option("--model", metavar="MODEL", help="Of model-claims: judge this model's. Repeatable."),
    ] = None,
    pictures: OwnPictures = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    medium: For = Medium.WEB,
    quiet: Quiet = False,
) -> int:
    """Run a study: replicates of its experiments at every point of its grid. Count in how many each claim holds.

    Replicate r has the seeds of replicate r of [b]colias reproduce[/b]. Writes counts.csv, NAME.json, NAME.svg,
    NAME.png and the trials. In the folder of a reproduction, or in one inside it, the next report shows it.
    The exit status is 0 whatever the counts are, and 1 if trials failed.
    """
    import dataclasses

    from experiments.bench.engine.terminal import tell_troubles
    from experiments.bench.run.errors import UsageError
    from experiments.bench.studies import registry, run, table

    means = resources(workers, cluster, quiet, other_code)
    if name == MODEL_CLAIMS:
        given = {"--quick": quick, "--replicates": replicates, "--repeats": repeats}
        given["--pictures"] = pictures is not None
        for option in (option for option, used in given.items() if used):
            raise UsageError(
                f"{MODEL_CLAIMS} and {option}: its clips are shown once, or at the seeds that they need: leave it out"
            )
        return _model_claims(model or ["all"], results_folder(out, MODEL_CLAIMS), seed, means)
    if model:
        raise UsageError(f"--model: goes with {MODEL_CLAIMS}; the study {name} says itself which models it judges")
    asked = registry.find(name)
    if repeats is not None and asked.repeats is None:
        raise UsageError(f"--repeats {repeats}: a replicate has each clip once; --replicates has more seeds")
    if quick:
        asked = dataclasses.replace(asked, replicates=min(QUICK[0], max(asked.replicates // 2, 1)),
                                    repeats=asked.repeats and QUICK[1])  # fmt: skip
    asked = dataclasses.replace(
        asked,
        replicates=asked.replicates if replicates is None else replicates,
        repeats=asked.repeats if repeats is None else repeats,
    )
    plan = run.planned(asked, seed, pictures=own_pictures(pictures))
    folder = run_folder(out, asked.name)
    counts = run.run(plan, folder, means)
    if not quiet:
        table.show(counts, folder, asked.name)
    broken = tell_troubles((cell.claim, cell.trouble) for cell in counts.cells)
    return EXIT_FAILED if counts.failures or broken else 0


def _model_claims(names: list[str], folder: Path, seed: int, means: Resources) -> int:
    """Judge the claims of models' own papers, and show them."""
    from experiments.bench.engine.terminal import out_console, show_places, show_verdict
    from experiments.bench.reproduce import judge_models

    verdicts, failures = judge_models(folder, names, seed, means)
    if not means.quiet:
        for verdict in verdicts:
            show_verdict(verdict, model=True)
        out_console.print()
        show_places({"verdicts": folder / "model_claims.json"})
    return EXIT_FAILED if failures else 0
