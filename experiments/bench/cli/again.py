"""``colias run --again RUN``: repeat a run and compare every row. Heavy imports happen when it runs."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from experiments.bench.cli.options import EXIT_FAILED

if TYPE_CHECKING:
    pass

REPEATED = ("run", "sweep", "tune", "behave", "watch", "experiments.run")
"""Commands and calls whose runs can be repeated."""
NOT_AGAIN = {"other_code": False, "cluster": None, "live": False, "viewer": None, "view": False}
"""Options of the command that say nothing of its numbers."""


def repeat_run(context: typer.Context, run: Path, out: Path | None, workers: int | None, quiet: bool) -> int:
    """Do what a run was begun by once more, with your own files as they are at their places, into a new folder.

    Then every row of its tables is compared with the run's, bit for bit, and the first that differs is named. What
    computes otherwise than it did, such as a file that has changed, is named in a note.

    For runs of run, sweep, tune, behave and watch, recordings of live, and experiments.run in Python. Exit status: 0
    every row is equal, 1 one differs or trials failed, 2 it cannot be repeated.
    """
    from experiments.bench.compare import first_difference
    from experiments.bench.report.terminal import error_console, out_console
    from experiments.bench.result import load
    from experiments.bench.run import provenance
    from experiments.bench.run.description import ENDED, RESUMED
    from experiments.bench.run.errors import UsageError
    from experiments.bench.run.files import new_folder

    there = load(run)
    command = there.description.get("command", {})
    name = command["line"][0] if "line" in command else command.get("call")
    if name not in REPEATED:
        raise UsageError(f"{run}: a run of {name or there.kind} is not repeated; runs of {', '.join(REPEATED)} are")
    if RESUMED in there.description or (there.done < there.planned and ENDED not in there.description):
        raise UsageError(f"{run}: is not finished, or was resumed with other code: no one command repeats it")
    folder = (out or new_folder(f"again-{Path(there.name).stem}")).absolute()
    if folder.exists() and any(folder.iterdir()):
        raise UsageError(f"--out {out}: holds files; choose a new folder, or an empty one")
    with contextlib.chdir(command["folder"]):
        status = _repeat(context, run, command, folder, workers, quiet)
    here = load(folder)
    if other := provenance.difference(there.description, here.description):
        error_console.print(f"note: {run}: {other}", soft_wrap=True)
    if difference := first_difference(there, here):
        out_console.print(f"differs: {difference}", soft_wrap=True)
        return EXIT_FAILED
    counts = f"{there.trials.height:,} of trials and {there.frames.height:,} of frames"
    out_console.print(f"equal: every row of {run} ({counts})", soft_wrap=True)
    return status


def _repeat(
    context: typer.Context, run: Path, command: Mapping[str, Any], out: Path, workers: int | None, quiet: bool
) -> int:
    """Do the command once more, in its folder; the exit status."""
    from experiments.bench.run.description import begun_by
    from experiments.bench.run.errors import UsageError

    with begun_by({name: value for name, value in command.items() if name != "folder"}):
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
        with chosen.make_context(name, line, parent=context.parent) as inner:
            again = {**NOT_AGAIN, "out": out, "workers": workers, "quiet": quiet}
            inner.params |= {key: value for key, value in again.items() if key in inner.params}
            return int(chosen.invoke(inner) or 0)
