"""The command line: every command of ``colias``. Heavy imports happen inside the commands, so that help is quick."""

from __future__ import annotations

import logging
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from experiments.bench.cli import (
    behave,
    camera,
    check,
    clips,
    compare,
    doctor,
    export,
    firmware,
    leaderboard,
    listing,
    maps,
    measured,
    reproduce,
    run,
    runs,
    study,
    train,
    tune,
    video,
    view,
    watch,
)

COMMANDS = (
    run, maps, study, reproduce, watch, check, leaderboard, tune, train, behave, firmware, listing, runs, compare, view,
    video, measured, camera, export, clips, doctor,
)  # fmt: skip
"""The modules of the commands, in the order in which help shows them."""


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
    add_completion=True,
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
  colias map speed --over dsnn.n_con=4,6,8 --measure spikes
  colias study fidelity              which claims survive the robot's eye
  colias map general --over experiment.acceleration_cm_s2=10,17,25
                                     where which claims hold
  colias run clean                   the paper's off-line clips, to the DSNN
  colias watch street.mp4            any footage, or a camera
  colias reproduce                   which of the paper's claims hold
  colias check my_model.py           does a model keep the laws of all models
  colias leaderboard                 every model on the same trials
  colias tune --model emd --only     response against speed, size, direction ...
  colias behave hybrid               close the loop: reflexes in an env, scored
  colias firmware budget             what the network takes of the robot's chip
  colias parameters                  everything that --set reaches
  colias view runs/speed-...         a run's recordings in Rerun
  colias video runs/speed-... --out trial.mp4
                                     a recording as a video, GIF or strip
  colias runs                        the runs so far: what, changed, verdicts
  colias compare runs/A runs/B       how two runs differ, pair by pair
  colias import log.csv              a real robot's log as a run
  colias export runs/A --to csv      tables and frames for other programs
  colias doctor                      does this machine have what is needed?

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

for _module in COMMANDS:
    _module.register(app)


def _tell_version(wanted: bool) -> None:
    """Print the version, and the commit where it is known; then there is nothing else to do."""
    if not wanted:
        return
    from importlib.metadata import version

    from experiments.bench.store.provenance import checkout

    commit, dirty = checkout()
    changed = " with changes" if dirty else ""
    typer.echo(f"colias-sim {version('colias-sim')}{f', commit {commit[:12]}{changed}' if commit else ''}")
    raise typer.Exit


@app.callback()
def _whole(
    version: Annotated[
        bool, typer.Option("--version", help="Print the version and the commit.", callback=_tell_version, is_eager=True)
    ] = False,
) -> None:
    """Take the options of ``colias`` itself."""


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
        from experiments.bench.engine.errors import UsageError

        raise UsageError(" ".join(error.format_message().split())) from None
