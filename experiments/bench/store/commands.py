"""The command line, or the call from Python, by which a run was begun: a note in its ``experiment.json``."""

from __future__ import annotations

import contextlib
import contextvars
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

ENDINGS = (".py", ".npz", ".xml", ".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".webp")
"""Endings of the files that a command names, and that its run has copies of: code, policies, arenas, pictures."""

_current: contextvars.ContextVar[Callable[[], Mapping[str, Any]] | None] = contextvars.ContextVar(
    "command", default=None
)


@contextlib.contextmanager
def noting(command: Callable[[], Mapping[str, Any]]) -> Iterator[None]:
    """Let the runs that are begun in the block note a command.

    Parameters
    ----------
    command
        Gives what `typed` or `called` does, or the note of the run that is repeated; asked when a run is begun.
    """
    token = _current.set(command)
    try:
        yield
    finally:
        _current.reset(token)


def current() -> Mapping[str, Any] | None:
    """Return the command that runs are begun by at present; ``None`` where it is not known."""
    command = _current.get()
    return None if command is None else command()


def typed(arguments: Iterable[str]) -> dict[str, Any]:
    """Describe a command line.

    Parameters
    ----------
    arguments
        What was typed after ``colias``.

    Returns
    -------
    dict
        ``line``: the arguments. ``folder``: the current folder. ``paths``: each file of the user's own that the line
        names, as typed -> its absolute path, without links.
    """
    line = list(arguments)
    values = [text.partition("=")[2] if text.startswith("--") and "=" in text else text for text in line]
    values += [value for text in line if (value := text.rpartition("=")[2]) != text]  # of SECTION.NAME=VALUE
    return {"line": line, "folder": _folder(), "paths": _paths(values)}


def called(function: str, arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Describe a call from Python, as `typed` describes a command line.

    Parameters
    ----------
    function
        Its name.
    arguments
        Those that are no resources: name -> value, in JSON's terms.
    """
    values = (
        value.values() if isinstance(value, Mapping) else value if isinstance(value, list) else [value]
        for value in arguments.values()
    )
    texts = [text for listed in values for text in listed if isinstance(text, str)]
    return {"call": function, "arguments": dict(arguments), "folder": _folder(), "paths": _paths(texts)}


def sources(text: str) -> list[str]:
    """Return the files of the user's own that a value of an argument names, as they stand there.

    A value is a file, a model with settings (``my_model.py:gain=2``), or several joined by commas.
    """
    from experiments.bench.engine.errors import UsageError  # not before: help, which begins no run, is to be quick
    from experiments.bench.engine.models import ask
    from experiments.bench.engine.user_code import is_own

    try:
        source = ask(text).source
    except UsageError:
        source = text
    parts = source.split(",") if "," in source and not Path(source).is_file() else [source]
    return [part for part in parts if is_own(part)]


def in_words(command: Mapping[str, Any]) -> str:
    """Return a command as a person would type it."""
    if "line" in command:
        return shlex.join(["colias", *map(str, command["line"])])
    arguments = command.get("arguments")
    given = [f"{name}={value!r}" for name, value in arguments.items()] if isinstance(arguments, Mapping) else []
    return f"{command.get('call')}({', '.join(given)})"


def _paths(values: Iterable[str]) -> dict[str, str]:
    files = (source for value in values for source in {value, *sources(value)} if source.endswith(ENDINGS))
    return {file: str(Path(file).resolve()) for file in files if _is_file(file)}


def _is_file(name: str) -> bool:
    try:
        return Path(name).is_file()
    except (OSError, ValueError):
        return False


def _folder() -> str:
    try:
        return str(Path.cwd())
    except OSError:  # it is gone
        return ""
