"""The command ``colias train``, which ``python experiments/train_ppo.py`` is. It imports what is heavy when it runs."""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.cli.options import EXIT_FAILED, For, OtherCode, Quiet, Seed, Workers, resources, results_folder
from experiments.bench.figures.media import Medium
from experiments.bench.run import interrupts

if TYPE_CHECKING:
    from experiments.bench.closed_loop.policy import About
    from experiments.bench.closed_loop.run import Played
    from experiments.bench.run.runs import Resources
    from experiments.bench.training.study import Study

STEPS, ENVS, REPLAYED = 40_960, 8, 5
MOST_SEED = 2**32 - 1
LEAST_SEEDS, MOST_SEEDS = 2, 100
"""Training seeds of a study."""


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Train a policy on neural observations by PPO, or replay one.")(train)


def train(
    env: Annotated[str | None, typer.Option(help="Optomotor or Fixation; otherwise Optomotor.")] = None,
    steps: Annotated[int | None, typer.Option(help=f"Steps of all envs together; otherwise {STEPS}.")] = None,
    seed: Seed = 0,
    envs: Annotated[int | None, typer.Option(help=f"Envs that are stepped together; otherwise {ENVS}.")] = None,
    seeds: Annotated[
        int | None,
        typer.Option(help="Train at so many seeds, from --seed up, and judge them together; otherwise at one."),
    ] = None,
    randomise: Annotated[
        str | None, typer.Option(metavar="VALUE", help="Train under domain randomisation; as --set randomise=VALUE.")
    ] = None,
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
            help="New folder for the results; otherwise runs/NAME-TIME. With --seeds it goes on where these seeds were"
            " begun: what is trained there is kept."
        ),
    ] = None,
    replay: Annotated[Path | None, typer.Option(help="Do not train: play the policy in this file.")] = None,
    episodes: Annotated[int | None, typer.Option(help=f"With --replay: how many; otherwise {REPLAYED}.")] = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    medium: For = Medium.WEB,
    quiet: Quiet = False,
) -> int:
    """Train a small network on what the vision model says, and hold it against the reflexes, rest, chance and truth.

    Needs stable-baselines3 and PyTorch ([b]make train[/b] sets them up); --replay needs neither. OUT gets policy.npz,
    learning.csv (the mean return as it grew), the 20 episodes that each was judged by, in worlds not trained in, and
    their table and figure. --replay also leaves Rerun recordings, for [b]colias view OUT[/b]. On one version of
    PyTorch, equal --seed, --steps and --envs give equal policies. A policy's file is plain numbers: reading one runs
    nothing, and [b]colias behave FILE[/b] plays it too. With --seeds, OUT gets a folder seed-K for each training seed,
    and policies.csv and its figure with interquartile means over the training seeds.
    """
    from experiments.bench.run.errors import UsageError

    means = resources(workers, None, quiet, other_code)
    changes = [*(assignments or ()), *([] if randomise is None else [f"randomise={randomise}"])]
    given = {"--env": env, "--steps": steps, "--envs": envs, "--set": " ".join(changes) or None, "--seeds": seeds}
    if replay is not None:
        for name, value in given.items():
            if value is not None:
                known = name in ("--env", "--steps", "--envs", "--set")
                reason = "the policy's file says that" if known else "it trains nothing"
                raise UsageError(f"{name} {value}: {reason}; leave it out with --replay")
        return _replay(replay, REPLAYED if episodes is None else episodes, seed, out, means)
    if episodes is not None:
        raise UsageError(f"--episodes {episodes}: goes with --replay")
    about = _about(env or "Optomotor", STEPS if steps is None else steps, seed, ENVS if envs is None else envs, changes)
    if seeds is not None:
        return _study(about, seeds, out, means)
    return _train(about, out, means)


def _about(env: str, steps: int, seed: int, envs: int, changes: Sequence[str]) -> About:
    """Check what was asked for."""
    from experiments.bench.closed_loop.find import env_id
    from experiments.bench.closed_loop.policy import ROLLOUT, TRAINABLE, TRAINED_UNDER, About
    from experiments.bench.closed_loop.run import env_options
    from experiments.bench.run.errors import UsageError

    where = env_id(env)
    if where not in TRAINABLE:
        raise UsageError(f"--env {env}: a policy learns Optomotor or Fixation")
    for name, value, least, most in (("--seed", seed, 0, MOST_SEED), ("--envs", envs, 1, 64),
                                     ("--steps", steps, ROLLOUT * max(envs, 1), 10**8)):  # fmt: skip
        if not least <= value <= most:
            why = f" ({ROLLOUT} for each of {envs} envs at least)" if name == "--steps" else ""
            raise UsageError(f"{name} must be between {least} and {most}, got {value}{why}")
    for change in changes:
        if change.partition("=")[0].partition(".")[0] not in TRAINED_UNDER:
            raise UsageError(f"--set {change}: a training may change {', '.join(TRAINED_UNDER)}")
    return About(where, seed, steps, envs, options=dict(env_options(where, changes)))


def _study(about: About, seeds: int, out: Path | None, means: Resources) -> int:
    """Train what is missing of several seeds, judge all, draw and print; the exit status."""
    from experiments.bench.run.errors import UsageError
    from experiments.bench.training import figure, study, table

    most = min(MOST_SEEDS, MOST_SEED + 1 - about.seed)
    if not LEAST_SEEDS <= seeds <= most:
        raise UsageError(f"--seeds must be between {LEAST_SEEDS} and {most}, got {seeds}; without it one is trained")
    asked = study.Study(about, seeds)
    folder = results_folder(out, f"train-{about.env.partition('/')[2]}")
    if not (folder / study.NAME).exists():
        _require_training()
    done = study.open_folder(asked, folder)
    missing = [seed for seed in asked.seeds if seed not in done]
    if missing:
        _require_training()
        study.check_installed(study.versions(asked, folder, done), folder)
    if not means.quiet:
        _announce(asked, len(done), folder)
    for seed in missing:
        study.train(asked, folder, seed, means)
    studied = study.judge(asked, folder, means)
    figure.write(studied)
    if not means.quiet and studied.runs:
        table.show(studied)
    return EXIT_FAILED if studied.failures else 0


def _announce(asked: Study, done: int, folder: Path) -> None:
    from experiments.bench.engine.terminal import count, error_console

    trained = f"; {done} of them trained already" if done else ""
    error_console.print(
        f"{asked.first.env}: {asked.runs} training seeds, {asked.seeds[0]} to {asked.seeds[-1]}, of"
        f" {asked.first.steps} steps each in {count(asked.first.envs, 'env')}{trained}, into {folder}",
        soft_wrap=True, markup=False,
    )  # fmt: skip


def _require_training() -> None:
    """Raise `UsageError` where the extra is not installed, `GLUnavailable` where nothing can be rendered."""
    from colias_sim.reference import reference_hash
    from experiments.bench.run.errors import UsageError

    for module in ("torch", "stable_baselines3"):
        if importlib.util.find_spec(module) is None:
            raise UsageError(f"training needs {module}, which is not installed: run 'make train', or install PyTorch's"
                             " CPU build and then colias-sim[train]")  # fmt: skip
    importlib.import_module("torch._dynamo")  # its Triton has to load before the renderer's LLVM: docs/install.md
    reference_hash()


def _train(about: About, out: Path | None, means: Resources) -> int:
    from experiments.bench.engine.terminal import error_console, progress, show_places

    _require_training()
    folder = _empty_folder(out, f"train-{about.env.partition('/')[2]}")
    rounds = -(-about.steps // about.envs)
    if not means.quiet:
        message = f"{about.env}: {about.steps} steps in {about.envs} envs, which are starting, into {folder}"
        error_console.print(message, soft_wrap=True, markup=False)
    from experiments.bench.training import evaluate, ppo

    learnt = ppo.train(about, lambda: progress("train", rounds, means.quiet, f"steps of {about.envs} envs"))

    with interrupts.held():
        file = evaluate.keep(learnt.policy, learnt.curve, folder)
    if learnt.stopped:
        steps = learnt.policy.about.steps
        error_console.print(f"stopped after {steps} of {about.steps} steps; {file} has what was learnt so far",
                                    soft_wrap=True, markup=False)  # fmt: skip
        raise KeyboardInterrupt
    status = _show(evaluate.judge([file], folder, means), means, recordings=False)
    if not means.quiet:
        show_places({"policy": file})
    return status


def _replay(file: Path, episodes: int, seed: int, out: Path | None, means: Resources) -> int:
    from experiments.bench.closed_loop import policy_file
    from experiments.bench.training import evaluate

    policy_file.load(file)  # before a folder is made
    played = evaluate.replay(file, _empty_folder(out, f"replay-{file.stem}"), episodes, seed, means)
    return _show(played, means, recordings=True)


def _show(played: Played, means: Resources, *, recordings: bool) -> int:
    """Draw and print what was played; the exit status."""
    from experiments.bench.closed_loop import figure, table

    figure.write(played)
    if not means.quiet:
        table.show(played, recordings)
    return EXIT_FAILED if played.failures else 0


def _empty_folder(out: Path | None, name: str) -> Path:
    """Make the folder for the results, and return it; ``FileExistsError`` if there is something in it."""
    folder = results_folder(out, name)
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()):
        raise FileExistsError(f"--out {folder}: holds something already; choose another")
    return folder
