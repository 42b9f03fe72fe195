"""The command ``colias behave``. It imports what is heavy when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

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
from experiments.bench.figures.media import Medium


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Close the loop: a behaviour in an env, scored against baselines.")(behave)


def behave(
    name: Annotated[
        str, typer.Argument(help="A behaviour or a group that [b]colias list[/b] shows, or the path of a .py file.")
    ],
    env: Annotated[
        str | None, typer.Option(help="Avoidance, Fixation, Optomotor or Pursuit; otherwise the behaviour's own.")
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
    power: Annotated[
        str | None,
        typer.Option(
            metavar="OTHER",
            help="Play OTHER in place of the baselines, and say how many episodes it takes to show that NAME collides"
            " less often.",
        ),
    ] = None,
    out: Out = None,
    recordings: Annotated[
        bool, typer.Option(help="Write a Rerun recording of each of the behaviour's episodes, not the baselines'.")
    ] = True,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    medium: For = Medium.WEB,
    quiet: Quiet = False,
) -> int:
    """Play a behaviour's episodes, and those of its baselines in the same worlds, and print a table with intervals.

    The robot is the observer of the trials, with its camera, wheels and motors; the network runs on every frame.
    Equal seeds are equal worlds, whoever plays in them. Recordings show the observer's view, the arena from above
    with tracks, the neurons, the wheels and the reward. With --power these episodes are a pilot: use other seeds for
    it than for what is judged. The group [b]escape[/b] plays the escape reflex of every looming model, with a table of
    survival. Exit status: 1 if episodes failed; the others count.
    """
    from experiments.behaviours import GROUPS, REFERENCE
    from experiments.bench.closed_loop import figure as closed_loop_figure
    from experiments.bench.closed_loop import run as behaving
    from experiments.bench.closed_loop import survival
    from experiments.bench.closed_loop import table as closed_loop_table

    plan = behaving.plan(name, env, assignments or (), episodes, seed, baselines, power)
    folder = run_folder(out, f"behave-{Path(name).stem}")
    means = resources(workers, cluster, quiet, other_code)
    with means.pool() as pool:
        played = behaving.run(plan, folder, pool, means, recordings=plan.episodes if recordings else 0)
    closed_loop_figure.write(played)
    if not quiet:
        closed_loop_table.show(played, recordings)
    if name in GROUPS:
        survivals = survival.survival(played.standings, REFERENCE[name][0])
        path = survival.write(folder, survivals)
        if not quiet:
            closed_loop_table.show_survival(survivals, name, path)
    if power is not None:
        closed_loop_table.show_power(played, power)
    return EXIT_FAILED if played.failures else 0
