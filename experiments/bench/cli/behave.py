"""The command ``colias behave``. It imports what is heavy when it runs."""

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
    Quiet,
    Seed,
    Workers,
    resources,
    run_folder,
)

if TYPE_CHECKING:
    from experiments.bench.behave import BehaviourReport


def behave(
    names: Annotated[
        list[str],
        typer.Argument(
            metavar="NAME...",
            help="Behaviours or a group that colias list shows, .py files, or policies (.npz). The first one's"
            " episodes are recorded.",
        ),
    ],
    env: Annotated[
        str | None, typer.Option(help="Avoidance, Fixation, Optomotor or Pursuit; otherwise the first behaviour's own.")
    ] = None,
    episodes: Annotated[int, typer.Option(help="Episodes of each behaviour, at as many seeds.")] = 20,
    seed: Seed = 0,
    assignments: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="An argument of the env, for example robots=5, or an entry of one: camera.preset=ov7670. Repeatable.",
        ),
    ] = None,
    baselines: Annotated[
        bool, typer.Option(help="Play random walk, straight drive and the privileged one too.")
    ] = True,
    out: Out = None,
    recordings: Annotated[
        bool, typer.Option(help="Write a Rerun recording of each of the first behaviour's episodes.")
    ] = True,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    medium: For = "web",
    quiet: Quiet = False,
) -> int:
    """Play behaviours' episodes, and those of their baselines in the same worlds, and print a table with intervals.

    The robot is the observer of the trials, with its camera, wheels and motors; the network runs on every frame.
    Equal seeds are equal worlds, whoever plays in them. Recordings show the observer's view, the arena from above
    with tracks, the neurons, the wheels and the reward. Where collisions count, the table has survival too, the ratio
    of each behaviour's collisions a metre to the first one's, and the episodes that such a comparison takes for a power
    of 80 %. The group escape plays the escape reflex of every looming model. A policy plays under the eye,
    wheels and randomisation that it was trained with. Exit status: 1 if episodes failed; the others count.
    """
    from experiments.bench import behave as behaving

    plan = behaving.plan(names, env, assignments or (), episodes, seed, baselines=baselines)
    folder = run_folder(out, f"behave-{Path(names[0]).stem}")
    means = resources(workers, cluster, quiet, other_code)
    with means.pool() as pool:
        report = behaving.run(plan, folder, pool, means, recordings=plan.episodes if recordings else 0)
    if not quiet:
        show(report, recordings)
    return EXIT_FAILED if report.failures else 0


def show(report: BehaviourReport, recorded: bool) -> None:
    """Print the scores, the verdicts, and where everything is."""
    from colias_sim.envs import ENVS
    from experiments.bench.report import behaviours
    from experiments.bench.report.terminal import count, show_files, show_line, show_verdicts

    if report.trials.is_empty():
        return
    plan = report.plan
    behaviours.show(report.summary, behaviours.caption(plan.env, plan.options, plan.episodes, plan.seed))
    if note := ENVS[plan.env].note:
        show_line(note)
    show_verdicts(report.verdicts, model=False)
    names = ["figure.png", "summary.csv", "trials.parquet", "claims.json"]
    show_files(report.folder, names, recorded, count(report.trials.height, "episode"))
