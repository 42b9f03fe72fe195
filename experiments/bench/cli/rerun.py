"""The command ``colias rerun``. Heavy imports happen when it runs."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from experiments.bench.cli.options import EXIT_FAILED, For, Quiet, Workers
from experiments.bench.figures.media import Medium

if TYPE_CHECKING:
    from experiments.bench.store.record import Record

REPEATED = ("run", "study", "map", "tune", "behave")
"""Commands whose runs can be repeated."""
CALL = "experiments.run"
NOT_AGAIN = {"other_code": False, "cluster": None, "live": False, "viewer": None}
"""Options of the command that say nothing of its numbers."""
DIGITS = 64
"""Hexadecimal digits of a digest."""


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Repeat a run from its folder alone, and say whether every row is equal.")(rerun)


def rerun(
    context: typer.Context,
    run: Annotated[Path, typer.Argument(help="Folder of a run.")],
    trust: Annotated[
        bool, typer.Option("--trust", help="Execute the files of the folder that are listed: you have read them.")
    ] = False,
    digest: Annotated[
        str | None,
        typer.Option(metavar="HEX", help="The published digest of the run, as [b]colias cite[/b] prints it."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the repetition; otherwise a new one, runs/rerun-NAME-TIME.")
    ] = None,
    workers: Workers = None,
    medium: For = Medium.WEB,
    quiet: Quiet = False,
) -> int:
    """Do what a run was begun by once more, with the copies of your own files that its folder has, into a new folder.

    Then every row of its tables is compared with the run's, bit for bit, and the first that differs is named. The files
    that are about to be executed are listed. Where the originals are not at their places, with the same contents,
    [b]--trust[/b] is needed: read the files first. The digests in the folder find accidents, such as an edited copy;
    whoever edits on purpose can edit them too. So [b]--digest[/b] compares with a digest from elsewhere.

    For runs of run, study, map, tune and behave, recordings of live, and experiments.run in Python. Data files that
    your own code opens are not copied. Exit status: 0 every row is equal, 1 one differs or trials failed, 2 it cannot
    be repeated.
    """
    from experiments.bench.engine.errors import UsageError
    from experiments.bench.engine.terminal import error_console, out_console
    from experiments.bench.store import copies, description, files, provenance, repeat
    from experiments.bench.store.record import Record

    if out is not None:
        description.check_own(out, f"--out {out}")
        if not description.vacant(out):
            raise UsageError(f"--out {out}: holds files; choose a new folder, or an empty one")
    there = Record.read(run)
    _check_digest(there, digest)
    command = _command(there)
    user_files, note = copies.digests(run, there.description.get("files")), there.description.get(description.COPIES)
    if user_files and note is None:
        raise UsageError(f"{run}: has no copies of the user's own files (an older version made it)")
    places = copies.check(run, user_files, note) if user_files else {}
    refused = bool(user_files) and not trust and not copies.made_here(user_files)
    if refused or not quiet:
        _list(run, places, user_files)
    if refused:
        told = "1 copy of it is" if len(user_files) == 1 else f"{len(user_files)} copies of them are"
        raise UsageError(
            f"{run}: its own files are not at their places here, or have changed, and {told} about to be executed, as "
            "listed: read them first, then add --trust"
        )
    folder = files.new_folder(f"rerun-{Path(there.name).stem}") if out is None else out
    here_code = provenance.of()
    if other := provenance.difference({**there.description, "files": {}}, here_code):
        error_console.print(f"note: {run}: {other}", soft_wrap=True, markup=False)
    if (form := there.description.get("form")) != here_code["form"]:
        raise UsageError(f"{run}: the network ran in the form {form}, and here it is {here_code['form']}")
    roots = copies.import_folders(run, note) if isinstance(note, Mapping) else []
    typed = {name: str(places[path].resolve()) for name, path in command["paths"].items() if path in places}
    with _importing(roots):
        status = _repeat(context, run, command, typed, folder, workers, quiet)
    here = Record.read(folder)
    inside = {str(place.resolve()) for place in places.values()}
    outside = sorted(path for path in here.description.get("files") or {} if path not in inside)
    if outside:
        out_console.print(f"not repeated from {run} alone: it executed {outside[0]}", soft_wrap=True, markup=False)
        return EXIT_FAILED
    if difference := repeat.first_difference(there, here):
        out_console.print(f"differs: {difference}", soft_wrap=True, markup=False)
        return EXIT_FAILED
    counts = " and ".join(f"{table.num_rows:,} of {name}" for name, table in here.tables().items())
    out_console.print(f"equal: every row of {run}, bit for bit ({counts})", soft_wrap=True, markup=False)
    return status


def _check_digest(there: Record, digest: str | None) -> None:
    """Compare with a published digest, before anything else is looked at."""
    from experiments.bench.engine.errors import UsageError, short

    if digest is None:
        return
    if len(digest) != DIGITS or set(digest.lower()) - set("0123456789abcdef"):
        raise UsageError(f"--digest {short(digest)}: legal is {DIGITS} hexadecimal digits, as colias cite prints them")
    if (actual := there.digest()) != digest.lower():
        raise UsageError(f"{there.folder}: its digest is {actual}, not that of --digest: it is not the run published")


def _command(there: Record) -> Mapping[str, Any]:
    """Return the note of the command, checked; `UsageError` where it is not there, or none that is repeated."""
    from experiments.bench.engine.errors import UsageError, short
    from experiments.bench.store import description

    folder, command = there.folder, there.description.get(description.COMMAND)
    if there.kind.parts:
        raise UsageError(f"{folder}: {there.kind.what} is not repeated as a whole; legal are runs of {_legal()}")
    if command is None:
        raise UsageError(f"{folder}: experiment.json does not have the command (an older version made it)")
    line = command.get("line") if isinstance(command, Mapping) else None
    paths = command.get("paths") if isinstance(command, Mapping) else None
    texts = isinstance(line, list) and all(isinstance(text, str) for text in line)
    called = isinstance(command, Mapping) and isinstance(command.get("arguments"), Mapping)
    named = isinstance(paths, Mapping) and all(isinstance(path, str) for path in paths.values())
    if not named or not (texts or called):
        raise UsageError(f"{folder}: experiment.json cannot be read (command should have line or call, and paths)")
    name = line[0] if isinstance(line, list) and line else command.get("call")
    if name != CALL if called else name not in REPEATED:
        raise UsageError(f"{folder}: a run of {short(name)} is not repeated; legal are {_legal()}")
    if there.description.get(description.RESUMED):
        raise UsageError(f"{folder}: was gone on with by other code (--other-code): no one code repeats it")
    if there.done < there.planned and description.ENDED not in there.description:
        raise UsageError(f"{folder}: is not finished ({there.done} of {there.planned} {there.kind.things})")
    return dict(command)


def _legal() -> str:
    return f"{', '.join(REPEATED)} and {CALL}"


def _list(run: Path, places: Mapping[str, Path], digests: Mapping[str, str]) -> None:
    """List the files that are about to be executed."""
    from experiments.bench.engine.terminal import out_console

    if places:
        out_console.print(f"{run}: executes these files of its own, each as its digest says:", markup=False)
        for path, place in places.items():
            out_console.print(f"  {place}  sha256 {digests[path][:12]}", soft_wrap=True, markup=False)


@contextlib.contextmanager
def _importing(roots: list[Path]) -> Iterator[None]:
    """Let this process and its workers find modules in folders of copies, and write no bytecode beside the copies."""
    folders = [str(root.resolve()) for root in roots]
    variables = {"PYTHONDONTWRITEBYTECODE": "1"}
    if folders:
        old = os.environ.get("PYTHONPATH")
        variables["PYTHONPATH"] = os.pathsep.join([*folders, *([old] if old else [])])
    before = {name: os.environ.get(name) for name in variables}
    path, bytecode = sys.path[:], sys.dont_write_bytecode
    os.environ.update(variables)
    sys.path[:0] = folders
    sys.dont_write_bytecode = True
    try:
        yield
    finally:
        sys.path[:], sys.dont_write_bytecode = path, bytecode
        for name, value in before.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value


def _repeat(
    context: typer.Context, run: Path, command: Mapping[str, Any], copied: Mapping[str, str], out: Path,
    workers: int | None, quiet: bool,
) -> int:  # fmt: skip
    """Do the command once more, with the copies in place of the files it names; the exit status."""
    from experiments.bench.store import commands

    noted = {**command, "paths": dict(copied)}
    if "line" not in command:
        import experiments
        from experiments.bench.robot import visit

        arguments = dict(command["arguments"])
        by_hand = visit.declared(arguments.pop("experiment", None), f"{run}: experiment.json")
        if by_hand is None:
            arguments = command["arguments"]
        values = {name: _with_copies(run, name, value, copied) for name, value in arguments.items()}
        _check_call(run, values if by_hand is None else {**values, "experiment": by_hand.name})
        values |= {} if by_hand is None else {"experiment": by_hand}
        repeated = experiments.run(**values, out=out, workers=workers, quiet=quiet)
        return EXIT_FAILED if repeated.failures else 0
    group: Any = context.find_root().command
    name, *arguments = command["line"]
    chosen = group.commands[name]
    with commands.noting(lambda: noted), chosen.make_context(name, arguments, parent=context.parent) as inner:
        values = {key: _with_copies(run, key, value, copied) for key, value in inner.params.items()}
        values |= {key: value for key, value in NOT_AGAIN.items() if key in values}
        inner.params = {**values, "out": out, "workers": workers, "quiet": quiet}
        return int(chosen.invoke(inner) or 0)


def _check_call(run: Path, values: Mapping[str, Any]) -> None:
    """Refuse arguments that a run does not note, and an experiment that was an object of a script."""
    from experiments.bench.engine.errors import UsageError, short

    known = ("experiment", "seed", "repeats", "eyes", "models", "only", "settings", "recordings")
    if odd := sorted(set(values) - {*known, "pictures"}):
        raise UsageError(f"{run}: experiment.json: command: {CALL} has no argument {short(odd[0])} that is noted")
    if not isinstance(values.get("experiment"), str):
        raise UsageError(f"{run}: a script gave {CALL} an Experiment of its own: run the script, or give it a file")


def _with_copies(run: Path, name: str, value: Any, copied: Mapping[str, str]) -> Any:
    """Return an argument's value with the copies in place of files; `UsageError` where it names what has no copy."""
    from experiments.bench.engine.errors import UsageError
    from experiments.bench.store import commands

    if isinstance(value, list | tuple):
        return [_with_copies(run, name, item, copied) for item in value]
    if isinstance(value, Mapping):
        return {key: _with_copies(run, "assignments", f"{key}={item}", copied).partition("=")[2]
                for key, item in value.items()}  # fmt: skip
    if name == "pictures" and value is not None:
        raise UsageError(f"{run}: was made with the pictures of {value}, which its folder does not have")
    if not isinstance(value, str) or name == "env":  # which may be called colias_sim/NAME, and is no file
        return value
    if name == "assignments":
        key, equals, text = value.partition("=")
        if text in copied:
            return f"{key}{equals}{copied[text]}"
        if "/" in text or text.endswith(commands.ENDINGS):
            raise UsageError(f"{run}: was made with {value}, a file that its folder does not have")
        return value
    for source in commands.sources(value):
        if source not in copied:
            raise UsageError(f"{run}: names {source}, of which its folder has no copy")
        value = value.replace(source, copied[source], 1)
    return value
