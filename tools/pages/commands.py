"""Pages: a page for each command with its help, as ``colias COMMAND --help`` prints it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import typer
from typer.testing import CliRunner

from experiments.bench.cli.main import app
from tools.pages import markdown
from tools.pages.markdown import code, prose, table


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    commands = shown(typer.main.get_command(app))
    for name, command in commands.items():
        texts = [f"```text\n{helped(words)}\n```\n" for words in _with_subcommands(name, command)]
        markdown.write(folder / f"{name}.md", f"# colias {name}\n", *texts)
    rows = ((f"[{code(f'colias {name}')}]({name}.md)", prose(c.short_help or "")) for name, c in commands.items())
    markdown.write(folder / "index.md", "# Commands\n", table(("Command", "What it does"), rows),
                   markdown.toctree(commands))  # fmt: skip


def shown(group: Any) -> Mapping[str, Any]:
    """Return the commands of a group that its help lists, by name; none of a command that is no group."""
    return {name: command for name, command in getattr(group, "commands", {}).items() if not command.hidden}


def helped(words: list[str]) -> str:
    """Return the help of a command, without the blanks at the ends of its lines."""
    printed = CliRunner().invoke(
        app, [*words, "--help"], env={"COLUMNS": "100", "TERMINAL_WIDTH": "100"}, prog_name="colias"
    )
    return "\n".join(line.rstrip() for line in printed.output.strip().splitlines())


def _with_subcommands(name: str, command: Any) -> Iterator[list[str]]:
    yield [name]
    yield from ([name, below] for below in shown(command))
