"""What libraries keep to themselves is used in one place: `experiments.bench.recording`, which says why."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.package.test_imports import ROOT, files

PRIVATE_LIBRARIES = ("rerun_bindings",)
PUBLIC = ("_exit", "_getframe")
"""Underscores that the standard library documents."""
OURS = ("experiments", "colias_sim", "dsnn", "scenes")
WHERE = {
    "experiments/bench/recording.py": {"rerun_bindings", "_from_native", "_log_to_stream"},
    "experiments/bench/live/inputs.py": {"_impl"},  # viser's: every test of tests/bench/live fails without
}
"""File -> what it uses. Every entry needs a test of its own that fails when the name moves."""


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__") and name not in PUBLIC


def private_names(tree: ast.AST) -> Iterator[str]:
    """Modules, names and attributes of others that are not meant for us; of an object other than ``self`` and ``cls``.

    An attribute counts as ours where the file itself defines it.
    """
    defined = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    defined |= {
        node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            ours = str(node.module).split(".")[0] in OURS
            names = [] if ours else [str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)]
        elif isinstance(node, ast.Attribute) and node.attr not in defined:
            held = node.value.id if isinstance(node.value, ast.Name) else ""
            names = [] if held in ("self", "cls") else [f".{node.attr}"]
        else:
            continue
        for name in names:
            parts = [part for part in name.split(".") if part]
            yield from (part for part in parts if is_private(part) or part in PRIVATE_LIBRARIES)


def test_the_search_finds_what_it_is_for():
    text = (
        "import _signal\nfrom os import _wrap_close\nfrom multiprocessing.util import _exit_function\n"
        "import rerun_bindings\nexecutor._result_queue._writer.close()\nself._own()\nos._exit(0)\n"
    )
    expected = {"_signal", "_wrap_close", "_exit_function", "rerun_bindings", "_result_queue", "_writer"}
    assert set(private_names(ast.parse(text))) == expected


@pytest.mark.parametrize("path", files(), ids=lambda path: path.relative_to(ROOT).as_posix())
def test_private_names_are_used_in_one_place(path: Path):
    place = path.relative_to(ROOT).as_posix()
    assert set(private_names(ast.parse(path.read_text(encoding="utf-8")))) == WHERE.get(place, set())
