"""Write a file to begin with, under a name that is legal and free."""

from __future__ import annotations

import importlib.util
import keyword
import re
from pathlib import Path

from experiments.bench.new.kinds import KINDS
from experiments.bench.run.errors import LONGEST_NAME, UsageError, short
from experiments.bench.run.templates import render
from experiments.bench.run.user_code import is_users
from scenes.hints import nearest


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
        There is no such kind, the name is not legal or taken, or there is such a file. Nothing was written.
    OSError
        The file cannot be written.
    """
    if kind not in KINDS:
        raise UsageError(f"new {short(kind)}{nearest(kind, KINDS, ' (', ')')}: legal is {', '.join(KINDS)}")
    what, stem = f"new {kind} {short(name)}", name.replace("-", "_")
    if not re.fullmatch(rf"[A-Za-z][A-Za-z0-9_-]{{0,{LONGEST_NAME - 1}}}", name):
        raise UsageError(f"{what}: legal is a name of a letter, then letters, digits, - and _, up to {LONGEST_NAME}")
    path = folder / f"{stem}.py"
    if path.exists():
        raise UsageError(f"{path}: there is such a file already, and it is left as it is")
    if name in KINDS[kind].shipped():
        raise UsageError(f"{what}: {'an' if kind[0] in 'aeiou' else 'a'} {kind} of that name ships; give yours another")
    if keyword.iskeyword(stem) or _is_installed(stem):
        taken = "a word" if keyword.iskeyword(stem) else "a module"
        raise UsageError(f"{what}: Python has {taken} '{stem}', which {stem}.py would hide; give yours another name")
    path.write_text(render(f"new/{kind}.py.j2", name=name, stem=stem) + "\n", encoding="utf-8")
    return path


def _is_installed(stem: str) -> bool:
    spec = importlib.util.find_spec(stem)
    return spec is not None and spec.origin is not None and not is_users(Path(spec.origin).resolve())
