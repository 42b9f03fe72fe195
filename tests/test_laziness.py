"""Importing builds nothing."""

import subprocess
import sys

COUNT = """
from dsnn.stimuli.stimulus import Stimulus

built, first = [], Stimulus.__init__


def counted(self, *arguments):
    built.append(type(self).__name__)
    first(self, *arguments)


Stimulus.__init__ = counted
from experiments.bench import cli, console_tune, tuning, tuning_curves, tuning_figures, tuning_preferences, tuning_run

print(len(built))
tuning.families(["size"])
print(len(built))
"""


def test_importing_the_tuning_curves_builds_no_stimulus():
    """All 166 were: half a second of every command that went near them."""
    done = subprocess.run([sys.executable, "-c", COUNT], capture_output=True, text=True, check=True)
    on_import, of_one_family = map(int, done.stdout.split())
    assert on_import == 0
    assert 0 < of_one_family < 30
