"""Files of code that leave a mark when they are run, and data that name them."""

from __future__ import annotations

import copy
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

MARK = "ran-"
CANARY = """
open({folder!r} + "/{mark}" + __name__.rpartition(".")[2], "w").close()
"""
LIBRARIES = (
    "numpy", "scipy", "pyarrow", "pydantic", "typer", "rich", "cv2", "mujoco", "rerun", "rerun_cli", "sitecustomize"
)  # fmt: skip
"""What commands import beside the standard library."""


def plant(folder: Path, *names: str) -> list[Path]:
    """Write a canary of each name; all leave their marks in ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / name for name in names]
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(CANARY.format(folder=str(folder), mark=MARK))
    return paths


def plant_modules(folder: Path) -> None:
    """Write canaries called as the modules that Python and the commands import."""
    names = {*sys.stdlib_module_names, *LIBRARIES} - {"__future__"}
    plant(folder, *(f"{name}.py" for name in sorted(names)))


def marks(folder: Path) -> list[str]:
    """The canaries that have run; their marks are removed."""
    paths = sorted(folder.rglob(f"{MARK}*"))
    for path in paths:
        path.unlink()
    return [path.name.removeprefix(MARK) for path in paths]


def fields(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where in JSON a text stands, or an empty list or object, or null: what may be a path of code."""
    if isinstance(value, dict) and value:
        for name, inner in value.items():
            yield from fields(inner, (*path, name))
    elif isinstance(value, list) and value:
        for index, inner in enumerate(value):
            yield from fields(inner, (*path, index))
    elif not isinstance(value, bool | int | float):
        yield path


def with_value(value: Any, path: tuple[Any, ...], new: Any) -> Any:
    """JSON with another value at a place."""
    if not path:
        return new
    changed = copy.copy(value)
    changed[path[0]] = with_value(value[path[0]], path[1:], new)
    return changed


def with_names(value: Any, new: str) -> Iterator[Any]:
    """JSON in which the names in one object after another are those of ``new``."""
    for path in _objects(value):
        inner = value
        for name in path:
            inner = inner[name]
        for name in inner:
            yield with_value(value, path, {new if key == name else key: content for key, content in inner.items()})


def _objects(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if isinstance(value, dict):
        yield path
        for name, inner in value.items():
            yield from _objects(inner, (*path, name))
    elif isinstance(value, list):
        for index, inner in enumerate(value):
            yield from _objects(inner, (*path, index))


def tampered(path: Path, evil: str) -> Iterator[str]:
    """Write one version of a JSON file after another, each of which names the file ``evil`` in one place more."""
    whole = json.loads(path.read_text(encoding="utf-8"))
    versions: list[Any] = []
    for place in fields(whole):
        versions += [with_value(whole, place, new) for new in (evil, [evil], {evil: "0" * 64})]
    versions += with_names(whole, evil)
    for version in versions:
        path.write_text(json.dumps(version), encoding="utf-8")
        yield path.read_text(encoding="utf-8")
    path.write_text(json.dumps(whole), encoding="utf-8")
