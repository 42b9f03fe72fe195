"""The commands that run something: ``colias run``, ``watch``, ``live``, ``behave`` and ``train``.

Heavy imports happen when they run.
"""

import contextlib
import dataclasses
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from experiments.base import interrupts
from experiments.base.console import error_console, out_console
from experiments.base.errors import UsageError
from experiments.base.values import key_values
from experiments.cli import options
from experiments.kinds.tables import kind_of
from experiments.store.asked import ASKED, Asked, begun_by
from experiments.store.workers import Workers


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
    truth: Annotated[bool, typer.Option("--truth", help="Store what truly moved in each frame too.")] = False,
    controls: options.Controls = False,
    dry_run: options.DryRun = False,
    workers: options.Workers = None,
    cluster: options.Cluster = None,
    quiet: options.Quiet = False,
) -> int:
    """Run an experiment, and write tables, figure, verdicts and recordings into a folder.

    Every model sees the same frames: dsnn, or the models that the experiment declares. Finished trials are kept
    when a run is interrupted; the same command with that folder as --out does the rest.
    """
    from experiments.kinds import registry

    pool = options.pool(workers, cluster, quiet)
    if again is not None:
        if others := sorted(options.typed(context) - {"again", "out", "workers", "cluster", "quiet"}):
            raise UsageError(f"--again repeats a run as it was: leave out {', '.join(others)}")
        return _repeat(again, out, pool)
    if experiment is None:
        raise UsageError("colias run: give an experiment, or --again RUN")
    asked = Asked(
        kind=registry.find(experiment).kind, what=(experiment,), models=tuple(model or ()), only=only,
        values=key_values(assignments), repeats=repeats, seed=seed,
        options={"eyes": eyes, "recordings": recordings, "truth": truth, "controls": controls,
                 "pictures": pictures and str(pictures)},
    )  # fmt: skip
    return options.finish(asked, out, pool, dry=dry_run)


def _repeat(run: Path, out: Path | None, pool: Workers) -> int:
    """Do what was asked for once more, with your own files as they are at their places, into a new folder.

    Then every row is compared with the run's, and the first that differs by more than rounding is named. What computes
    otherwise than it did, such as a file that has changed or another CPU, is named in a note.
    """
    from experiments.base.files import results_folder
    from experiments.kinds.compare import ROUNDING, first_difference
    from experiments.kinds.result import load, perform, plan_of
    from experiments.store import provenance
    from experiments.store.folder import CPUS, ENDED

    there = load(run)
    if there.whole:
        raise UsageError(f"{run}: a {there.kind} is not repeated; repeat its parts")
    if there.done < there.planned and ENDED not in there.description:
        raise UsageError(f"{run}: is not finished: its own command with --out {run} goes on with it")
    folder = results_folder(out, f"again-{Path(there.name).stem}").absolute()
    options.check_new(folder)
    command, stored = command_and_asked(run, there.description)
    with contextlib.chdir(command["folder"]), begun_by(command):
        here = perform(plan_of(Asked.read(stored)), folder, pool)
    other = provenance.differences(provenance.moved(there.description, here.description), here.description)
    if other:
        error_console.print(f"note: {run}: {' and '.join(f'{file} has changed' for file, *_ in other)}")
    before, now = (", or ".join(one.description.get(CPUS, ["unknown"])) for one in (there, here))
    if before != now:
        error_console.print(f"note: {run}: the features of its CPU are {before}; here they are {now}")
    if difference := first_difference(there, here, ROUNDING):
        out_console.print(f"differs: {difference}")
        return options.EXIT_FAILED
    rows = f"{there.trials.height:,} of trials and {there.frames.height:,} of frames"
    rounded = first_difference(there, here)
    out_console.print(f"equal{rounded and ' up to rounding'}: every row of {run} ({rows}){rounded and f'; {rounded}'}")
    return options.EXIT_FAILED if here.failures.height else 0


def command_and_asked(run: Path, description: Mapping[str, Any]) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    """Return a run's command and what was asked; where its folder is gone, as they are from where the run is now."""
    command, asked = description["command"], description[ASKED]
    if Path(then := command["folder"]).is_dir():
        return command, asked
    now = str((run / command["folder_from_run"]).resolve())
    there = json.loads(json.dumps([command, asked]).replace(f"{then}/", f"{now}/"))
    return {**there[0], "folder": now}, there[1]


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
    controls: options.Controls = False,
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
    from experiments.base.files import results_folder
    from experiments.draw import viewer
    from experiments.kinds.footage import EARLY, STOPPED
    from experiments.kinds.result import perform, plan_of

    if view:
        viewer.require_screen("watch: ", "give --no-view")
    given = {"size": options.width_height(size), "fps": fps, "seconds": seconds, "jitter_px": jitter, "judge": judge,
             "recordings": recordings, "controls": controls}  # fmt: skip
    asked = Asked(kind="watch", what=(source,), models=tuple(model or ()), only=only,
                  values=key_values(assignments), seed=seed, options=given)  # fmt: skip
    plan = dataclasses.replace(plan_of(asked), live=has_screen() if view is None else view)
    report = perform(plan, results_folder(out, "watch"), options.pool(0, None, quiet))
    if not quiet:
        kind_of(asked.kind).show(report)
    if report.failures.height or report.description[EARLY]:
        return options.EXIT_FAILED
    return interrupts.STATUS if report.description[STOPPED] else 0


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
    from experiments.live.page import Page
    from experiments.live.session import Session
    from experiments.settings.models import shown_models
    from experiments.settings.settings import check_counts
    from experiments.show.play import one_thread

    check_counts(seed)
    page = Page(Session(shown_models(["dsnn"], model, only), key_values(assignments), seed), port)
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
    controls: Annotated[
        bool, typer.Option("--controls", help="Play those named again, their vision model held at its first frame.")
    ] = False,
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
    asked = Asked(
        kind="episodes", what=tuple(names), values=key_values(assignments), repeats=episodes, seed=seed,
        options={"env": env, "baselines": baselines, "controls": controls, "recordings": recordings},
    )  # fmt: skip
    return options.finish(asked, out, options.pool(workers, cluster, quiet), f"behave-{Path(names[0]).stem}")


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
    asked = Asked(
        kind="training", what=(env,), values=key_values(assignments), seed=seed,
        options={"steps": steps, "envs": envs, "seeds": seeds},
    )  # fmt: skip
    return options.finish(asked, out, options.pool(workers, None, quiet), f"train-{env}")
