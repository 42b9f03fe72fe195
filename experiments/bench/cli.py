"""The command line. Heavy imports happen inside the commands, so that help answers at once."""

from __future__ import annotations

if __name__ == "__main__":  # python -m experiments.bench.cli: before anything heavier is imported
    from experiments.bench import entry

    entry.main()

import datetime
import logging
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.markup import escape
from typer.core import TyperGroup

from experiments.bench import cli_behave, cli_leaderboard, cli_offline, cli_train, cli_tune, cli_watch, entry
from experiments.bench.options import (
    Assignments,
    Cluster,
    Models,
    Only,
    OtherCode,
    Quiet,
    Repeats,
    Seed,
    Workers,
    worker_count,
)

if TYPE_CHECKING:
    from experiments.bench.plan import Plan

EXIT_FAILED = 1


class _Interrupted(BaseException):
    """Ctrl-C on its way through the parser, which would print an empty line for it."""


class _Commands(TyperGroup):
    """All commands."""

    def invoke(self, ctx: typer.Context) -> Any:  # type: ignore[override]
        """Run the one that was asked for."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            raise _Interrupted from None


app = typer.Typer(
    cls=_Commands,
    rich_markup_mode="rich",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="""A simulated [b]Colias[/b] micro-robot testbed for fly-inspired motion vision.

Two robots in MuJoCo: the [b]observer[/b] looks through its 99x72 camera and
runs the DSNN on every frame, the black [b]stimulus[/b] drives past it. Every
trial is recorded for Rerun, summarised, drawn, and held against what the
paper (Fu, Bellotto and Yue 2018) reports.

[b]Examples[/b]

  colias run speed                   the paper's speed tests, 40 trials
  colias run distance --repeats 3 --seed 7
  colias run speed --set experiment.direction=both --set dsnn.n_con=6
  colias run general --model dsnn --model dsn2017 --model my_model.py
  colias run my_experiment.py        your own declaration
  colias run speed --resume runs/speed-...     just what is missing
  colias sweep speed --over dsnn.n_con=4,6,8 --over dsnn.d=1,2
  colias run clean                   the paper's off-line clips, to the DSNN
  colias watch street.mp4            any footage, or a camera
  colias reproduce                   which of the paper's claims hold
  colias leaderboard                 every model on the same trials
  colias tune --model emd --only     response against speed, size, direction ...
  colias behave hybrid               close the loop: reflexes in an env, scored
  colias parameters                  everything that --set reaches
  colias view runs/speed-...         a run's recordings in Rerun

[b]What a run leaves in its folder[/b]

  trials.parquet     a row per trial     summary.csv     a row per condition
  frames.parquet     a row per frame     claims.json     the verdicts
  experiment.json    every parameter, the seed, the versions
  figure.svg, .png   spikes per condition, every repeat visible
  recordings/        one .rrd per trial

Equal seeds and parameters give equal numbers, on any number of workers. Exit
status: 0 done, 1 trials failed, 2 a wrong use or a missing library, 130
interrupted.""",
)

out_console = Console(highlight=False)
error_console = Console(stderr=True, highlight=False)


@app.command(short_help="Run an experiment: trials, recordings, tables, figure, verdicts.")
def run(
    experiment: Annotated[str, typer.Argument(help="A name that [b]colias list[/b] shows, or the path of a .py file.")],
    repeats: Repeats = None,
    seed: Seed = 0,
    out: Annotated[Path | None, typer.Option(help="New folder for the results; otherwise runs/NAME-TIME.")] = None,
    resume: Annotated[
        Path | None, typer.Option(help="Go on with the run in this folder: do just what is missing.")
    ] = None,
    assignments: Assignments = None,
    model: Models = None,
    only: Only = False,
    recordings: Annotated[bool, typer.Option(help="Write a Rerun recording of each trial.")] = True,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    quiet: Quiet = False,
) -> int:
    """Run an experiment and write its results into a folder.

    Every model sees the same frames. The command's own model is dsnn, or those that an off-line experiment
    declares. Trials already finished stay readable if the run is interrupted, and
    --resume with the same parameters does the rest. Results do not depend on the number of workers.
    """
    from experiments.bench import catalogue, console, settings
    from experiments.bench.files import UsageError
    from experiments.bench.model_option import shown_models
    from experiments.bench.offline import OfflineExperiment

    declared = catalogue.find(experiment)
    if resume is not None and out is not None:
        raise UsageError("--out and --resume name one folder each: give one of them")
    means = console.Means(worker_count(workers), cluster, quiet, other_code)
    if isinstance(declared, OfflineExperiment):
        models = shown_models(declared.models, model, only)
        return cli_offline.run(declared, repeats, seed, out, resume, assignments or (), models, means, recordings)
    plan = settings.plan(declared, shown_models(["dsnn"], model, only), assignments or (), repeats, seed)
    _note_rates(plan)
    stamp = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    folder = resume or out or Path("runs") / f"{declared.name}-{stamp}"
    report = console.run(plan, folder, means, resume is not None, recordings)
    return EXIT_FAILED if report.failures else 0


@app.command(short_help="Run an experiment over a grid of parameters, on the same stimuli.")
def sweep(
    experiment: Annotated[str, typer.Argument(help="A name that [b]colias list[/b] shows, or the path of a .py file.")],
    over: Annotated[list[str], typer.Option(metavar="KEY=V1,V2", help="Values of a parameter. Repeatable: a grid.")],
    repeats: Repeats = None,
    seed: Seed = 0,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results, otherwise runs/sweep-NAME-TIME; goes on with one begun.")
    ] = None,
    assignments: Assignments = None,
    model: Models = None,
    only: Only = False,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    quiet: Quiet = False,
) -> int:
    """Run every combination of the values; tabulate (sweep.csv) and draw (figure.svg, .png) them together.

    Equal trials of different points have equal seeds: the same stimuli, start poses and noise. KEY may be a parameter
    of any model shown; models that a point does not vary ride along. The command's own model is dsnn.
    """
    from experiments.bench import catalogue, console
    from experiments.bench import sweep as grids
    from experiments.bench.model_option import shown_models

    declared = catalogue.load(experiment)
    points = grids.grid(over)
    models = shown_models(["dsnn"], model, only)
    parts = grids.parts(declared, models, points, assignments or (), repeats, seed)
    stamp = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    folder = out or Path("runs") / f"sweep-{declared.name}-{stamp}"
    means = console.Means(worker_count(workers), cluster, quiet, other_code)
    return EXIT_FAILED if console.sweep(parts, points, declared.varies, folder, means) else 0


@app.command(short_help="Run the paper's experiments and report which claims hold.")
def reproduce(
    quick: Annotated[
        bool,
        typer.Option(
            "--quick", help="A taste: two seeds, no moves, no grids of clips; the report names what it does not judge."
        ),
    ] = False,
    full: Annotated[
        bool, typer.Option("--full", help="Ten repeats at every seed and move: takes several times as long.")
    ] = False,
    robot_only: Annotated[
        bool, typer.Option("--robot-only", help="Just the paper's trials with the robot: neither clips nor behaviours.")
    ] = False,
    seed: Seed = 0,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the report, otherwise runs/reproduce-TIME; goes on with one begun.")
    ] = None,
    model: Models = None,
    only: Only = False,
    experiment: Annotated[
        list[str] | None, typer.Option(help="An experiment to add: a name or a .py file. Repeatable.")
    ] = None,
    other_code: OtherCode = False,
    workers: Workers = None,
    cluster: Cluster = None,
    quiet: Quiet = False,
) -> None:
    """Run the paper's experiments, the robot's at other seeds and with everything moved too; write one page about it.

    The command's own models, in the trials with the robot, are dsnn and dsn2017, beside the looming detectors where a
    claim is about them. Most claims are about dsnn: --only needs it among the models.
    The reflexes of [b]colias behave[/b] are played too, and claims of our own about them judged. report.html needs no
    network; claims.json and behaviours.json have the verdicts. The exit status is 0 whatever they are.
    """
    from experiments.bench import console, console_behave, settings
    from experiments.bench.files import UsageError

    if quick and full:
        raise UsageError("--quick and --full: give one of them")
    settings.check_counts(seed)
    means = console.Means(worker_count(workers), cluster, quiet, other_code)
    from experiments.bench import report
    from experiments.bench import reproduce as whole

    scale = whole.QUICK if quick else whole.FULL if full else whole.USUAL
    stamp = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    folder = out or Path("runs") / f"reproduce-{stamp}"
    models = whole.models_shown(model, only)
    result = whole.reproduce(folder, scale, seed, models, means, experiment or (), robot_only, only)
    page = report.write(result)
    if not quiet:
        console.show_claims(result.claims)
        console_behave.show_claims(result.own_claims)
        out_console.print(f"\nreport      {page}", soft_wrap=True, markup=False)


def _note_rates(plan: Plan) -> None:
    rate = plan.settings.camera.fps
    for chosen in plan.settings.models:
        assumed = getattr(chosen.network, "fps", rate)
        if assumed != rate:
            said = f"note: {chosen.label} assumes {assumed:g} frames/s, the camera gives {rate:g}"
            error_console.print(said, soft_wrap=True, markup=False)


cli_watch.register(app)
cli_leaderboard.register(app)
cli_tune.register(app)
cli_train.register(app)
cli_behave.register(app)


@app.command("list", short_help="Name the experiments, models, scenes, stimuli, envs, behaviours.")
def list_all() -> None:
    """Name what there is to run: experiments, vision models, arenas, stimuli, envs, behaviours."""
    from colias_sim.envs import ENVS
    from dsnn import MODELS
    from dsnn.stimuli import STIMULI
    from experiments import NAMES, OFFLINE
    from experiments.behaviours import BEHAVIOURS
    from experiments.bench import catalogue
    from scenes import ARENAS

    experiments = {name: catalogue.find(name).summary for name in (*NAMES, *OFFLINE)}
    models = {name: entry.summary for name, entry in MODELS.items()}
    stimuli = {name: entry.summary for name, entry in STIMULI.items()}
    envs = {name.partition("/")[2]: entry.summary for name, entry in ENVS.items()}
    behaviours = {name: entry.summary for name, entry in BEHAVIOURS.items()}
    kinds = {
        "experiments": experiments, "models": models, "scenes": ARENAS, "stimuli": stimuli, "envs": envs,
        "behaviours": behaviours,
    }  # fmt: skip
    for title, items in kinds.items():
        out_console.print(f"[b]{title}[/b]")
        for name, summary in items.items():
            out_console.print(f"  {name:<20}{summary}", soft_wrap=True)


@app.command(short_help="List every parameter that --set reaches.")
def parameters(
    experiment: Annotated[str, typer.Argument(help="The experiment whose parameters to list.")] = "speed",
    model: Models = None,
    only: Only = False,
) -> None:
    """List every parameter that --set reaches: key, default, legal range, meaning. The command's own model is dsnn."""
    from experiments.bench import catalogue, settings
    from experiments.bench.model_option import shown_models

    for row in settings.parameters(catalogue.load(experiment), shown_models(["dsnn"], model, only)):
        legal = f"  [dim]({escape(row.legal)})[/dim]" if row.legal else ""
        out_console.print(f"{row.key}=[b]{escape(row.value)}[/b]{legal}\n    {escape(row.description)}", soft_wrap=True)


@app.command(short_help="Open recordings in Rerun, or a scene in MuJoCo's viewer.")
def view(
    path: Annotated[Path, typer.Argument(help="A run's folder, one .rrd file, or a scene's name.")],
    web: Annotated[bool, typer.Option("--web", help="Serve the viewer to a browser on this machine.")] = False,
) -> int:
    """Open recordings in the Rerun viewer, which listens on 127.0.0.1 only; or a scene in MuJoCo's own viewer.

    The viewer, or with --web its server, ends with this command.
    """
    from experiments.bench import viewer
    from experiments.bench.files import UsageError
    from scenes import ARENAS

    if str(path) in ARENAS and not path.exists():
        _view_scene(str(path))
        return 0
    files = [path] if path.is_file() else sorted([*path.glob("*.rrd"), *path.glob("recordings/*.rrd")])
    if not files:
        raise UsageError(f"{path}: no such file, or no .rrd recordings in it")
    if not web:
        viewer.require_screen(f"view {path}: ", "use --web")
    return viewer.show(files, web=web, instead="use --web")


def _view_scene(arena: str) -> None:
    """Both robots in the arena, live, in MuJoCo's viewer."""
    import mujoco.viewer

    from colias_sim import CameraConfig, RobotConfig, SceneConfig
    from colias_sim.scene import compose
    from colias_sim.simulation import TRIAL_ROBOTS
    from experiments.bench.files import UsageError

    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise UsageError(f"view {arena}: MuJoCo's viewer needs a screen (DISPLAY is not set)")
    spec = compose(SceneConfig(arena=arena), RobotConfig(), CameraConfig(), TRIAL_ROBOTS, "observer")
    spec.body("stimulus/base").pos = [0.10, 0.05, 0.0]
    mujoco.viewer.launch(spec.compile())


cli_offline.register(app)


def command(arguments: list[str]) -> int:
    """Do what a command line asks for, and return the exit status. Raises `UsageError` for what it cannot mean."""
    # What it says of folders and fonts that it would like is no matter of a run's.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    try:
        # Not standalone, so that the parser's own complaints come out as one line too.
        return int(app(args=arguments, standalone_mode=False) or 0)
    except (_Interrupted, typer.Abort):
        raise KeyboardInterrupt from None
    except typer.TyperException as error:
        from experiments.bench.files import UsageError

        raise UsageError(" ".join(error.format_message().split())) from None


def run_file(path: str) -> NoReturn:
    """What ``python experiments/NAME.py [OPTIONS]`` does: ``colias run`` on that file."""
    entry.run_file(path)


def main() -> NoReturn:
    """The command line of ``sys.argv``, in a process that has seen to its own signals and streams."""
    entry.run()
