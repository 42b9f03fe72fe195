"""Pages: a page for each vision model, with its picture."""

from __future__ import annotations

from pathlib import Path


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    (folder / "index.md").write_text("---\norphan: true\n---\n\n# Models\n", encoding="utf-8")
