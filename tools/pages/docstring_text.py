"""Docstrings as Markdown. They are numpydoc; in prose its marks are those of Markdown, but for code."""

from __future__ import annotations

import inspect
import re
from typing import Any

from tools.pages.markdown import code, escaped

ASSUMED = "Assumed"
"""How the paragraph of a model's class begins that lists what no source gives."""
_SPAN = re.compile(r"``(.+?)``|`(.+?)`", re.DOTALL)


def paragraphs(documented: Any) -> list[str]:
    """Return the paragraphs of a docstring as Markdown, up to the first section such as ``Parameters``."""
    text = re.split(r"^\w+\n-{3,}$", inspect.getdoc(documented) or "", maxsplit=1, flags=re.MULTILINE)[0]
    return [_paragraph(part) for part in re.split(r"\n\s*\n", text.strip()) if part.strip()]


def _paragraph(text: str) -> str:
    """Return one paragraph, or one list, with each item on a line."""
    if text.lstrip().startswith("- "):
        items = re.split(r"\n(?=- )", text.strip())
        return "\n".join(f"- {_marked(' '.join(item.removeprefix('- ').split()))}" for item in items)
    return _marked(" ".join(text.split()))


def _marked(text: str) -> str:
    parts, at = [], 0
    for match in _SPAN.finditer(text):
        parts += [escaped(text[at : match.start()]), code(match[1] or match[2])]
        at = match.end()
    return "".join([*parts, escaped(text[at:])])


def references(documented: Any) -> str:
    """Return the section ``References`` of a docstring as Markdown, in one line."""
    text = re.search(r"^References\n-+\n(.+?)(?:\n\n|\Z)", inspect.getdoc(documented) or "", re.MULTILINE | re.DOTALL)
    return _marked(" ".join(text[1].split())) if text else ""


def assumed(documented: Any) -> list[str]:
    """Return what a model's class says is assumed, an item each, as Markdown; nothing where it says nothing."""
    parts, items = paragraphs(documented), []
    for place, text in enumerate(parts):
        if not text.startswith(ASSUMED):
            continue
        _, colon, listed = text.partition(": ")
        items += re.split(r"; |\. (?=[A-Z`])", listed.rstrip(".")) if colon else []
        if place + 1 < len(parts) and parts[place + 1].startswith("- "):
            items += [item.removeprefix("- ") for item in parts[place + 1].splitlines()]
    return [item.rstrip(".") for item in items]
