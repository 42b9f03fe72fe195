"""The commands that run something: ``colias run``, ``watch``, ``live``, ``behave`` and ``train``.

Heavy imports happen when they run.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from experiments.bench.cli import options
from experiments.bench.run.errors import UsageError

REPEATED = ("run", "sweep", "tune", "behave", "watch", "experiments.run")
"""Commands and calls whose runs can be repeated."""
NOT_REPEATED: Mapping[str, Any] = {"cluster": None, "view": False}
"""Options that say nothing of a run's numbers."""


def run(
    context: typer.Context,
    experiment: Annotated[str | None, typer.Argument(help="A name, or a .py file.")] = None,
    again: Annotated[Path | None, typer.Option(metavar="RUN", help="Repeat this run, and compare every row.")] = None,
    repeats: options.Repeats = None,
    seed: options.Seed = 0,
    out: options.Out = None,
    assignments: options.Assignments = None,
    model: options.Models = None,
    only: options.Only = False,
    eyes: Annotated[str, typer.Option(metavar="one|both", help="both: the robot's eye too, MODEL@ov7670.")] = "one",
    pictures: options.OwnPictures = None,
    recordings: options.Recordings = True,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    quiet: options.Quiet = False,
) -> int:
    """Run an experiment, and write tables, figure, verdicts and recordings into a folder.

    Every model sees the same frames: dsnn, or the models that the experiment declares. Finished trials are kept
    when a run is interrupted; the same command with that folder as --out does the rest.
    """
    from experiments.bench import registry
    from experiments.bench.api import perform
    from experiments.bench.cli import tables
    from experiments.bench.report.terminal import print_troubles
    from experiments.bench.sources.pictures import folder_pictures

    if again is not None:
        if others := sorted(options.typed(context) - {"again", "out", "workers", "quiet"}):
            raise UsageError(f"--again repeats a run as it was: leave out {', '.join(others)}")
        return _repeat(context, again, out, workers, quiet)
    if experiment is None:
        raise UsageError("colias run: give an experiment, or --again RUN")
    declared = registry.find(experiment)
    pool = options.pool(workers, cluster, quiet)
    done = perform(
        declared, options.results_folder(out, declared.name), pool, recordings=recordings,
        models=model or (), only=only, settings=assignments or (), repeats=repeats, seed=seed, eyes=eyes,
        pictures=None if pictures is None else folder_pictures(pictures),
    )  # fmt: skip
    if not quiet:
        tables.show(done)
    broken = print_troubles((verdict.id, verdict.trouble) for verdict in done.verdicts)
    return options.EXIT_FAILED if done.failures.height or broken else 0


def _repeat(context: typer.Context, run: Path, out: Path | None, workers: int | None, quiet: bool) -> int:
    """Do what a run was begun by once more, with your own files as they are at their places, into a new folder.

    Then every row is compared with the run's, and the first that differs is named. What computes otherwise than it
    did, such as a file that has changed, is named in a note.
    """
    from experiments.bench.compare import first_difference
    from experiments.bench.report.terminal import error_console, out_console
    from experiments.bench.result import load
    from experiments.bench.run import provenance
    from experiments.bench.run.command import begun_by
    from experiments.bench.run.description import ENDED

    there = load(run)
    command = there.description.get("command", {})
    name, *line = command.get("line", [command.get("call")])
    if name not in REPEATED:
        raise UsageError(f"{run}: a run of {name or there.kind} is not repeated; runs of {', '.join(REPEATED)} are")
    if there.done < there.planned and ENDED not in there.description:
        raise UsageError(f"{run}: is not finished: its own command with --out {run} goes on with it")
    folder = options.results_folder(out, f"again-{Path(there.name).stem}").absolute()
    options.check_new(folder)
    given = {"out": folder, "workers": workers, "quiet": quiet}
    with contextlib.chdir(command["folder"]), begun_by(command):
        if "line" in command:
            chosen = context.find_root().command.commands[name]  # type: ignore[attr-defined]
            with chosen.make_context(name, line, parent=context.parent) as inner:
                inner.params |= {key: value for key, value in {**NOT_REPEATED, **given}.items() if key in inner.params}
                status = int(chosen.invoke(inner) or 0)
        else:
            status = _call_again(run, {**command["arguments"], **given})
    here = load(folder)
    if other := provenance.difference(there.description, here.description):
        error_console.print(f"note: {run}: {other}")
    if difference := first_difference(there, here):
        out_console.print(f"differs: {difference}")
        return options.EXIT_FAILED
    rows = f"{there.trials.height:,} of trials and {there.frames.height:,} of frames"
    out_console.print(f"equal: every row of {run} ({rows})")
    return status


def _call_again(run: Path, arguments: dict[str, Any]) -> int:
    """Do a call of `experiments.run` once more."""
    import experiments
    from experiments.bench.sources.conditions import Hand
    from experiments.bench.sources.experiment import LIVE, visit

    experiment = arguments.pop("experiment")
    if isinstance(experiment, Mapping) and LIVE in experiment:
        experiment = visit(Hand(**experiment[LIVE]))
    elif isinstance(experiment, Mapping):
        raise UsageError(f"{run}: a script gave experiments.run an Experiment of its own: run the script")
    return options.EXIT_FAILED if experiments.run(experiment, **arguments).failures.height else 0


def watch(
    source: Annotated[
        str, typer.Argument(help="A video, a camera's index from 0, a folder of pictures or a stimulus.")
    ],
    model: options.Models = None,
    only: options.Only = False,
    assignments: options.Assignments = None,
    size: options.Size = None,
    fps: Annotated[float | None, typer.Option(help="Rate of the models; otherwise 30, whatever the source's.")] = None,
    seconds: Annotated[float | None, typer.Option(help="How much to show; otherwise all.")] = None,
    seed: options.Seed = 0,
    jitter: options.Jitter = 0.0,
    judge: Annotated[bool, typer.Option("--judge", help="Judge claim C12 by optical flow; takes longer.")] = False,
    out: options.Out = None,
    recordings: options.Recordings = True,
    view: Annotated[
        bool | None,
        typer.Option("--view/--no-view", help="Stream to a Rerun viewer; otherwise where there is a screen."),
    ] = None,
    quiet: options.Quiet = False,
) -> int:
    """Show a video, a camera, pictures or a stimulus to models, a step a frame, and say when what moved which way.

    The command's own model is dsnn. Models see 320 px along the longer side, of a stimulus its own size, or --size. A
    file is taken as fast as it decodes. Thresholds are the paper's off-line ones, which belong to 30 steps a second:
    responses grow with the square of the rate, so --fps changes what passes them.
    Exit status: 1 if a film ended early or a model failed, 130 if interrupted; what was seen until then is in the
    folder.
    """
    from colias_sim.gl import has_screen
    from experiments.bench import watch as watching
    from experiments.bench.cli import tables
    from experiments.bench.report import viewer
    from experiments.bench.run import interrupts

    if view:
        viewer.require_screen("watch: ", "give --no-view")
    trial = watching.plan(
        source, model or (), assignments or (), only=only, size=options.width_height(size), fps=fps,
        seconds=seconds, seed=seed, jitter_px=jitter, judge=judge,
    )  # fmt: skip
    folder = options.results_folder(out, "watch")
    wanted = has_screen() if view is None else view
    report = watching.run(trial, folder, recordings=recordings, view=wanted, quiet=quiet)
    if not quiet:
        tables.show_motion(report)
    failed = report.failures.height or report.description[watching.EARLY]
    return options.EXIT_FAILED if failed else interrupts.STATUS if trial.condition.stopped else 0


def live(
    model: options.Models = None,
    only: options.Only = False,
    assignments: options.Assignments = None,
    seed: options.Seed = 0,
    port: Annotated[int, typer.Option(min=1, max=65535, help="Of the page, on this machine.")] = 8099,
) -> int:
    """Show a trial while it runs, in a page: the camera's frame, HS and VS against T, spikes, and what a frame costs.

    Keys I and K drive the stimulus ahead and back, J and L turn it, X stops it; with shift they drive the observer.
    Space pauses, N is one frame, R begins again, C records. The model's parameters are sliders.

    A recording is a run of the trial since it began, which colias run --again repeats bit for bit. Without --model
    the DSNN is shown. Open the address that it prints in a browser; Ctrl-C ends it. Needs viser: the extra [live].
    """
    from experiments.bench.live.page import Page
    from experiments.bench.live.session import Session
    from experiments.bench.run.models import shown_models
    from experiments.bench.run.play import one_thread
    from experiments.bench.run.settings import check_counts

    check_counts(seed)
    page = Page(Session(shown_models(["dsnn"], model, only), assignments or (), seed), port)
    with one_thread():
        page.serve()
    return 0


def behave(
    names: Annotated[list[str], typer.Argument(metavar="NAME...", help="Behaviours, a group, .py files or policies.")],
    env: Annotated[str | None, typer.Option(help="Avoidance, Fixation, Optomotor or Pursuit.")] = None,
    episodes: Annotated[int, typer.Option(help="Episodes of each behaviour, at as many seeds.")] = 20,
    seed: options.Seed = 0,
    assignments: options.Assignments = None,
    baselines: Annotated[bool, typer.Option(help="Play the baselines in the same worlds too.")] = True,
    out: options.Out = None,
    recordings: options.Recordings = True,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    quiet: options.Quiet = False,
) -> int:
    """Play behaviours' episodes, and those of their baselines in the same worlds, and score them with intervals.

    Behaviours and groups are those of colias list behaviours; a policy (.npz) plays under the eye, wheels and
    randomisation that it was trained with. --set sets an argument of the env: robots=5. Equal seeds are equal worlds,
    whoever plays in them. Where collisions count, behaviours are compared with the first one, whose episodes are
    recorded.
    """
    from experiments.bench import behave as behaving
    from experiments.bench.report import behaviours
    from experiments.bench.report.terminal import count, show_files, show_verdicts

    batch = behaving.plan(names, env, assignments or (), episodes, seed, baselines=baselines)
    folder = options.results_folder(out, f"behave-{Path(names[0]).stem}")
    pool = options.pool(workers, cluster, quiet)
    with pool.running():
        report = behaving.run(batch, folder, pool, recordings=episodes if recordings else 0)
    if not quiet and report.done:
        where, changed = batch.description["env"], batch.description["options"]
        behaviours.show(report.summary, behaviours.caption(where, changed, episodes, seed))
        show_verdicts(report.verdicts)
        show_files(folder, count(report.trials.height, "episode"))
    return options.EXIT_FAILED if report.failures.height else 0


def train(
    env: Annotated[str, typer.Option(help="Optomotor or Fixation.")] = "Optomotor",
    steps: Annotated[int, typer.Option(min=1, max=10**8, help="Steps of all envs together.")] = 40_960,
    seed: options.Seed = 0,
    envs: Annotated[int, typer.Option(min=1, max=64, help="Envs that are stepped together.")] = 8,
    seeds: Annotated[int, typer.Option(min=1, max=100, help="Training seeds, from --seed up.")] = 1,
    assignments: options.Assignments = None,
    out: options.Out = None,
    workers: options.Workers = None,
    quiet: options.Quiet = False,
) -> int:
    """Train a small network on neural observations by PPO, and compare it with reflexes, rest, chance and truth.

    Needs stable-baselines3 and PyTorch (make train sets them up). The folder gets policy-SEED.npz and
    learning-SEED.csv of each training seed, and a run of the episodes that judged it, in worlds not trained in. On
    one version of PyTorch, equal seeds, --steps and --envs give equal policies. colias behave FILE plays one. --set
    sets camera, robot, noise or randomise: camera=ov7670.
    """
    from experiments.bench import train as training
    from experiments.bench.report import behaviours
    from experiments.bench.report.terminal import count, show_files

    policies = training.plan(env, steps, seed, envs, seeds, assignments or ())
    folder = options.results_folder(out, f"train-{env}")
    report, table = training.run(policies, folder, options.pool(workers, None, quiet))
    if not quiet and report.done:
        title = training.described(policies)
        behaviours.show(table, f"{title}. {training.OF_SEEDS}" if seeds > 1 else title)
        show_files(folder, count(seeds, "training seed"))
    return options.EXIT_FAILED if report.failures.height else 0
