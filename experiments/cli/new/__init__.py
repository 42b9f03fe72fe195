"""Files to begin with: what ``colias new`` writes. A new kind is a template ``KIND.py.j2`` here, and a line below.

A template is filled in with ``name``, as the tables show it, and ``stem``, the file's name without its ending. The file
runs as it is, and three numbered comments at its top have what to do next.
"""

import re
from pathlib import Path

from experiments.base.errors import UsageError, check_known

KINDS = {
    "model": ("a model of motion vision", "check"),
    "experiment": ("trials with the robot on a path of your own, and a claim", "run"),
    "claim": ("a claim, and the trials with the robot that it is judged on", "run"),
    "stimulus": ("a synthetic stimulus, clips of it, and a claim about them", "check"),
    "arena": ("a room with obstacles, for trials and envs", "check"),
    "behaviour": ("a reflex that drives the robot in an env", "behave"),
}
"""Kind -> what the file has, and the command that tries it first: ``colias COMMAND FILE``."""


def write(kind: str, name: str, folder: Path) -> Path:
    """Write a file to begin with.

    Parameters
    ----------
    kind
        One of `KINDS`.
    name
        A letter, then letters, digits, ``-`` and ``_``, up to 60. The file's name has ``_`` for each ``-``.
    folder
        Where the file is written.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    UsageError
        There is no such kind, the name is invalid, or there is such a file. Nothing was written.
    OSError
        The file cannot be written.
    """
    from experiments.base.templates import render

    check_known("kind", kind, KINDS)
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,59}", name):
        raise UsageError(f"a name must be a letter, then letters, digits, - and _, up to 60, got {name!r}")
    stem = name.replace("-", "_")
    path = folder / f"{stem}.py"
    if path.exists():
        raise UsageError(f"{path}: there is such a file already, and it is left as it is")
    path.write_text(render(f"cli/new/{kind}.py.j2", name=name, stem=stem) + "\n", encoding="utf-8")
    return path
