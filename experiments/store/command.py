"""The command that runs are begun by: a note in their ``run.json``. Every command imports this, so it is light.

The entry ``command`` has the command line (``line``), or the call from Python (``call``, ``arguments``), and the
folder.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from contextvars import ContextVar
from pathlib import Path
from typing import Any

_command: ContextVar[Mapping[str, Any] | None] = ContextVar("command", default=None)


@contextlib.contextmanager
def begun_by(command: Mapping[str, Any]) -> Iterator[None]:
    """Note a command and the current folder in the runs that are begun in the block."""
    token = _command.set({**command, "folder": str(Path.cwd())})
    try:
        yield
    finally:
        _command.reset(token)


def command_note() -> dict[str, Any]:
    """Return the entry of ``run.json``; none where the command is not known."""
    command = _command.get()
    return {} if command is None else {"command": command}
