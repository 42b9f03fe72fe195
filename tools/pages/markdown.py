"""Markdown, written by the generated pages: tables, pictures, documentation by autodoc."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

DPI = 160
"""Of the pictures that pages have."""


def sentence(text: str) -> str:
    """Return a summary as a sentence."""
    return f"{text[:1].upper()}{text[1:].rstrip('.')}."


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; cells are Markdown already."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def toctree(pages: Iterable[str]) -> str:
    """Return the pages below this one, by their names without ending; the page itself does not list them."""
    return "\n".join([":::{toctree}", ":hidden:\n", *pages, ":::\n"])


def picture(file: str, text: str, caption: str) -> str:
    """Return a picture with a caption; ``text`` is for those who cannot see it."""
    return f":::{{figure}} {file}\n:alt: {text}\n:width: 560px\n\n{caption}\n:::\n"


def autodoc(thing: Any, module: str = "") -> str:
    """Return the docstring of a class as autodoc shows it. Links lead to its page of the API, if any."""
    signature = "(**parameters)" if hasattr(thing, "__pydantic_fields__") else ""  # the docstring lists them
    name = f"{module or thing.__module__}.{thing.__qualname__}{signature}"
    return f"```{{eval-rst}}\n.. autoclass:: {name}\n   :no-index:\n```\n"


def write(path: Path, *parts: str) -> None:
    """Write a page of its parts, an empty line between two; empty ones are left out."""
    path.write_text("\n".join(f"{part.rstrip()}\n" for part in parts if part), encoding="utf-8")
