"""The command line: every command of ``colias``. Heavy imports happen inside, so that help is quick."""

import sys
from collections.abc import Mapping
from functools import cache
from typing import Any

from experiments.base.errors import UsageError
from experiments.store.asked import begun_by

GROUPS: Mapping[str, Mapping[str, tuple[str, str]]] = {
    "run": {
        "run": ("run", "Run an experiment: trials, recordings, tables, figure, verdicts"),
        "watch": ("watch", "Show a video, a camera or a stimulus to models"),
        "live": ("live", "Drive the stimulus by hand in a browser"),
        "behave": ("behave", "Play behaviours in an env, scored against baselines"),
        "train": ("train", "Train policies on neural observations by PPO"),
    },
    "analyse": {
        "reproduce": ("reproduce", "Run the paper's experiments and report which claims hold"),
        "sweep": ("sweep", "Judge claims over a grid of parameters, in replicates"),
        "fit": ("fit", "Search for parameters under which claims hold"),
        "benchmark": ("benchmark", "Score a model on frozen tasks, and check entries"),
        "leaderboard": ("leaderboard", "The ranks of 0.4; use benchmark"),
        "tune": ("tune", "Measure tuning curves: speed, size, contrast, direction, ..."),
    },
    "see": {
        "view": ("view", "Open recordings in Rerun, or a scene in MuJoCo's viewer"),
        "video": ("video", "Make a video, a strip or pictures of a recording"),
        "list": ("list_names", "Name experiments, models, stimuli, claims, parameters, runs"),
    },
    "make your own": {
        "new": ("new", "Write a model, an experiment, a claim, ... to begin with"),
        "check": ("check", "Try the laws of every model, stimulus or arena on yours"),
    },
    "robot": {
        "firmware": ("app", "Budget, check, export and logs of the chip's program"),
        "import": ("import_log", "Make a run of a real robot's log"),
        "camera": ("camera", "Measure a real camera from its frames"),
        "doctor": ("doctor", "Look at what this machine has of what the bench needs"),
    },
}
"""Heading -> command -> the function, and its line of help, in help's order."""
EXAMPLES = """\
  colias run speed                     the paper's speed trials, into runs/speed-TIME
  colias view runs/speed-TIME          their recordings, in Rerun
  colias reproduce --quick             which of the paper's claims hold"""


def summary() -> str:
    """Return the help of one screen."""
    lines = [
        "Usage: colias COMMAND [OPTIONS]", "",
        "A simulated Colias micro-robot testbed for fly-inspired motion vision.", "", EXAMPLES, "",
    ]  # fmt: skip
    for heading, entries in GROUPS.items():
        lines += [heading, *(f"  {name:<12} {text}" for name, (_, text) in entries.items())]
    return "\n".join([*lines, "", "colias COMMAND --help has all of a command. --version; --install-completion."])


def app() -> Any:
    """Return all commands with their options, as Typer has them."""
    import typer  # not before: it takes its time to load

    from experiments.cli import analyse, own, robot, run, see

    settings = {"help_option_names": ["-h", "--help"]}
    whole = typer.Typer(rich_markup_mode=None, pretty_exceptions_enable=False, context_settings=settings)
    for module, entries in zip((run, analyse, see, own, robot), GROUPS.values(), strict=True):
        for name, (function, text) in entries.items():
            found = getattr(module, function)
            if isinstance(found, typer.Typer):
                whole.add_typer(found, name=name, short_help=text)
            else:
                whole.command(name, short_help=text)(found)
    return whole


@cache
def parser() -> Any:
    """Return all commands as they are parsed: made once in a process, as that takes as long as a trial."""
    from typer.main import get_command

    return get_command(app())


def command(arguments: list[str] | None = None) -> int:
    """Do what a command line asks for, otherwise this process's, and return the exit status.

    Raises `UsageError` for what it cannot mean.
    """
    arguments = arguments or sys.argv[1:]
    if not arguments or arguments[0] in ("-h", "--help"):
        print(summary())
        return 0
    if arguments[0] == "--version":
        from importlib.metadata import version

        print(f"colias-sim {version('colias-sim')}")
        return 0
    from typer import TyperException

    try:
        # Not standalone, so that the parser's own complaints come out as one line too.
        with begun_by({"line": list(arguments)}):
            return int(parser()(args=arguments, standalone_mode=False) or 0)
    except TyperException as error:
        problem = " ".join(error.format_message().split())
    raise UsageError(problem)
