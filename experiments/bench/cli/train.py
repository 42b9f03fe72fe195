"""The command ``colias train``. It imports what is heavy when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.cli.options import EXIT_FAILED, For, OtherCode, Quiet, Seed, Workers, resources, results_folder


def train(
    env: Annotated[str, typer.Option(help="Optomotor or Fixation.")] = "Optomotor",
    steps: Annotated[int, typer.Option(min=1, max=10**8, help="Steps of all envs together.")] = 40_960,
    seed: Seed = 0,
    envs: Annotated[int, typer.Option(min=1, max=64, help="Envs that are stepped together.")] = 8,
    seeds: Annotated[
        int, typer.Option(min=1, max=100, help="Train at so many seeds, from --seed up, and judge them together.")
    ] = 1,
    assignments: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="camera, robot, noise or randomise of the env, for example camera=ov7670. Repeatable.",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Folder of the results; otherwise runs/NAME-TIME. Where this training was begun there, a policy that"
            " is finished is kept."
        ),
    ] = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    medium: For = "web",
    quiet: Quiet = False,
) -> int:
    """Train a small network on what the vision model says, and hold it against the reflexes, rest, chance and truth.

    Needs stable-baselines3 and PyTorch (make train sets them up). OUT gets policy-SEED.npz and learning-SEED.csv
    (the mean return as it grew) of each training seed, and the 20 episodes that each was judged by, in worlds not
    trained in, as a run with its summary and figure. Of several seeds policies.csv and its figure have the
    interquartile means over the training seeds. On one version of PyTorch, equal seeds, --steps and --envs give equal
    policies. A policy's file is plain numbers: reading one runs nothing, and colias behave FILE plays it.
    """
    from experiments.bench import train as training
    from experiments.bench.report import behaviours
    from experiments.bench.report.terminal import count, show_files

    abouts = training.plan(env, steps, seed, envs, seeds, assignments or ())
    folder = results_folder(out, f"train-{env}")
    report, table = training.run(abouts, folder, resources(workers, None, quiet, other_code))
    if not quiet and not report.trials.is_empty():
        title = training.described(abouts)
        behaviours.show(table, f"{title}. {training.OF_SEEDS}" if seeds > 1 else title)
        names = ["figure.png", "summary.csv", *(["policies.png", "policies.csv"] if seeds > 1 else [])]
        show_files(folder, names, False, count(seeds, "training seed"))
    return EXIT_FAILED if report.failures else 0
