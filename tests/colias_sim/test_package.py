"""The packages as a library: public names, documentation of fields, types, and the order of imports."""

from __future__ import annotations

import ast
import dataclasses
import importlib
import inspect
import re
import subprocess
import sys
import types
from pathlib import Path
from typing import Any

import pytest

import colias_sim
import dsnn
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from dsnn.stimuli.stimulus import TimedParams

ROOT = Path(colias_sim.__file__).parents[1]
PARAMETERS = [getattr(dsnn, name) for name in dsnn.__all__ if name.endswith("Params")]


@pytest.mark.parametrize("package", [colias_sim, dsnn], ids=lambda package: package.__name__)
def test_all_is_complete_and_sorted(package: types.ModuleType) -> None:
    imported = {
        alias.asname or alias.name
        for node in ast.walk(ast.parse(Path(str(package.__file__)).read_text()))
        if isinstance(node, ast.ImportFrom) and str(node.module).partition(".")[0] == package.__name__.partition(".")[0]
        for alias in node.names
    }
    public = imported - {"choose_backend"} | ({"__version__"} if hasattr(package, "__version__") else set())
    assert set(package.__all__) == public
    order = [(not name.isupper(), not name[0].isupper(), name) for name in package.__all__]
    assert order == sorted(order)


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


def test_the_version_is_that_of_the_distribution() -> None:
    assert re.fullmatch(r"\d+(\.\d+)*\S*", colias_sim.__version__)


@pytest.mark.parametrize("package", ["colias_sim", "dsnn", "scenes", "experiments"])
def test_packages_are_marked_as_typed(package: str) -> None:
    assert (ROOT / package / "py.typed").read_bytes() == b""


@pytest.mark.parametrize("cls", [*PARAMETERS, TimedParams, RobotConfig, CameraConfig, SceneConfig], ids=str)
def test_help_describes_every_field(cls: Any) -> None:
    """Those that a class inherits too; each with its default."""
    section = (inspect.getdoc(cls) or "").partition("\n\nParameters\n----------\n")[2]
    for field in dataclasses.fields(cls):
        ((kind, said),) = re.findall(rf"^{field.name} : (.+)\n    (.+)\.(?: Unit: .*)?$", section, re.M)
        assert kind.endswith(f"default {cls.__pydantic_fields__[field.name].default!r}") and len(said) > 5


def test_ranges_are_those_of_the_fields() -> None:
    page = str(dsnn.DSNNParams.__doc__)
    assert "n_p : int in [0, 60], default 2" in page
    assert "sigma_l : float in [0, 1), default 0.1" in page
    assert "tau_s : tuple[float, float] in [0, 10000], default (10.0, 200.0)" in page
