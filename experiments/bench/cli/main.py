"""The command line: every command of ``colias``. Heavy imports happen inside the commands, so that help is quick."""

from __future__ import annotations

import inspect
import logging
from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from experiments.bench.cli import analyse, live, own, robot, run, see, watch

GROUPS: Mapping[str, Mapping[str, tuple[Any, str]]] = {
    "run": {
        "run": (run.run, "Run an experiment: trials, recordings, tables, figure, verdicts"),
        "watch": (watch.watch, "Show a video, a camera or a stimulus to models"),
        "live": (live.live, "Drive the stimulus by hand in a browser"),
        "behave": (run.behave, "Play behaviours in an env, scored against baselines"),
        "train": (run.train, "Train policies on neural observations by PPO"),
    },
    "analyse": {
        "reproduce": (analyse.reproduce, "Run the paper's experiments and report which claims hold"),
        "sweep": (analyse.sweep, "Judge claims over a grid of parameters, in replicates"),
        "fit": (analyse.fit, "Search for parameters under which claims hold"),
        "leaderboard": (analyse.leaderboard, "Rank models on the same trials and clips"),
        "tune": (analyse.tune, "Measure tuning curves: speed, size, contrast, direction, ..."),
    },
    "see": {
        "view": (see.view, "Open recordings in Rerun, or a scene in MuJoCo's viewer"),
        "video": (see.video, "Make a video, a GIF, a strip or pictures of a recording"),
        "list": (see.list_names, "Name experiments, models, stimuli, claims, parameters, runs"),
    },
    "make your own": {
        "new": (own.new, "Write a model, an experiment, a claim, ... to begin with"),
        "check": (own.check, "Try the laws of every model, stimulus or arena on yours"),
    },
    "robot": {
        "firmware": (robot.app, "Budget, check, export and logs of the chip's program"),
        "import": (robot.import_log, "Make a run of a real robot's log"),
        "camera": (robot.camera, "Measure a real camera from its frames"),
        "doctor": (robot.doctor, "Look at what this machine has of what the bench needs"),
    },
}
"""Heading -> command -> what does it, and its line of help, in the order in which help shows them."""
EXAMPLES = """\
  colias run speed                     the paper's speed trials, into runs/speed-TIME
  colias view runs/speed-TIME          their recordings, in Rerun
  colias reproduce --quick             which of the paper's claims hold"""
RENAMED = {
    "cite": "CITATION.cff",
    "compare": "experiments.compare(A, B) in Python",
    "export": "colias video RUN --out FOLDER for frames, colias firmware log for a robot's log; tables are Parquet",
    "map": "colias sweep",
    "parameters": "colias list parameters",
    "play": "colias watch STIMULUS",
    "rerun": "colias run --again",
    "runs": "colias list runs",
    "stimulus": "colias video STIMULUS --out NAME.avi, and colias list parameters STIMULUS",
    "study": "colias sweep",
}
"""Old command -> what does its work."""


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

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help of one screen."""
        lines = [
            "Usage: colias COMMAND [OPTIONS]", "",
            "A simulated Colias micro-robot testbed for fly-inspired motion vision.", "", EXAMPLES, "",
        ]  # fmt: skip
        for heading, entries in GROUPS.items():
            lines += [heading, *(f"  {name:<12} {text}" for name, (_, text) in entries.items())]
        lines += ["", "colias COMMAND --help has all of a command. --version; --install-completion."]
        formatter.write("\n".join(lines) + "\n")


app = typer.Typer(
    cls=_Commands,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)


def _register() -> None:
    """Put every command into the app."""
    for entries in GROUPS.values():
        for name, (command, text) in entries.items():
            if isinstance(command, typer.Typer):
                app.add_typer(command, name=name, short_help=text)
                _unwrap(command)
            else:
                app.command(name, short_help=text)(command)
    _unwrap(app)
    for old in RENAMED:
        app.command(old, hidden=True, context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(
            _renamed
        )


def _renamed(context: typer.Context) -> int:
    from experiments.bench.run.errors import UsageError

    raise UsageError(f"colias {context.info_name}: it is {RENAMED[str(context.info_name)]} now")


def _unwrap(commands: typer.Typer) -> None:
    """Join the lines of each paragraph of help: the parser keeps line ends, and terminals differ in width."""
    for entry in commands.registered_commands:
        paragraphs = inspect.cleandoc(entry.help or getattr(entry.callback, "__doc__", None) or "").split("\n\n")
        entry.help = "\n\n".join(" ".join(paragraph.split()) for paragraph in paragraphs)


_register()


def _tell_version(wanted: bool) -> None:
    """Print the version, and the commit where it is known; then there is nothing else to do."""
    if not wanted:
        return
    from importlib.metadata import version

    from experiments.bench.run.provenance import checkout

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


@cache
def parser() -> Any:
    """Return all commands with their options: made once in a process, as that takes as long as a trial."""
    return typer.main.get_command(app)


def command(arguments: list[str]) -> int:
    """Do what a command line asks for, and return the exit status. Raises `UsageError` for what it cannot mean."""
    # What it says of folders and fonts that it would like is no matter of a run's.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    from experiments.bench.run.command import begun_by

    try:
        # Not standalone, so that the parser's own complaints come out as one line too.
        with begun_by({"line": list(arguments)}):
            return int(parser()(args=arguments, standalone_mode=False) or 0)
    except (_Interrupted, typer.Abort):
        raise KeyboardInterrupt from None
    except typer.TyperException as error:
        from experiments.bench.run.errors import UsageError

        raise UsageError(" ".join(error.format_message().split())) from None
