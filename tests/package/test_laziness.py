"""Importing builds nothing, declaring paints nothing, and what starts often loads little."""

import importlib
import subprocess
import sys

import pytest

from dsnn.stimuli import stimulus
from experiments import Clip

HEAVY = {"mujoco", "OpenGL", "rerun", "scipy", "matplotlib"}
"""Top-level packages that take their time to load, or load those that do."""

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


@pytest.mark.parametrize(("name", "painter"), [("street", "pink"), ("cluttered", "panorama")])
def test_a_clip_paints_nothing_until_its_first_frame(name, painter, monkeypatch):
    """Every declaration of clips makes them, to check them; `colias list` reads all declarations."""
    module = importlib.import_module(f"dsnn.stimuli.{name}")
    painted, paint = [], getattr(module, painter)
    monkeypatch.setattr(module, painter, lambda *given: painted.append(given) or paint(*given))
    Clip("one", name)
    clip = stimulus(name)
    assert len(clip) > 1 and not painted
    clip.frame(0)
    assert painted


@pytest.mark.parametrize(
    ("module", "without"),
    [
        ("colias_sim", HEAVY | {"pyarrow", "cv2"}),
        ("colias_sim.envs.registry", HEAVY | {"pyarrow", "cv2"}),
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


COMMAND = """
import atexit, sys

atexit.register(lambda: print(*sys.modules, file=sys.stderr))
from experiments.bench.cli import entry

entry.main()
"""


@pytest.mark.parametrize(
    ("command", "without"),
    [
        (["--help"], HEAVY | {"numpy", "pyarrow", "cv2", "gymnasium"}),
        (["list"], HEAVY | {"pyarrow"}),
        (["parameters"], HEAVY),
        (["runs", "."], HEAVY | {"gymnasium"}),
    ],
    ids=lambda value: value[0] if isinstance(value, list) else "",
)
def test_a_command_that_only_lists_loads_little(command, without, tmp_path):
    """A whole command in a process of its own, and the modules it has loaded when it ends."""
    done = subprocess.run(
        [sys.executable, "-c", COMMAND, *command], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    loaded = set(done.stderr.split())
    assert "typer" in loaded
    assert not without & loaded
