"""The command line: every command of ``colias``. Heavy imports happen inside the commands, so that help is quick."""

from __future__ import annotations

import inspect
import logging
from functools import cache
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from experiments.bench.cli import (
    behave,
    camera,
    check,
    clips,
    doctor,
    firmware,
    fit,
    leaderboard,
    listing,
    live,
    measured,
    new,
    reproduce,
    run,
    sweep,
    train,
    tune,
    video,
    view,
    watch,
)
from experiments.bench.store import commands

GROUPS = {
    "Run": (run, watch, live),
    "Judge": (reproduce, sweep, fit),
    "Of your own": (new,),
    "Models": (check, leaderboard, tune),
    "Behaviours": (behave, train),
    "The robot's chip, and a real robot": (firmware, measured, camera),
    "What runs left": (view, video),
    "What there is": (listing, clips, doctor),
}
"""Heading -> the modules of its commands, in the order in which help shows them."""
RENAMED = {
    "compare": "experiments.compare(A, B) in Python",
    "export": "colias video RUN --out FOLDER for frames, colias firmware log for a robot's log; tables are Parquet",
    "map": "colias sweep",
    "parameters": "colias list parameters",
    "rerun": "colias run --again",
    "runs": "colias list runs",
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


app = typer.Typer(
    cls=_Commands,
    rich_markup_mode="rich",
    add_completion=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    help="""A simulated [b]Colias[/b] micro-robot testbed for fly-inspired motion vision.

Two robots in MuJoCo: the [b]observer[/b] looks through its 99x72 camera and runs a model of motion vision on every \
frame, the black [b]stimulus[/b] drives past it. Every trial is recorded for Rerun, summarised, drawn and held against \
what the paper (Fu, Bellotto and Yue 2018) reports.

[b]To begin with:[/b] colias list; colias run speed; colias view runs/speed-...; colias reproduce --quick. \
[b]Of your own:[/b] colias new model my_model; colias check my_model.py; colias run speed --model my_model.py; \
colias new experiment my_experiment; colias run my_experiment.py.

Equal seeds and parameters give equal numbers, on any number of workers. Exit status: 0 done, 1 trials failed, 2 a \
wrong use or a missing library, 130 interrupted. [b]colias COMMAND --help[/b] says what a command does.""",
)


def _register() -> None:
    """Put every command into the app, under its heading."""
    for heading, modules in GROUPS.items():
        for module in modules:
            commands, groups = len(app.registered_commands), len(app.registered_groups)
            module.register(app)
            for entry in app.registered_commands[commands:]:
                entry.rich_help_panel = heading
            _unwrap(app, commands)
            for group in app.registered_groups[groups:]:
                group.rich_help_panel = heading
                if group.typer_instance:
                    _unwrap(group.typer_instance)
    for old in RENAMED:
        app.command(old, hidden=True, context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(
            _renamed
        )


def _renamed(context: typer.Context) -> int:
    from experiments.bench.run.errors import UsageError

    raise UsageError(f"colias {context.info_name}: it is {RENAMED[str(context.info_name)]} now")


def _unwrap(commands: typer.Typer, start: int = 0) -> None:
    """Join the lines of each paragraph of help: the parser keeps line ends, and terminals differ in width."""
    for entry in commands.registered_commands[start:]:
        paragraphs = inspect.cleandoc(entry.help or getattr(entry.callback, "__doc__", None) or "").split("\n\n")
        entry.help = "\n\n".join(" ".join(paragraph.split()) for paragraph in paragraphs)


_register()


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


@cache
def parser() -> Any:
    """Return all commands with their options: made once in a process, as that takes as long as a trial."""
    return typer.main.get_command(app)


def command(arguments: list[str]) -> int:
    """Do what a command line asks for, and return the exit status. Raises `UsageError` for what it cannot mean."""
    # What it says of folders and fonts that it would like is no matter of a run's.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)
    try:
        # Not standalone, so that the parser's own complaints come out as one line too.
        with commands.noting(lambda: commands.typed(arguments)):
            return int(parser()(args=arguments, standalone_mode=False) or 0)
    except (_Interrupted, typer.Abort):
        raise KeyboardInterrupt from None
    except typer.TyperException as error:
        from experiments.bench.run.errors import UsageError

        raise UsageError(" ".join(error.format_message().split())) from None
