"""The page of commands: the help of each, as ``colias COMMAND --help`` prints it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from experiments.cli.main import app, parser
from tools.pages import markdown


def write(folder: Path) -> None:
    """Write the page into ``folder``."""
    parts = ["# Commands\n"]
    for name in shown(parser(), "colias"):
        words = [*name.split()[1:], "--help"]
        printed = CliRunner().invoke(app(), words, env={"TERMINAL_WIDTH": "100"}, prog_name="colias")
        parts.append(f"{'#' * len(words)} {name}\n\n```text\n{printed.output.strip()}\n```\n")
    markdown.write(folder / "index.md", *parts)


def shown(group: Any, name: str) -> Iterator[str]:
    """Yield the names in full of the commands that a group's help lists, and of those below them."""
    for word, command in getattr(group, "commands", {}).items():
        if not command.hidden:
            yield f"{name} {word}"
            yield from shown(command, f"{name} {word}")
