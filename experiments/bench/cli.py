"""The command line. Heavy imports happen inside the commands, so that help answers at once."""

from __future__ import annotations

import datetime
import os
import shlex
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

if TYPE_CHECKING:
    from experiments.bench.plan import Plan
    from experiments.bench.runner import Report

EXIT_USAGE, EXIT_INTERRUPTED = 2, 130
LINE_EVERY_S = 60.0  # progress where there is no terminal to draw a bar on

app = typer.Typer(
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
  colias run speed --set experiment.direction=both
  colias run speed --set dsnn.n_con=6 --set camera.read_noise=0
  colias run my_experiment.py        your own declaration
  colias parameters                  everything that --set reaches
  colias view runs/speed-...         a run's recordings in Rerun

[b]What a run leaves in its folder[/b]

  trials.parquet     a row per trial     summary.csv     a row per condition
  frames.parquet     a row per frame     claims.json     the verdicts
  experiment.json    every parameter, the seed, the versions
  figure.svg, .png   spikes per condition, every repeat visible
  recordings/        one .rrd per trial

Equal seeds and parameters give equal numbers. Exit status: 0 done, 2 a wrong
use or a missing library, 130 interrupted.""",
)

out_console = Console(highlight=False)
error_console = Console(stderr=True, highlight=False)


@app.command(short_help="Run an experiment: trials, recordings, tables, figure, verdicts.")
def run(
    experiment: Annotated[str, typer.Argument(help="A name that [b]colias list[/b] shows, or the path of a .py file.")],
    repeats: Annotated[
        int | None, typer.Option(help="Trials of each condition; otherwise the experiment's own number.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the whole run, 0 or more.")] = 0,
    out: Annotated[Path | None, typer.Option(help="New folder for the results; otherwise runs/NAME-TIME.")] = None,
    assignments: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help="Set a parameter; see [b]colias parameters[/b]. Repeatable."),
    ] = None,
    model: Annotated[str, typer.Option(help="The vision model on the observer.")] = "dsnn",
    recordings: Annotated[bool, typer.Option(help="Write a Rerun recording of each trial.")] = True,
) -> None:
    """Run an experiment and write its results into a folder.

    Trials already finished stay readable if the run is interrupted.
    """
    from experiments.bench import catalogue, settings
    from experiments.bench.plan import Plan, check

    declared = catalogue.load(experiment)
    count = declared.repeats if repeats is None else repeats
    if count < 1:
        raise settings.UsageError(f"--repeats {count}: legal is a whole number from 1 up")
    if seed < 0:
        raise settings.UsageError(f"--seed {seed}: legal is a whole number from 0 up")
    declared, chosen = settings.configure(declared, model, assignments or ())
    rate, assumed = chosen.camera.fps, getattr(chosen.network, "fps", chosen.camera.fps)
    if assumed != rate:
        error_console.print(f"note: the network assumes {assumed:g} frames/s, the camera gives {rate:g}")
    stamp = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    plan = Plan(declared, chosen, count, seed)
    check(plan)
    _run(plan, out or Path("runs") / f"{declared.name}-{stamp}", recordings)


def _run(plan: Plan, out: Path, recordings: bool) -> None:
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from experiments.bench.plan import describe
    from experiments.bench.results import RunFolder
    from experiments.bench.runner import run as run_plan
    from experiments.bench.trial import TrialResult

    folder = RunFolder(out)
    folder.create(describe(plan))
    total, done, told = len(plan.specs()), 0, time.monotonic()
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    if not error_console.is_terminal:
        error_console.print(f"{plan.experiment.name}: {total} trials into {out}", soft_wrap=True, markup=False)
    with Progress(*columns, console=error_console, transient=True) as progress:
        task = progress.add_task(f"{plan.experiment.name}: trials", total=total)

        def on_trial(result: TrialResult) -> None:
            nonlocal done, told
            done += 1
            progress.advance(task)
            if not error_console.is_terminal and time.monotonic() - told > LINE_EVERY_S:
                told = time.monotonic()
                error_console.print(f"{done} of {total} trials")

        try:
            report = run_plan(plan, folder, on_trial, recordings=recordings)
        except BaseException:
            progress.stop()
            said = f"stopped after {done} of {total} trials; they are in {out}"
            error_console.print(said, soft_wrap=True, markup=False)
            raise
    _show(report, recordings)


def _show(report: Report, recordings: bool) -> None:
    """The table of conditions, the verdicts, and where everything is."""
    table = Table(title="HS spikes per trial", title_justify="left", box=None, header_style="bold", pad_edge=False)
    for name in ("direction", "cm/s", "cm", "n", "mean", "95 % interval", "rate Hz", "peak HS", "trough HS"):
        table.add_column(name, justify="left" if name == "direction" else "right", no_wrap=True)
    for (direction, speed, distance), rows in _conditions(report).items():
        spikes = rows["spikes"]
        table.add_row(
            direction,
            f"{speed:g}",
            f"{distance:g}",
            f"{spikes['n']}",
            f"{spikes['mean']:.1f}",
            "-" if spikes["ci_low"] is None else f"{spikes['ci_low']:.1f} .. {spikes['ci_high']:.1f}",
            f"{rows['firing_rate_hz']['mean']:.1f}",
            f"{rows['peak_hs']['mean']:+.2f}",
            f"{rows['trough_hs']['mean']:+.2f}",
        )
    out_console.print(table)
    for verdict in report.verdicts:
        colour = {"holds": "green", "fails": "red", "untested": "yellow"}[verdict.verdict]
        out_console.print(f"\n[b]{verdict.id}[/b] [{colour}]{verdict.verdict}[/{colour}]: {verdict.says}")
        out_console.print(f"    {verdict.measured}" + (f"\n    {verdict.effect}" if verdict.effect else ""))
    if report.flaws:
        out_console.print(f"\n[red]beware[/red]: {report.flaws}")
    places: dict[str, object] = {"figure": report.folder / "figure.png", "tables": report.folder / "trials.parquet"}
    if recordings:
        places["recordings"] = f"colias view {shlex.quote(str(report.folder))}"
    out_console.print()
    for name, place in places.items():
        out_console.print(f"{name:<12}{place}", soft_wrap=True, markup=False)


def _conditions(report: Report) -> dict[tuple[str, float, float], dict[str, dict[str, Any]]]:
    """Condition -> quantity -> its row of the summary."""
    conditions: dict[tuple[str, float, float], dict[str, dict[str, Any]]] = {}
    for row in report.summary:
        key = (row["direction"], row["speed_cm_s"], row["distance_cm"])
        conditions.setdefault(key, {})[row["quantity"]] = row
    return conditions


@app.command("list", short_help="Name the experiments, models and scenes.")
def list_all() -> None:
    """Name what there is to run: experiments, vision models, arenas."""
    from dsnn import MODELS
    from experiments import NAMES
    from experiments.bench import catalogue
    from scenes import ARENAS

    experiments = {name: catalogue.load(name).summary for name in NAMES}
    models = {name: entry.summary for name, entry in MODELS.items()}
    for title, items in (("experiments", experiments), ("models", models), ("scenes", ARENAS)):
        out_console.print(f"[b]{title}[/b]")
        for name, summary in items.items():
            out_console.print(f"  {name:<16}{summary}", soft_wrap=True)


@app.command(short_help="List every parameter that --set reaches.")
def parameters(
    experiment: Annotated[str, typer.Argument(help="The experiment whose parameters to list.")] = "speed",
    model: Annotated[str, typer.Option(help="The vision model on the observer.")] = "dsnn",
) -> None:
    """List every parameter that --set reaches: key, default, legal range, meaning."""
    from experiments.bench import catalogue, settings

    for row in settings.parameters(catalogue.load(experiment), model):
        legal = f"  [dim]({row.legal})[/dim]" if row.legal else ""
        out_console.print(f"{row.key}=[b]{row.value}[/b]{legal}\n    {row.description}", soft_wrap=True)


@app.command(short_help="Open recordings in Rerun, or a scene in MuJoCo's viewer.")
def view(
    path: Annotated[Path, typer.Argument(help="A run's folder, one .rrd file, or a scene's name.")],
    web: Annotated[bool, typer.Option("--web", help="Serve the viewer to a browser on this machine.")] = False,
) -> None:
    """Open recordings in the Rerun viewer, which listens on 127.0.0.1 only; or a scene in MuJoCo's own viewer."""
    from experiments.bench.settings import UsageError
    from scenes import ARENAS

    if str(path) in ARENAS and not path.exists():
        return _view_scene(str(path))
    files = [path] if path.is_file() else sorted([*path.glob("*.rrd"), *path.glob("recordings/*.rrd")])
    if not files:
        raise UsageError(f"{path}: no such file, or no .rrd recordings in it")
    command = [sys.executable, "-m", "rerun", "--bind", "127.0.0.1"]
    if web:
        command.append("--web-viewer")
    raise typer.Exit(subprocess.run([*command, *map(str, files)], check=False).returncode)


def _view_scene(arena: str) -> None:
    """Both robots in the arena, live, in MuJoCo's viewer."""
    import mujoco.viewer

    from colias_sim import CameraConfig, RobotConfig, SceneConfig
    from colias_sim.scene import compose
    from colias_sim.simulation import TRIAL_ROBOTS
    from experiments.bench.settings import UsageError

    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise UsageError(f"view {arena}: MuJoCo's viewer needs a screen (DISPLAY is not set)")
    spec = compose(SceneConfig(arena=arena), RobotConfig(), CameraConfig(), TRIAL_ROBOTS, "observer")
    spec.body("stimulus/base").pos = [0.10, 0.05, 0.0]
    mujoco.viewer.launch(spec.compile())


def run_file(path: str) -> None:
    """What ``python experiments/NAME.py [OPTIONS]`` does: ``colias run`` on that file."""
    sys.argv[1:1] = ["run", path]
    main()


def main() -> None:
    """Entry point: a wrong use or a missing library ends in one line on stderr and a non-zero status."""
    try:
        # Not standalone, so that the parser's own complaints come out as one line too.
        sys.exit(app(args=sys.argv[1:] or ["--help"], standalone_mode=False))
    except (KeyboardInterrupt, typer.Abort):
        sys.exit(EXIT_INTERRUPTED)
    except typer.TyperException as error:
        _fail(" ".join(error.format_message().split()))
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)
    except Exception as error:
        if not _is_plain(error):
            raise
        _fail(f"{error.filename}: {error.strerror}" if isinstance(error, OSError) and error.filename else str(error))


def _is_plain(error: Exception) -> bool:
    """Whether the message alone tells a user what to do; anything else is a defect and keeps its traceback."""
    if isinstance(error, OSError):  # a missing OpenGL too, whose package cannot then be imported to ask
        return True
    from experiments.bench.settings import UsageError
    from experiments.bench.trial import TrialError

    return isinstance(error, UsageError | TrialError)


def _fail(text: str) -> None:
    print(f"colias: {text}", file=sys.stderr)
    sys.exit(EXIT_USAGE)


if __name__ == "__main__":
    main()
