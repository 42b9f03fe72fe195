"""The command ``colias new``. It imports what is heavy when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.new import KINDS, write


def new(
    kind: Annotated[str, typer.Argument(metavar="KIND", help=f"What the file has: {', '.join(KINDS)}.")],
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="Its name: letters, digits, - and _. The file is NAME.py, - as _.")
    ],
) -> int:
    """Write a file to begin with into the current folder. It runs as it is; three comments say what to do next.

    Nothing is overwritten.
    """
    from experiments.bench.report.terminal import show_line

    path = write(kind, name, Path())
    summary, command = KINDS[kind]
    show_line(f"{path}: {summary}; its first lines say what to do next. Try it as it is:", 4)
    show_line(f"colias {command} {path}", 4)
    return 0
