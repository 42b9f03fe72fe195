"""The command line as data: what Typer knows of every command, in the order of ``colias --help``."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import typer

from experiments.bench.cli import main

PROGRAM = "colias"


@dataclass(frozen=True, slots=True)
class Parameter:
    """An argument or an option.

    Attributes
    ----------
    names
        As typed; of an argument its name.
    value
        What its value is, as help shows it; empty of a flag.
    default
        Where there is one that help shows; empty otherwise.
    help
        In Rich's markup.
    """

    names: tuple[str, ...]
    value: str
    default: str
    help: str


@dataclass(frozen=True, slots=True)
class Command:
    """A command, or a group of commands.

    Attributes
    ----------
    words
        What is typed after ``colias``; empty of the whole.
    summary, help
        The line of the list of commands, and the whole text, in Rich's markup.
    usage
        Its arguments, as help shows them.
    heading
        Below which ``colias --help`` lists it; empty of what is not listed there.
    """

    words: tuple[str, ...]
    summary: str
    help: str
    usage: str
    heading: str
    arguments: tuple[Parameter, ...]
    options: tuple[Parameter, ...]
    commands: tuple[Command, ...] = ()

    @property
    def page(self) -> str:
        """The name of its page."""
        return "-".join(self.words)

    @property
    def title(self) -> str:
        """Return the command as it is typed."""
        return " ".join((PROGRAM, *self.words))

    def walk(self) -> Iterator[Command]:
        """Yield this command, and those below it."""
        yield self
        for command in self.commands:
            yield from command.walk()


def tree() -> Command:
    """Return the whole command line, as help lists it: without what is hidden."""
    return _command(typer.main.get_command(main.app), ())


def _command(click_command: Any, words: tuple[str, ...]) -> Command:
    context = typer.Context(click_command, info_name=" ".join((PROGRAM, *words)))
    kinds: dict[str, list[Parameter]] = {"argument": [], "option": []}
    for param in click_command.params:
        if not param.hidden:
            kinds[param.param_type_name].append(_parameter(param, context))
    below = getattr(click_command, "commands", {})
    return Command(
        words, click_command.short_help or "", click_command.help or "",
        " ".join(click_command.collect_usage_pieces(context)),
        getattr(click_command, "rich_help_panel", None) or "", tuple(kinds["argument"]), tuple(kinds["option"]),
        tuple(_command(command, (*words, name)) for name, command in below.items() if not command.hidden),
    )  # fmt: skip


def _parameter(option: Any, context: typer.Context) -> Parameter:
    """Read an option from help's own record: the names and the value, then the help and in brackets what else is
    said.
    """
    heading, text = option.get_help_record(context)
    words = option.help or ""
    extras = text.removeprefix(words).strip().removeprefix("[").removesuffix("]").split("; ")
    default = next((extra.removeprefix("default: ") for extra in extras if extra.startswith("default: ")), "")
    if option.param_type_name == "argument":
        names, value = (option.metavar or option.name,), heading.partition(" ")[2].strip("<>")
        return Parameter(names, value, default, words)
    if option.is_flag:
        ways = option.opts if option.default else option.secondary_opts
        return Parameter((*option.opts, *option.secondary_opts), "", ways[0] if default else "", words)
    value = re.sub(r"^(?:--?[\w-]+(?:, )?)+ ?", "", heading).strip("<>").removesuffix(" range")
    value = re.sub(r"^list\[(.*)\]$", r"\1", value)  # its help says that it is repeatable
    legal = [extra for extra in extras if "<=" in extra]
    return Parameter(tuple(option.opts), ", ".join([value, *legal]), default, words)
