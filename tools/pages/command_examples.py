"""Examples of commands: the chapters' own, which the tests run."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tools.pages.command_tree import PROGRAM, Command

DOCS = Path(__file__).parents[2] / "docs"
MOST = 2
"""Examples of a command."""
_BLOCK = re.compile(
    r"(?P<heading>^(?P<level>#+) (?P<title>[^\n]+)$)"
    r"|(?:^<!-- test: (?P<verb>\w+) [^\n]* -->\n)?^```(?P<language>\w+)[^\n]*\n(?P<text>.*?)^```$",
    re.DOTALL | re.MULTILINE,
)


@dataclass(frozen=True, slots=True)
class Example:
    """Lines of a chapter's block, those of one command.

    Attributes
    ----------
    chapter, anchor
        File name of the chapter, and the anchor of the section that the block is in.
    title, section
        The headings of both.
    lines
        As they stand there.
    tested
        Whether the tests run them; otherwise they check the options alone.
    """

    chapter: str
    anchor: str
    title: str
    section: str
    lines: tuple[str, ...]
    tested: bool


def examples(command: Command) -> list[Example]:
    """Choose a few examples of a command: those that the tests run, if there are any, and of other chapters first."""
    collected = [example for path in sorted(DOCS.glob("*.md")) for example in _of_chapter(path, command)]
    collected = [example for example in collected if example.tested] or collected
    first: dict[str, Example] = {}
    for example in collected:
        first.setdefault(example.chapter, example)
    others = [example for example in collected if example not in first.values()]
    return [*first.values(), *others][:MOST]


def _of_chapter(path: Path, command: Command) -> Iterator[Example]:
    title = section = ""
    for match in _BLOCK.finditer(path.read_text(encoding="utf-8")):
        if match["heading"]:
            section = match["title"]
            title = section if match["level"] == "#" else title
        elif match["language"] == "sh":
            lines = tuple(line for line in commands(match["text"]) if _is_of(line, command))
            if lines:
                yield Example(path.name, anchor(section), title, section, lines, match["verb"] != "skip")


def commands(text: str) -> list[str]:
    """Return the commands of a block, each with the lines that it goes on in."""
    return [line for line in re.split(r"(?<!\\)\n", text) if line.startswith(f"{PROGRAM} ")]


def _is_of(line: str, command: Command) -> bool:
    return line.split()[1 : len(command.words) + 1] == list(command.words) and "--help" not in line


def anchor(heading: str) -> str:
    """Return the anchor of a heading, as GitHub and MyST make it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
