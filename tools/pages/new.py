"""The page of the files that ``colias new`` writes, each as it is."""

from __future__ import annotations

import tempfile
from pathlib import Path

from experiments.bench import new
from tools.pages import markdown
from tools.pages.markdown import prose, sentence


def write(folder: Path) -> None:
    """Write the page into ``folder``."""
    markdown.write(
        folder / "index.md",
        "# What `colias new` writes\n",
        "[`colias new KIND NAME`](../commands/new.md) writes a file to begin with.\n"
        "It runs as it is, and its first comments say what to do next.\n",
        *(part for kind in new.KINDS for part in _section(kind)),
    )


def _section(kind: str) -> tuple[str, str, str]:
    """Return the heading of a kind, what its file has, and the file."""
    with tempfile.TemporaryDirectory() as folder:
        text = new.write(kind, f"my_{kind}", Path(folder)).read_text(encoding="utf-8")
    return f"## {kind}\n", f"{prose(sentence(new.KINDS[kind][0]))}\n", f"```python\n{text}```\n"
