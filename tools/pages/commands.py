"""Pages: a page for each command, from the command line itself."""

from __future__ import annotations

from pathlib import Path


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    (folder / "index.md").write_text("---\norphan: true\n---\n\n# Commands\n", encoding="utf-8")
