"""Pages: figures, each made by the command that is shown."""

from __future__ import annotations

from pathlib import Path


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    (folder / "index.md").write_text("---\norphan: true\n---\n\n# Gallery\n", encoding="utf-8")
