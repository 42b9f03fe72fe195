"""The packages as a library: public names, documentation of fields, types, and the order of imports."""

from __future__ import annotations

import subprocess
import sys

import pytest

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
