"""The command that runs are begun by: a note in their ``run.json``. Every command imports this, so it is light.

The entry ``command`` has the command line (``line``), or the call from Python (``call``), the
folder, and how the run's own folder leads to it (``folder_from_run``), which stays when both are moved.
"""

from __future__ import annotations

import contextlib
import os
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


def command_note(run: Path) -> dict[str, Any]:
    """Return the entry of the ``run.json`` in a folder; none where the command is not known."""
    command = _command.get()
    if command is None:
        return {}
    return {"command": {**command, "folder_from_run": os.path.relpath(command["folder"], run.resolve())}}
