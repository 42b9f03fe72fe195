"""What was asked for: the one thing that a run stores and follows from.

The entry ``command`` of ``run.json`` notes the command that began the run: the command line (``line``), or the call
from Python (``call``), the folder, and how the run's own folder leads to it (``folder_from_run``), which stays when
both are moved. Every command imports this, so it is light.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator, Mapping
from contextvars import ContextVar
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

ASKED = "asked"
"""The entry of ``run.json`` that has it."""


@dataclass(frozen=True, kw_only=True)
class Asked:
    """What a person asked for, as it was typed or called. A run is planned from this alone.

    Parameters
    ----------
    kind
        The kind of run, a key of `experiments.kinds.tables.KINDS`.
    what
        What is run: experiments, behaviours or a source, by name or by path.
    models
        Models, as ``--model`` takes them.
    only
        Whether those of ``models`` alone are shown.
    values
        ``SECTION.NAME`` -> value: from Python as JSON has it (`experiments.base.values`), of a command line the text.
    repeats
        Trials of each condition; ``None``: the declaration's own number.
    seed
        Seed of the run.
    options
        What the kind alone knows; those left out have its defaults.
    declared
        A declaration that a caller gave in place of a name. It is not stored, so such a run is not planned again.
    """

    kind: str
    what: tuple[str, ...] = ()
    models: tuple[str, ...] = ()
    only: bool = False
    values: Mapping[str, Any] = field(default_factory=dict)
    repeats: int | None = None
    seed: int = 0
    options: Mapping[str, Any] = field(default_factory=dict)
    declared: Any = field(default=None, compare=False, repr=False)

    def stored(self) -> dict[str, Any]:
        """Return what ``run.json`` has of it: the kind, and what is not at its default."""
        usual, names = Asked(kind=""), [one.name for one in fields(self) if one.compare]
        return {name: getattr(self, name) for name in names if getattr(self, name) != getattr(usual, name)}

    @classmethod
    def read(cls, stored: Mapping[str, Any]) -> Asked:
        """Return what was asked, from what ``run.json`` has of it.

        Raises
        ------
        pydantic.ValidationError
            It is nothing that `stored` returned.
        """
        from pydantic import TypeAdapter  # not before: it takes its time to load

        return TypeAdapter(cls).validate_python(dict(stored))

    def option(self, name: str, default: Any = None) -> Any:
        """Return an option of the kind, or its default."""
        value = self.options.get(name)
        return default if value is None else value


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
