"""Runs cut short: what is there is readable, and the same command does just the rest."""

import shutil
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path

import pytest
from filelock import FileLock

from experiments.bench.run.folder import has_tables, read_table
from tests.conftest import Colias

QUICK = ("--set", "experiment.speeds_cm_s=20,30", "--no-recordings", "--workers", "0")
SLOW = ("--set", "experiment.speeds_cm_s=9,10", "--repeats", "4", "--no-recordings", "--workers", "2")
TRIALS = 8
"""Trials of `SLOW`: enough, and long enough, on any machine, for a run to be caught in the middle."""
COMMAND = [sys.executable, "-m", "experiments.bench.cli", "run", "speed"]


def trials(folder: Path):
    """What is there of a run, whole or in parts."""
    return read_table(folder, "trials").drop(["wall_s"])


def start(folder: Path, *arguments: str) -> subprocess.Popen[str]:
    heed = partial(signal.signal, signal.SIGINT, signal.SIG_DFL)
    return subprocess.Popen([*COMMAND, *arguments], cwd=folder, stderr=subprocess.PIPE, text=True, preexec_fn=heed)


def wait_for_trials(folder: Path, count: int, process: subprocess.Popen[str]) -> None:
    deadline = time.monotonic() + 60
    while not (has_tables(folder) and trials(folder).height >= count):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.02)


def children_of(pid: int) -> list[int]:
    children = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            children.append(int(stat.parent.name))
    return children


def alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def gone(pids: list[int], seconds: float) -> bool:
    deadline = time.monotonic() + seconds
    while any(map(alive, pids)):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.05)
    return True


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The run as it is when nothing goes wrong, in one process."""
    colias = Colias(tmp_path_factory.mktemp("whole"))
    assert colias("run", "speed", *SLOW[:-1], "0", "--out", "out", "-q").returncode == 0
    return trials(colias.folder / "out")


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A folder of a short run; it is not written to."""
    colias = Colias(tmp_path_factory.mktemp("small"))
    assert colias("run", "speed", *QUICK, "--repeats", "1", "--out", "out", "-q").returncode == 0
    return colias.folder / "out"


def test_a_killed_driver_leaves_no_workers_and_resumes(colias, tmp_path, whole):
    """The trials that were finished stay, each once, with their frames and recordings."""
    command = [word for word in SLOW if word != "--no-recordings"]
    process = start(tmp_path, *command, "--out", "out")
    wait_for_trials(tmp_path / "out", 1, process)
    workers = children_of(process.pid)
    process.kill()
    process.communicate(timeout=60)  # its pipes are open as long as a worker is there
    assert len(workers) >= 2 and gone(workers, 20)
    left = trials(tmp_path / "out")["trial"].to_list()
    assert 1 <= len(left) < TRIALS and left == sorted(set(left))
    assert set(left) <= set(read_table(tmp_path / "out", "frames")["trial"].to_list())
    recordings = [tmp_path / "out" / "recordings" / f"trial-{number:04d}.rrd" for number in left]
    assert all(path.read_bytes()[-12:].startswith(b"RRF2FOOT") for path in recordings), "whole"
    resumed = colias("run", "speed", *command[:-1], "0", "--out", "out")
    assert resumed.returncode == 0 and f"{len(left)} of them done already" in resumed.stderr
    assert trials(tmp_path / "out").equals(whole), "every trial once, with the values of an undisturbed run"
    assert (tmp_path / "out" / "figure.png").exists()


def test_resume_refuses_other_parameters_and_names_them(colias, small):
    shutil.copytree(small, colias.folder / "out")
    for change, says in {
        ("--seed", "7"): "out: seed is 0 there and 7 now",
        ("--repeats", "2"): "out: repeats is 1 there and 2 now",
        ("--set", "camera.read_noise=0"): "camera.read_noise is 0.64 there and 0.0 now",
        ("--set", "dsnn.n_con=6"): "dsnn.n_con is 8 there and 6 now",
    }.items():
        done = colias("run", "speed", *QUICK, "--repeats", "1", *change, "--out", "out")
        assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
        assert says in done.stderr
    for command in (("run", "distance"), ("tune",), ("behave", "still")):
        done = colias(*command, "--out", "out", "--workers", "0")
        assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
        assert done.stderr.startswith('error: out: experiment is "speed" there and '), done.stderr


def test_a_finished_run_is_complete_and_not_redone(colias, small):
    shutil.copytree(small, colias.folder / "out")
    before = (colias.folder / "out" / "trials.parquet").read_bytes()
    done = colias("run", "speed", *QUICK, "--repeats", "1", "--out", "out")
    assert done.returncode == 0 and "complete: all 2 of them done already, in out" in done.stderr
    assert (colias.folder / "out" / "trials.parquet").read_bytes() == before


def test_two_runs_into_one_folder_are_refused(colias, small):
    out = shutil.copytree(small, colias.folder / "out")
    with FileLock(out / ".lock"):
        second = colias("run", "speed", *QUICK, "--repeats", "1", "--out", "out")
    assert (second.returncode, second.stderr.count("\n")) == (2, 1), second.stderr
    assert "another process is writing" in second.stderr
