"""`colias_sim` uses no private name of Gymnasium or the standard library, but for two that are tested here."""

from __future__ import annotations

import ast
import os
import re
import subprocess
import sys
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

import colias_sim
from colias_sim.envs.vector.pickling import SPAWNED_MAIN

FILES = sorted(Path(colias_sim.__file__).parent.rglob("*.py"))
PRIVATE = re.compile(r"_[a-z]\w*")


def names_used(tree: ast.AST) -> set[str]:
    """Private attributes that are read of anything, and private names that are imported."""
    used = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            used |= {part for alias in node.names for part in alias.name.split(".")}
    return {name for name in used if PRIVATE.fullmatch(name)}


def names_defined(tree: ast.AST) -> set[str]:
    """What a file defines itself: functions, classes, attributes and variables."""
    nodes = list(ast.walk(tree))
    names = {node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    names |= {node.attr for node in nodes if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)}
    return names | {node.id for node in nodes if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)}


def test_every_private_name_is_our_own():
    trees = {path: ast.parse(path.read_text()) for path in FILES}
    ours = set[str]().union(*(names_defined(tree) for tree in trees.values()))
    for path, tree in trees.items():
        assert names_used(tree) <= ours, path


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX")
def test_a_connection_is_made_from_a_file_descriptor():
    """As `colias_sim.envs.vector.bootstrap` does; the documentation does not say so."""
    ours, theirs = Pipe()
    with ours, Connection(os.dup(theirs.fileno())) as copy:
        theirs.close()
        ours.send(["some", 1])
        assert copy.recv() == ["some", 1]


def test_processes_of_multiprocessing_know_the_script_by_this_name(tmp_path):
    """As `colias_sim.envs.vector.pickling` assumes."""
    script = tmp_path / "script.py"
    script.write_text(
        "import multiprocessing, sys\n"
        f"def known(_):\n    return sys.modules[{SPAWNED_MAIN!r}].__name__\n"
        "if __name__ == '__main__':\n"
        "    with multiprocessing.get_context('spawn').Pool(1) as pool:\n"
        "        print(pool.map(known, [0]), known(0))\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == f"[{SPAWNED_MAIN!r}] __main__\n"
