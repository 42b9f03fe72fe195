"""The packages as a library: public names, documentation of fields, types, and the order of imports."""

from __future__ import annotations

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

import colias_sim

LOOKED_UP = """
import os, pickle, pydoc, sys
import colias_sim

missing = set(colias_sim.__all__) - set(dir(colias_sim))
assert not missing, missing
assert "mujoco" not in sys.modules and "colias_sim.simulation" not in sys.modules
assert os.environ["MUJOCO_GL"]  # chosen before mujoco is imported
assert pickle.loads(b"ccolias_sim\\nFrame\\n.") is colias_sim.Frame
from colias_sim import *

assert Simulation is colias_sim.Simulation is sys.modules["colias_sim.simulation"].Simulation
assert "mujoco" in sys.modules
assert "class Simulation" in pydoc.plaintext.document(colias_sim)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="another platform's backend needs no variable")
def test_names_that_need_mujoco_are_looked_up_when_they_are_asked_for() -> None:
    """In a process of its own, which has not looked them up yet: `dir`, pickles, ``import *`` and `help` see them."""
    subprocess.run([sys.executable, "-c", LOOKED_UP], check=True)


def test_names_that_are_looked_up_are_those_that_type_checkers_see() -> None:
    """Each of the imports under ``TYPE_CHECKING`` is what the package has at run time, and there is no other name."""
    tree = ast.parse(Path(str(colias_sim.__file__)).read_text())
    (seen,) = (node for node in tree.body if isinstance(node, ast.If))
    named = [(str(statement.module), alias.name) for statement in seen.body if isinstance(statement, ast.ImportFrom)
             for alias in statement.names]  # fmt: skip
    assert named
    for module, name in named:
        assert getattr(colias_sim, name) is getattr(importlib.import_module(module), name)
    with pytest.raises(AttributeError, match="colias_sim attribute camera_"):
        _ = colias_sim.camera_
