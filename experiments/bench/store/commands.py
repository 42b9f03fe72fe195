"""The command line, or the call from Python, by which a run was begun: a note in its ``run.json``."""

from __future__ import annotations

import contextlib
import contextvars
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

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
    """Describe a command line: the arguments typed after ``colias``, and the current folder."""
    return {"line": list(arguments), "folder": str(Path.cwd())}


def called(function: str, arguments: Mapping[str, Any]) -> dict[str, Any]:
    """Describe a call from Python, as `typed` describes a command line.

    Parameters
    ----------
    function
        Its name.
    arguments
        Those that are no resources: name -> value, in JSON's terms.
    """
    return {"call": function, "arguments": dict(arguments), "folder": str(Path.cwd())}
