"""The command ``colias train``, which ``python experiments/train_ppo.py`` is. It imports what is heavy when it runs."""

from __future__ import annotations

import datetime
import importlib.util
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench import interrupts
from experiments.bench.options import Quiet, Seed, Workers, worker_count

if TYPE_CHECKING:
    from experiments.bench.console import Means
    from experiments.bench.policy import About

STEPS, ENVS, REPLAYED = 40_960, 8, 5


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Train a policy on neural observations by PPO, or replay one.")(train)


def train(
    env: Annotated[str | None, typer.Option(help="Optomotor or Fixation; otherwise Optomotor.")] = None,
    steps: Annotated[int | None, typer.Option(help=f"Steps of all envs together; otherwise {STEPS}.")] = None,
    seed: Seed = 0,
    envs: Annotated[int | None, typer.Option(help=f"Envs that are stepped together; otherwise {ENVS}.")] = None,
    out: Annotated[Path | None, typer.Option(help="New folder for the results; otherwise runs/NAME-TIME.")] = None,
    replay: Annotated[Path | None, typer.Option(help="Do not train: play the policy in this file.")] = None,
    episodes: Annotated[int | None, typer.Option(help=f"With --replay: how many; otherwise {REPLAYED}.")] = None,
    workers: Workers = None,
    quiet: Quiet = False,
) -> int:
    """Train a small network on what the vision model says, and hold it against chance, rest and the reflex.

    Needs stable-baselines3 and PyTorch ([b]make train[/b] sets them up); --replay needs neither. OUT gets policy.npz,
    learning.csv (the mean return as it grew), the 20 episodes that each was judged by, in worlds not trained in, and
    their table and figure. --replay also leaves Rerun recordings, for [b]colias view OUT[/b]. On one version of
    PyTorch, equal --seed, --steps and --envs give equal policies. A policy's file is plain numbers: reading one runs
    nothing, and [b]colias behave FILE[/b] plays it too.
    """
    from experiments.bench import console
    from experiments.bench.files import UsageError

    means = console.Means(worker_count(workers), None, quiet)
    if replay is not None:
        for name, value in {"--env": env, "--steps": steps, "--envs": envs}.items():
            if value is not None:
                raise UsageError(f"{name} {value}: the policy's file says that; leave it out with --replay")
        return _replay(replay, REPLAYED if episodes is None else episodes, seed, out, means)
    if episodes is not None:
        raise UsageError(f"--episodes {episodes}: goes with --replay")
    about = _about(env or "Optomotor", STEPS if steps is None else steps, seed, ENVS if envs is None else envs)
    return _train(about, out, means)


def _about(env: str, steps: int, seed: int, envs: int) -> About:
    """What was asked for, checked."""
    from experiments.bench.behaving import env_id
    from experiments.bench.files import UsageError
    from experiments.bench.policy import ROLLOUT, TRAINABLE, About

    where = env_id(env)
    if where not in TRAINABLE:
        raise UsageError(f"--env {env}: a policy learns Optomotor or Fixation")
    for name, value, least, most in (("--seed", seed, 0, 2**32 - 1), ("--envs", envs, 1, 64),
                                     ("--steps", steps, ROLLOUT * max(envs, 1), 10**8)):  # fmt: skip
        if not least <= value <= most:
            why = f" ({ROLLOUT} for each of {envs} envs at least)" if name == "--steps" else ""
            raise UsageError(f"{name} {value}: legal is a whole number from {least} to {most}{why}")
    return About(where, seed, steps, envs)


def _train(about: About, out: Path | None, means: Means) -> int:
    from colias_sim.gl import require_backend
    from experiments.bench import console
    from experiments.bench.files import UsageError
    from experiments.bench.progress import progress

    for module in ("torch", "stable_baselines3"):
        if importlib.util.find_spec(module) is None:
            raise UsageError(f"training needs {module}, which is not installed: run 'make train', or install PyTorch's"
                             " CPU build and then colias-sim[train]")  # fmt: skip
    require_backend()
    folder = _new_folder(out, f"train-{about.env.partition('/')[2]}")
    rounds = -(-about.steps // about.envs)
    if not means.quiet:
        said = f"{about.env}: {about.steps} steps in {about.envs} envs, which are starting, into {folder}"
        console.error_console.print(said, soft_wrap=True, markup=False)
    from experiments.bench import policy_run, training
    from experiments.bench.policy import ROLLOUT

    # Steps come fast until the first rollout is learnt from: the time left is known after two.
    learnt = training.train(
        about, lambda: progress("train", rounds, means.quiet, f"steps of {about.envs} envs", width=ROLLOUT)
    )

    with interrupts.held():
        file = policy_run.keep(learnt.policy, learnt.curve, folder)
    if learnt.stopped:
        made = learnt.policy.about.steps
        console.error_console.print(f"stopped after {made} of {about.steps} steps; {file} has what was learnt so far",
                                    soft_wrap=True, markup=False)  # fmt: skip
        raise KeyboardInterrupt
    failed = policy_run.judge(file, folder, means)
    if not means.quiet:
        console.out_console.print(f"{'policy':<12}{file}", soft_wrap=True, markup=False)
    return 1 if failed else 0


def _replay(file: Path, episodes: int, seed: int, out: Path | None, means: Means) -> int:
    from experiments.bench import policy_file, policy_run

    policy_file.load(file)  # before a folder is made
    failed = policy_run.replay(file, _new_folder(out, f"replay-{file.stem}"), episodes, seed, means)
    return 1 if failed else 0


def _new_folder(out: Path | None, name: str) -> Path:
    """The folder for the results, made; ``FileExistsError`` if there is something in it."""
    folder = out or Path("runs") / f"{name}-{datetime.datetime.now().strftime('%Y%m%d-%H%M%S')}"
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()):
        raise FileExistsError(f"--out {folder}: holds something already; choose another")
    return folder
