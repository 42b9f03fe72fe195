"""Pages: a page for each command, from the command line itself."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from tools.pages import markdown
from tools.pages.command_examples import Example, examples
from tools.pages.command_tree import PROGRAM, Command, Parameter, tree
from tools.pages.markdown import code, prose, table

_BOLD = re.compile(r"\[b\](.+?)\[/b\]")


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    whole = tree()
    pages = {command.page: command for command in whole.walk() if command.words}
    for command in pages.values():
        _write_page(folder, command, pages)
    _write_index(folder, whole, pages)


def _write_page(folder: Path, command: Command, pages: Mapping[str, Command]) -> None:
    markdown.write(
        folder / f"{command.page}.md",
        f"# {command.title}\n",
        f"{prose(command.summary)}\n" if command.summary else "",
        f"```text\n{command.title} {command.usage}\n```",
        helped(command.help, pages),
        _subcommands(command),
        _parameters("Arguments", command.arguments, pages),
        _parameters("Options", command.options, pages),
        _examples(examples(command)) if not command.commands else "",
    )


def _write_index(folder: Path, whole: Command, pages: Mapping[str, Command]) -> None:
    headings = dict.fromkeys(command.heading for command in whole.commands)
    groups = [
        f"## {heading}\n\n{_list([command for command in whole.commands if command.heading == heading])}"
        for heading in headings
    ]
    above = [command.page for command in whole.commands]
    markdown.write(
        folder / "index.md",
        "# Commands\n",
        f"These pages are made of the command line itself: `{PROGRAM} --help` and `{PROGRAM} COMMAND --help`"
        " say the same.\n",
        *groups,
        f"## {PROGRAM}\n",
        f"```text\n{PROGRAM} {whole.usage}\n```",
        _parameters("", whole.options, pages),
        helped(whole.help, {}),
        markdown.toctree(above),
    )


def _list(commands: Sequence[Command]) -> str:
    rows = ((f"[{code(command.title)}]({command.page}.md)", prose(command.summary)) for command in commands)
    return table(("Command", "What it does"), rows)


def _subcommands(command: Command) -> str:
    if not command.commands:
        return ""
    return "\n".join([_list(command.commands), markdown.toctree(subcommand.page for subcommand in command.commands)])


def helped(text: str, pages: Mapping[str, Command]) -> str:
    """Return a help text in Rich's markup as Markdown: paragraphs, examples that are indented, headings in bold.

    ``pages`` are those that commands in bold link to. Without any, bold text is terms, not names of the code.
    """
    parts = []
    for paragraph in re.split(r"\n\s*\n", text.replace("\\[", "[").strip("\n")):  # brackets that are no markup
        lines = paragraph.split("\n")
        if all(line.startswith("  ") for line in lines):
            parts.append("\n".join(["```text", *(line[2:] for line in lines), "```\n"]))
        elif title := re.fullmatch(_BOLD, paragraph.strip()):
            parts.append(f"**{title[1]}**\n")
        else:
            parts.append(f"{_marked(' '.join(line.strip() for line in lines), pages)}\n")
    return "\n".join(parts)


def _marked(text: str, pages: Mapping[str, Command]) -> str:
    """Return a line of help: what is bold becomes code, and a link where it is a command."""
    parts, at = [], 0
    for match in _BOLD.finditer(text):
        parts += [prose(text[at : match.start()]), _link(match[1], pages)]
        at = match.end()
    return "".join([*parts, prose(text[at:])])


def _link(text: str, pages: Mapping[str, Command]) -> str:
    if not pages:
        return f"**{text}**"
    words = text.split()
    if words[0] == PROGRAM:
        named = [word for word in words[1:] if word.islower()]
        for length in range(len(named), 0, -1):
            if (page := "-".join(named[:length])) in pages:
                return f"[{code(text)}]({page}.md)"
    return code(text)


def _parameters(title: str, parameters: Sequence[Parameter], pages: Mapping[str, Command]) -> str:
    """Return a table of what follows a command: each with its value beside it, where it has one."""
    rows = []
    for parameter in parameters:
        ways = ", ".join(map(code, parameter.names))
        value = f" {code(parameter.value)}" if parameter.value else ""
        rows.append(
            (f"{ways}{value}", _marked(parameter.help, pages), code(parameter.default) if parameter.default else "")
        )
    heads = (title.removesuffix("s") or "Option", "Meaning", "Default")
    return "" if not rows else (f"## {title}\n\n" if title else "") + table(heads, rows)


def _examples(examples: Sequence[Example]) -> str:
    if not examples:
        return ""
    parts, caption = ["## Examples\n"], ""
    for example in examples:
        where = f"{example.title}, {example.section}" if example.section != example.title else example.title
        link = f"From [{where}](../../{example.chapter}#{example.anchor}):\n"
        parts += [*([link] if link != caption else []), "\n".join(["```sh", *example.lines, "```\n"])]
        caption = link
    return "\n".join(parts)
