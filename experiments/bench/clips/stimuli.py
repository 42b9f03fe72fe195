"""The stimuli of a command: registered ones by name, a user's own by the path of the file that declares it."""

from __future__ import annotations

import sys
from pathlib import Path

from dsnn.stimuli import StimulusEntry, stimulus_entry
from experiments.bench.run.errors import UsageError
from experiments.bench.run.user_code import USER_MODULE, declared, is_file


def find(source: str) -> StimulusEntry:
    """Return the registered stimulus called ``source``, or the one that the file ``source`` declares as ``STIMULUS``.

    Raises
    ------
    UsageError
        The name is not known, or the file cannot be read, has an error, or declares no `dsnn.stimuli.StimulusEntry`.
    """
    if not is_file(source):
        try:
            return stimulus_entry(source)
        except ValueError as error:
            raise UsageError(f"{error}, or a .py file") from None
    return of_file(Path(source), "STIMULUS")


def of_file(path: Path, name: str) -> StimulusEntry:
    """Return the stimulus that a user's file declares as ``name``; `UsageError` where it declares none."""
    entry = declared(path, name)
    if not isinstance(entry, StimulusEntry):
        raise UsageError(f"{path}: {name} is a {type(entry).__name__}, expected a dsnn.stimuli.StimulusEntry")
    return entry


def place_of(entry: StimulusEntry) -> tuple[str, str] | None:
    """Return the user's file that a stimulus is declared in, and its name there; ``None`` where that is no such file.

    Raises
    ------
    UsageError
        The file has no name for it, so that no other process could find it.
    """
    for name, module in list(sys.modules.items()):
        if name.startswith(USER_MODULE) and (file := getattr(module, "__file__", None)):
            for attribute, value in vars(module).items():
                if value is entry:
                    return file, attribute
    module_name = getattr(entry.build, "__module__", "") or ""
    if module_name.startswith(USER_MODULE):
        raise UsageError(
            f"stimulus {entry.name}: is no variable of its file; give it one, as STIMULUS = StimulusEntry(...)"
        )
    return None
