"""The command line: every command of ``colias``. Heavy imports happen inside the commands, so that help is quick."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from typing import Any

import typer
from typer.core import TyperGroup

from experiments.base.errors import UsageError
from experiments.cli import analyse, own, robot, run, see
from experiments.store.command import begun_by

GROUPS: Mapping[str, Mapping[str, tuple[Any, str]]] = {
    "run": {
        "run": (run.run, "Run an experiment: trials, recordings, tables, figure, verdicts"),
        "watch": (run.watch, "Show a video, a camera or a stimulus to models"),
        "live": (run.live, "Drive the stimulus by hand in a browser"),
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
        "video": (see.video, "Make a video, a strip or pictures of a recording"),
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


class _Commands(TyperGroup):
    """All commands."""

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
    cls=_Commands, rich_markup_mode=None, pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)  # fmt: skip
for _entries in GROUPS.values():
    for _name, (_command, _text) in _entries.items():
        if isinstance(_command, typer.Typer):
            app.add_typer(_command, name=_name, short_help=_text)
        else:
            app.command(_name, short_help=_text)(_command)


@cache
def parser() -> Any:
    """Return all commands with their options: made once in a process, as that takes as long as a trial."""
    return typer.main.get_command(app)


def command(arguments: list[str] | None = None) -> int:
    """Do what a command line asks for, otherwise this process's, and return the exit status.

    Raises `UsageError` for what it cannot mean.
    """
    arguments = arguments or sys.argv[1:] or ["--help"]
    if arguments[0] == "--version":
        from importlib.metadata import version

        typer.echo(f"colias-sim {version('colias-sim')}")
        return 0
    try:
        # Not standalone, so that the parser's own complaints come out as one line too.
        with begun_by({"line": list(arguments)}):
            return int(parser()(args=arguments, standalone_mode=False) or 0)
    except typer.TyperException as error:
        problem = " ".join(error.format_message().split())
    raise UsageError(problem)
