"""The commands that analyse: ``colias reproduce``, ``sweep``, ``fit``, ``benchmark``, ``leaderboard`` and ``tune``.

Heavy imports happen when they run.
"""

import secrets
from pathlib import Path
from typing import Annotated

import typer

from experiments.base.console import count, error_console, out_console, show_files
from experiments.base.errors import UsageError
from experiments.base.values import key_values
from experiments.cli import options
from experiments.kinds.tables import KINDS, shipped
from experiments.store.asked import Asked
from experiments.store.workers import Workers

MOST_NAMED = 10
"""Differences of an entry that are printed."""
MODEL_CLAIMS = "model-claims"
"""The study of the claims of the looming models' own papers."""
Claims = Annotated[
    str | None, typer.Option(metavar="C13,C19", help="Claims; otherwise all that are declared about the model.")
]


def reproduce(
    quick: Annotated[bool, typer.Option("--quick", help="A taste: two short replicates, nothing moved.")] = False,
    full: Annotated[bool, typer.Option("--full", help="40 replicates with the robot and 20 of clips, not 5.")] = False,
    robot_only: Annotated[bool, typer.Option("--robot-only", help="The paper's trials with the robot alone.")] = False,
    seed: options.Seed = 0,
    out: options.Out = None,
    model: options.Models = None,
    experiment: Annotated[list[str] | None, typer.Option(help="An experiment to add: a name or a .py file.")] = None,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    quiet: options.Quiet = False,
) -> int:
    """Run replicates of the paper's experiments, and one with each thing moved; write one page about it.

    A replicate is the paper's own design at one seed: ten repeats of each condition. Each claim is judged in each.
    The models are dsnn and dsn2017, with looming detectors where a claim is about them. The reflexes of colias behave
    are played too. Verdicts are in claims.json and behaviours.json, the page is report.html. The exit status is 0
    whatever the verdicts are, and 1 if trials failed.
    """
    scale = "quick" if quick else "full" if full else "usual"
    asked = Asked(kind="reproduction", what=tuple(experiment or ()), models=tuple(model or ()), seed=seed,
                  options={"scale": scale, "robot_only": robot_only})  # fmt: skip
    return options.finish(asked, out, options.pool(workers, cluster, quiet), "reproduce")


def sweep(
    experiment: Annotated[
        str, typer.Argument(metavar="EXPERIMENT|STUDY", help="Experiments, joined by commas; or a study.")
    ],
    over: options.Over = None,
    claims: Claims = None,
    measure: Annotated[
        str | None, typer.Option(metavar="NAME,NAME", help="spikes, peak-speed-potential, peak-hs, true-r, ...")
    ] = None,
    repeats: options.Repeats = None,
    replicates: options.Replicates = None,
    seed: options.Seed = 0,
    out: options.Out = None,
    assignments: options.Assignments = None,
    model: options.Models = None,
    dry_run: options.DryRun = False,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    quiet: options.Quiet = False,
) -> int:
    """Run replicates of experiments at every point of a grid, and count in how many each claim holds.

    A replicate has all conditions, or clips, at one seed; replicate k has the seed --seed + k. Writes the trials,
    outcomes.csv (a row per point, model, claim and replicate), counts.csv, NAME.json and a figure. The exit status is
    0 whatever the counts are, and 1 if trials failed.
    """
    pool = options.pool(workers, cluster, quiet)
    if experiment == MODEL_CLAIMS:
        if dry_run:
            raise UsageError(f"--dry-run: {MODEL_CLAIMS} is not planned before it runs; leave it out")
        from experiments.base.files import results_folder

        return _model_claims(model or ["all"], results_folder(out, MODEL_CLAIMS), seed, pool)
    given = {"over": over, "claims": _names(claims), "measures": _names(measure), "replicates": replicates}
    asked = Asked(kind="sweep", what=tuple(experiment.split(",")), models=tuple(model or ()),
                  values=key_values(assignments), repeats=repeats, seed=seed, options=given)  # fmt: skip
    return options.finish(asked, out, pool, dry=dry_run)


def _names(text: str | None) -> list[str] | None:
    return None if text is None else [name for name in text.split(",") if name]


def _model_claims(names: list[str], folder: Path, seed: int, pool: Workers) -> int:
    """Judge the claims of models' own papers, and show them."""
    from experiments.draw.terminal import show_verdicts

    verdicts, failures = shipped(KINDS["reproduction"].removesuffix(":KIND")).judge_models(folder, names, seed, pool)
    if not pool.quiet:
        show_verdicts(verdicts, model=True)
        show_files(folder, count(len(verdicts), "claim"))
    return options.EXIT_FAILED if failures else 0


def fit(
    experiment: Annotated[str, typer.Argument(help="Experiments, joined by commas.")],
    over: options.Over = None,
    claims: Claims = None,
    trials: Annotated[
        int | None, typer.Option(min=1, help="Settings to search, in whole batches of twice --share; otherwise 400.")
    ] = None,
    share: Annotated[int | None, typer.Option(min=1, help="Settings that share a rendering; otherwise 10.")] = None,
    sample: Annotated[int | None, typer.Option(min=1, help="Settings that fill the box evenly; otherwise 64.")] = None,
    held_out: Annotated[int | None, typer.Option(min=1, help="Replicates that judge the best; otherwise 20.")] = None,
    repeats: Annotated[int | None, typer.Option(min=1, help="Trials of each condition in search and sample.")] = None,
    replicates: options.Replicates = None,
    seed: options.Seed = 0,
    out: options.Out = None,
    assignments: options.Assignments = None,
    model: Annotated[str | None, typer.Option(metavar="MODEL", help="The model, otherwise dsnn.")] = None,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    quiet: options.Quiet = False,
) -> int:
    """Search a box of parameters for settings under which all claims hold together.

    The winner and the ten next best are judged again at seeds that the search never saw, and only that is a result.
    The share of the box in which all holds comes from settings that fill it evenly. Needs Optuna: the extra [fit].
    Writes fit.csv, anew.csv, fit.json and a figure. With the same --out it resumes, also to more --trials.
    """
    given = {"over": over, "claims": _names(claims), "replicates": replicates, "trials": trials, "share": share,
             "sample": sample, "held_out": held_out, "search_repeats": repeats}  # fmt: skip
    asked = Asked(kind="fit", what=tuple(experiment.split(",")), models=(model,) if model else (),
                  values=key_values(assignments), seed=seed, options=given)  # fmt: skip
    return options.finish(asked, out, options.pool(workers, cluster, quiet))


def benchmark(
    model: Annotated[str | None, typer.Argument(help="A name, or a .py file.")] = None,
    beacon: Annotated[str, typer.Option("--round", metavar="SEED", help="A round's number: add its trials.")] = "",
    verify: Annotated[Path | None, typer.Option(metavar="ENTRY", help="Check this entry.")] = None,
    sample: Annotated[float, typer.Option(help="With --verify: the share of its trials that is done again.")] = 0.1,
    seed: Annotated[int | None, typer.Option(help="With --verify: what draws them; otherwise nobody knows it.")] = None,
    out: options.Out = None,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    quiet: options.Quiet = False,
) -> int:
    """Score a model on the frozen tasks CB-1, and write an entry that others can check.

    The entry has its scores (entry.json), a row for each trial (trials.parquet), the model's files, a page and a
    figure. The same command with that folder as --out resumes. --verify computes every score again and does a sample
    of the trials again. It runs the entry's code with your rights.
    """
    pool = options.pool(workers, cluster, quiet)
    if verify is None:
        asked = Asked(kind="benchmark", models=(model,) if model else (), only=True, options={"round": beacon})
        return options.finish(asked, out, pool)
    error_console.print(f"note: this runs the code in {verify} with your rights")
    drawn = secrets.randbelow(2**31) if seed is None else seed
    found, how = shipped(KINDS["benchmark"].removesuffix(":KIND")).verify(verify, sample, drawn, pool)
    for line in found[:MOST_NAMED]:
        out_console.print(f"differs: {line}")
    out_console.print(f"{f'{verify} does not agree: {len(found)} differences' if found else f'{verify} agrees'}. {how}")
    return options.EXIT_FAILED if found else 0


def leaderboard(
    model: options.Models = None,
    only: options.Only = False,
    repeats: options.Repeats = None,
    seed: options.Seed = 0,
    out: options.Out = None,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    quiet: options.Quiet = False,
) -> int:
    """Rank models on the robot trials and clips of 0.4, as before colias benchmark. It goes in 0.6.

    Models of direction and of looming are ranked apart: leaderboard.csv and looming.csv have the scores with their
    95 % intervals. The models are those registered, but dsnn-reference.
    """
    error_console.print("note: colias leaderboard goes in 0.6: colias benchmark takes its place")
    asked = Asked(kind="leaderboard", models=tuple(model or ()), only=only, repeats=repeats, seed=seed)
    return options.finish(asked, out, options.pool(workers, cluster, quiet))


def tune(
    model: options.Models = None,
    only: options.Only = False,
    curve: Annotated[
        list[str] | None, typer.Option(help="speed, size, contrast, frequency, direction, l-over-v or disc.")
    ] = None,
    seed: options.Seed = 0,
    out: options.Out = None,
    assignments: options.Assignments = None,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    quiet: options.Quiet = False,
) -> int:
    """Show every model objects and gratings at every speed, size, contrast, frequency and direction.

    A direction model's response is the mean of (hs, vs), projected on the direction of the motion, over the second
    half of the moving frames; a looming detector's is its peak above rest, also to approaches at six ratios l/v. A
    preference within the noise of its measure is reported as not defined. Writes a figure for each curve, tuning.csv
    and preferences.csv. The models are those registered, but dsnn-reference.
    """
    asked = Asked(kind="tuning", models=tuple(model or ()), only=only, values=key_values(assignments), seed=seed,
                  options={"curves": curve})  # fmt: skip
    return options.finish(asked, out, options.pool(workers, cluster, quiet), "tune")
