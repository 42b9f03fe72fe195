"""Ctrl-C at any moment: status 130, no traceback, nothing left running, and a folder that can be gone on with."""

from __future__ import annotations

import os
import signal
import sys
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from tests.helpers.processes import CLI, members, start, wait_until

ROOT = Path(__file__).parents[3]
RUN = ("run", "speed", "--set", "experiment.speeds_cm_s=20", "--repeats", "2", "--no-recordings", "--workers", "2")

# Sends this process a SIGINT, as a terminal would, in the middle of the import of one module.
SENDER = """
import os, signal, sys
class Sender:
    def find_spec(self, name, path=None, target=None):
        if name == os.environ["INTERRUPT_AT"] and os.environ.get("MAIN_ID", str(os.getpid())) == str(os.getpid()):
            sys.meta_path.remove(self)
            os.kill(os.getpid(), signal.SIGINT)
        return None
sys.meta_path.insert(0, Sender())
os.environ.setdefault("MAIN_ID", str(os.getpid()))
"""


def interrupted_at(tmp_path: Path, module: str, *command: str):
    site = tmp_path / "site"
    site.mkdir()
    (site / "sitecustomize.py").write_text(SENDER)
    paths = os.pathsep.join(filter(None, (str(site), str(ROOT), os.environ.get("PYTHONPATH", ""))))
    process = start(tmp_path, *command, INTERRUPT_AT=module, PYTHONPATH=paths)
    _, errors = process.communicate(timeout=120)
    return process, errors


@pytest.mark.parametrize(
    "module",
    [
        "typer", "rich.console", "numpy", "numpy._core.multiarray", "pydantic", "mujoco", "OpenGL.EGL", "cv2",
        "pyarrow", "pyarrow.parquet", "scipy.special", "matplotlib", "multiprocessing.popen_spawn_posix",
    ],
)  # fmt: skip
def test_ctrl_c_while_a_library_is_imported(tmp_path, module):
    """Inside compiled libraries Python's exception is lost, or turns into another."""
    repeats = ("--repeats", "3") if module == "scipy.special" else ()  # fewer have no interval, and do without it
    process, errors = interrupted_at(tmp_path, module, *CLI, *RUN, *repeats, "--out", "out")
    assert (process.returncode, errors.splitlines()[-1]) == (130, "colias: interrupted"), errors
    assert "Traceback" not in errors and "Exception" not in errors
    assert wait_until(lambda: not members(process.pid), 10)


@pytest.mark.parametrize("name", ["speed.py", "clean.py", "train_ppo.py"])
def test_an_experiment_s_own_file_is_guarded_from_its_first_line(tmp_path, name):
    module = "typer" if name == "train_ppo.py" else "pydantic"
    process, errors = interrupted_at(tmp_path, module, sys.executable, str(ROOT / "experiments" / name), "-h")
    assert (process.returncode, errors) == (130, "colias: interrupted\n")


# The entry point itself, which says when it has begun.
READY = """
import sys
from experiments.bench.cli import entry
entry.begin()
print("ready", flush=True)
sys.argv[0] = "colias"
entry.run()
"""


def test_ctrl_c_at_many_moments(tmp_path):
    """Sent to the command alone, and to all of its group as a terminal does, in turns."""
    out = ""
    for number, moment in enumerate(0.4 * n for n in range(8)):
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
    again = start(tmp_path, *CLI, *RUN[:-1], "1", "--out", out, PYTHONPATH=str(ROOT))
    _, errors = again.communicate(timeout=120)
    assert again.returncode == 0, errors
    assert pq.read_table(tmp_path / out / "trials.parquet").num_rows == 2


def test_workers_that_still_start_say_nothing(tmp_path):
    """The whole group is sent Ctrl-C again and again while the workers import."""
    for _ in range(3):
        process = start(tmp_path, *CLI, *RUN, "-q", PYTHONPATH=str(ROOT))
        assert wait_until(lambda pid=process.pid: len(members(pid)) >= 3)
        os.killpg(process.pid, signal.SIGINT)
        os.killpg(process.pid, signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 130
        assert "Traceback" not in errors and errors.endswith("colias: interrupted\n"), errors
        assert wait_until(lambda pid=process.pid: not members(pid), 10)


def test_a_clip_cut_short_leaves_no_part(tmp_path):
    command = (*CLI, "stimulus", "cluttered", "--out", "clip.avi", "--set", "cluttered.speed=1")
    process = start(tmp_path, *command, PYTHONPATH=str(ROOT))
    assert wait_until(lambda: list(tmp_path.glob("*.part.avi")) or process.poll() is not None)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert errors == "colias: interrupted\n"
    assert list(tmp_path.iterdir()) == []


def test_an_ignored_ctrl_c_stays_ignored(tmp_path):
    """Started by a shell in the background, a run goes on."""
    script = f"trap '' INT; exec {' '.join(CLI)} {' '.join(RUN)} -q --out out"
    process = start(tmp_path, "sh", "-c", script, PYTHONPATH=str(ROOT))
    assert wait_until(lambda: len(members(process.pid)) >= 3 or process.poll() is not None)
    os.kill(process.pid, signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    assert (process.returncode, errors) == (0, "")
