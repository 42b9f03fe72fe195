from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.attack.commands import Command, Reference, reference
from tests.attack.folders import make, tables


@pytest.fixture(scope="session")
def honest(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Command], Reference]:
    """What a command says of honest models; run once for each."""
    known: dict[str, Reference] = {}

    def of(command: Command) -> Reference:
        if command.name not in known:
            known[command.name] = reference(command, tmp_path_factory.mktemp(f"honest-{command.name}"))
        return known[command.name]

    return of


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """An empty folder for one command; what is said lies beside it."""
    place = tmp_path / "work"
    place.mkdir()
    return place


@pytest.fixture(scope="session")
def run_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], tuple[Path, dict[str, Any]]]:
    """A folder with a run of a kind, and its tables; made once for each."""
    known: dict[str, tuple[Path, dict[str, Any]]] = {}

    def of(kind: str) -> tuple[Path, dict[str, Any]]:
        if kind not in known:
            folder = tmp_path_factory.mktemp(f"made-{kind}")
            make(folder, kind)
            known[kind] = folder, tables(folder / "out")
        return known[kind]

    return of
