"""``colias run --again RUN``: repeat a run and compare every row. Heavy imports happen when it runs."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from experiments.bench.cli.options import EXIT_FAILED

if TYPE_CHECKING:
    from experiments.bench.store.record import Record

REPEATED = ("run", "sweep", "tune", "behave", "experiments.run")
"""Commands and calls whose runs can be repeated."""
NOT_AGAIN = {"other_code": False, "cluster": None, "live": False, "viewer": None}
"""Options of the command that say nothing of its numbers."""


def repeat_run(context: typer.Context, run: Path, out: Path | None, workers: int | None, quiet: bool) -> int:
    """Do what a run was begun by once more, with your own files as they are at their places, into a new folder.

    Then every row of its tables is compared with the run's, bit for bit, and the first that differs is named. What
    computes otherwise than it did, such as a file that has changed, is named in a note.

    For runs of run, sweep, tune and behave, recordings of live, and experiments.run in Python. Exit status: 0
    every row is equal, 1 one differs or trials failed, 2 it cannot be repeated.
    """
    from experiments.bench.engine.terminal import error_console, out_console
    from experiments.bench.run.errors import UsageError
    from experiments.bench.store import description, files, provenance, repeat
    from experiments.bench.store.record import Record

    if out is not None and not description.vacant(out):
        raise UsageError(f"--out {out}: holds files; choose a new folder, or an empty one")
    there = Record.read(run)
    command = _command(there)
    folder = (files.new_folder(f"again-{Path(there.name).stem}") if out is None else out).absolute()
    with contextlib.chdir(command["folder"]):
        status = _repeat(context, run, command, folder, workers, quiet)
    here = Record.read(folder)
    if other := provenance.difference(there.description, here.description):
        error_console.print(f"note: {run}: {other}", soft_wrap=True, markup=False)
    if difference := repeat.first_difference(there, here):
        out_console.print(f"differs: {difference}", soft_wrap=True, markup=False)
        return EXIT_FAILED
    counts = " and ".join(f"{table.height:,} of {name}" for name, table in here.tables().items())
    out_console.print(f"equal: every row of {run}, bit for bit ({counts})", soft_wrap=True, markup=False)
    return status


def _command(there: Record) -> Mapping[str, Any]:
    """Return the note of the command; `UsageError` where its run is none that is repeated."""
    from experiments.bench.run.errors import UsageError
    from experiments.bench.store import description

    folder, command = there.folder, there.description.get(description.COMMAND)
    if there.kind.parts:
        raise UsageError(f"{folder}: {there.kind.what} is not repeated as a whole; repeat its parts")
    command = command or {}
    name = command["line"][0] if "line" in command else command.get("call")
    if name not in REPEATED:
        raise UsageError(f"{folder}: a run of {name} is not repeated; runs of {', '.join(REPEATED)} are")
    if there.description.get(description.RESUMED):
        raise UsageError(f"{folder}: was gone on with by other code (--other-code): no one code repeats it")
    if there.done < there.planned and description.ENDED not in there.description:
        raise UsageError(f"{folder}: is not finished ({there.done} of {there.planned} {there.kind.things})")
    return dict(command)


def _repeat(
    context: typer.Context, run: Path, command: Mapping[str, Any], out: Path, workers: int | None, quiet: bool
) -> int:
    """Do the command once more, in its folder; the exit status."""
    from experiments.bench.run.errors import UsageError
    from experiments.bench.store import commands

    if "line" not in command:
        import experiments
        from experiments.bench.sources import visit

        arguments = dict(command["arguments"])
        name = arguments.pop("experiment")
        experiment = visit.declared(name, f"{run}: run.json") or name
        if isinstance(experiment, Mapping):
            raise UsageError(f"{run}: a script gave experiments.run an Experiment of its own: run the script")
        repeated = experiments.run(experiment, **arguments, out=out, workers=workers, quiet=quiet)
        return EXIT_FAILED if len(repeated.failures) else 0
    group: Any = context.find_root().command
    name, *line = command["line"]
    chosen = group.commands[name]
    with commands.noting(lambda: command), chosen.make_context(name, line, parent=context.parent) as inner:
        given = {key: value for key, value in NOT_AGAIN.items() if key in inner.params}
        inner.params = {**inner.params, **given, "out": out, "workers": workers, "quiet": quiet}
        return int(chosen.invoke(inner) or 0)
