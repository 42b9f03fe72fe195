"""Notes the commit in what is built: in a wheel's metadata, and in a source distribution for the wheel built of it."""

from __future__ import annotations

import json
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

NAME = "commit.json"
PACKAGES = ("colias_sim", "dsnn", "scenes", "experiments")


class CommitHook(BuildHookInterface[Any]):
    """Writes ``commit.json``: the commit, and whether the packages' files differed from it."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the file to what is about to be built."""
        if version == "editable":  # the checkout itself tells
            return
        self._folder = tempfile.TemporaryDirectory(prefix="colias-commit-")
        note = Path(self._folder.name) / NAME
        commit = _git(self.root, "rev-parse", "HEAD") if _git(self.root, "ls-files", "--", "pyproject.toml") else None
        if commit:
            changes = _git(self.root, "status", "--porcelain", "--", *PACKAGES)
            note.write_text(json.dumps({"commit": commit, "dirty": None if changes is None else bool(changes)}))
        elif (Path(self.root) / NAME).is_file():  # of the source distribution
            note.write_bytes((Path(self.root) / NAME).read_bytes())
        else:
            return
        build_data["extra_metadata" if self.target_name == "wheel" else "force_include"][str(note)] = NAME

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove the file."""
        if version != "editable":
            self._folder.cleanup()


def _git(root: str, *arguments: str) -> str | None:
    """Return what git says; ``None`` where it fails, or is not there."""
    command = ["git", "-c", "safe.directory=*", "--no-optional-locks", "-C", root, *arguments]  # another user's, too
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=20, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):
        return None
