"""Markdown, written by the generated pages: tables, escaped text, lists of pages."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

_SPECIAL = re.compile(r"([\\`*_\[\]<>|$~{}])")
_LITERAL = re.compile(
    r"(?<![\w`@/-])(?:"
    r"--?[a-z][\w-]*"  # an option
    r"|[\w.@*/-]*\.(?:py|csv|json|html|svg|png|gif|mp4|avi|rrd|npz|mat|parquet|pgm|raw|c|md)\b"  # a file
    r"|(?:runs|docs)/[\w./-]*\w"
    r"|[\w.:@-]*\w=[\w.=,:-]*\w"  # a setting
    r"|[a-z][a-z\d]*(?:_[a-z\d]+)+(?:\.\w+)*"  # a name of the code
    r")"
)
"""Text that reads as code in a help text or a description."""


def escaped(text: str) -> str:
    """Text as it is: no character of it is Markdown."""
    return _SPECIAL.sub(r"\\\1", text)


def code(text: str) -> str:
    """Text as code, also inside a table. It may have no backtick of its own."""
    return "`" + text.replace("|", r"\|") + "`"


def prose(text: str) -> str:
    """Return a sentence of the code: names, options, settings and files as code, the rest escaped."""
    parts, at = [], 0
    for match in _LITERAL.finditer(text):
        parts += [escaped(text[at : match.start()]), code(match[0])]
        at = match.end()
    return "".join([*parts, escaped(text[at:])])


def sentence(text: str) -> str:
    """Return a summary as a sentence: its first letter large unless it begins with a name, a full stop at its end."""
    first = text[:1].upper() if not re.match(r"\w*[A-Z_\d]", text) else text[:1]
    return f"{first}{text[1:].rstrip('.')}." if text else ""


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; cells are Markdown already. A column that is empty throughout is left out."""
    listed = [tuple(row) for row in rows]
    kept = [place for place in range(len(heads)) if any(row[place] for row in listed)]
    lines = [[heads[place] for place in kept], ["---"] * len(kept), *([row[place] for place in kept] for row in listed)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def toctree(pages: Iterable[str]) -> str:
    """Return the pages below this one, by their names without ending; the page itself does not list them."""
    return "\n".join([":::{toctree}", ":hidden:\n", *pages, ":::\n"])


def picture(file: str, text: str, caption: str, width: int = 560) -> str:
    """Return a picture with a caption; ``text`` is for those who cannot see it, ``width`` in px on a wide screen."""
    return f":::{{figure}} {file}\n:alt: {text}\n:width: {width}px\n\n{caption}\n:::\n"


def write(path: Path, *parts: str) -> None:
    """Write a page of its parts, an empty line between two; empty ones are left out."""
    path.write_text("\n".join(f"{part.rstrip()}\n" for part in parts if part), encoding="utf-8")
