"""Ctrl-C at any moment: status 130, no traceback, nothing left running, and a folder that can be gone on with."""

import os
import signal
import sys
import time
from pathlib import Path

import polars as pl

from tests.helpers.inside import inside
from tests.helpers.processes import CLI, members, start, wait_until

ROOT = Path(__file__).parents[3]
RUN = ("run", "speed", "--set", "experiment.speeds_cm_s=20", "--repeats", "2", "--no-recordings", "--workers", "2")

# The entry point itself, which says when it has begun.
READY = """
import sys
from experiments.cli import entry
entry.begin()
print("ready", flush=True)
sys.argv[0] = "colias"
entry.run()
"""


def test_ctrl_c_at_two_moments(tmp_path):
    """Sent to the command alone, and to all of its group as a terminal does, in turns."""
    out = ""
    for number, moment in enumerate((0.5, 2.5)):
        out = f"out{number}"
        process = start(tmp_path, sys.executable, "-c", READY, *RUN[:-1], "1", "--out", out, PYTHONPATH=str(ROOT))
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        time.sleep(moment)
        (os.killpg if number % 2 else os.kill)(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        if process.returncode == 0:  # a machine so fast that it was done
            break
        assert process.returncode == 130, (moment, errors)
        assert errors.endswith("colias: interrupted\n") and "Traceback" not in errors, (moment, errors)
        assert wait_until(lambda pid=process.pid: not members(pid), 10), moment
    # What the last left is gone on with, or made anew.
    again = inside(tmp_path, [*RUN[:-1], "0", "--out", out])
    assert again.returncode == 0, again.stderr
    assert pl.read_parquet(tmp_path / out / "trials.parquet").height == 2


def test_workers_that_still_start_say_nothing(tmp_path):
    """The whole group is sent Ctrl-C twice while the workers import."""
    process = start(tmp_path, *CLI, *RUN, "-q", PYTHONPATH=str(ROOT))
    assert wait_until(lambda: len(members(process.pid)) >= 3)
    os.killpg(process.pid, signal.SIGINT)
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in errors and errors.endswith("colias: interrupted\n"), errors
    assert wait_until(lambda: not members(process.pid), 10)
