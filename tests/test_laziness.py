"""Importing builds nothing."""

import subprocess
import sys

import pytest

COUNT = """
from dsnn.stimuli.stimulus import Stimulus

built, first = [], Stimulus.__init__


def counted(self, *arguments):
    built.append(type(self).__name__)
    first(self, *arguments)


Stimulus.__init__ = counted
from experiments.bench.cli import main as cli_main
from experiments.bench.tuning import table as tuning_table
from experiments.bench.tuning import probes
from experiments.bench.tuning import curves
from experiments.bench.tuning import figure as tuning_figure
from experiments.bench.tuning import preferences
from experiments.bench.tuning import run as tuning_run

print(len(built))
probes.families(["size"])
print(len(built))
"""


def test_importing_the_tuning_curves_builds_no_stimulus():
    """All 166 were: half a second of every command that went near them."""
    done = subprocess.run([sys.executable, "-c", COUNT], capture_output=True, text=True, check=True)
    on_import, of_one_family = map(int, done.stdout.split())
    assert on_import == 0
    assert 0 < of_one_family < 30


@pytest.mark.parametrize(
    ("module", "without"),
    [
        ("experiments", {"mujoco", "rerun", "matplotlib", "pyarrow", "cv2"}),
        ("experiments.bench.cli.main", {"mujoco", "rerun", "matplotlib", "pyarrow", "cv2"}),
        ("experiments.bench.cli.viewer", {"mujoco", "rerun", "matplotlib"}),
        ("experiments.bench.robot.run", {"rerun", "matplotlib", "typer"}),
        ("experiments.bench.clips.show", {"rerun", "matplotlib", "typer"}),
        ("experiments.bench.closed_loop.run", {"rerun", "matplotlib", "typer"}),
    ],
)
def test_what_starts_often_loads_little(module, without):
    """A command's help answers at once, and a worker loads neither the recorder nor the plotting it may never use."""
    code = f"import sys, {module}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not without & set(done.stdout.split())
