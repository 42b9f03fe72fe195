"""Processes that are started on the way, by us or by somebody's model: none is left, and none that is not ours ends."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from multiprocessing import get_context
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from experiments.bench.engine.jobs import Jobs
from experiments.bench.engine.pool import open_pool
from experiments.bench.store.tables import parts_of
from tests.helpers import user_files
from tests.helpers.processes import CLI, alive, members, start, wait_until

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("blow", ["SIGTERM", "SIGINT", "SIGHUP", "SIGKILL"])
def test_the_web_viewer_ends_with_the_command(tmp_path, blow):
    """Its server, told to be this small program: it notes its process, and never ends by itself."""
    server = tmp_path / "rerun"
    server.write_text("#!/bin/sh\necho $$ > started.part\nmv started.part started\nexec sleep 600\n")
    server.chmod(0o755)
    (tmp_path / "some.rrd").write_bytes(b"")
    process = start(tmp_path, *CLI, "view", "--web", "some.rrd", PYTHONPATH=str(ROOT), RERUN_CLI_PATH=str(server))
    try:
        assert wait_until(lambda: (tmp_path / "started").exists() or process.poll() is not None)
        child = int((tmp_path / "started").read_text())
        assert alive(child)
        process.send_signal(getattr(signal, blow))
        assert wait_until(lambda: process.poll() is not None, 20)
        assert wait_until(lambda: not alive(child), 20)
        number = getattr(signal, blow)
        assert process.returncode == (-number if blow == "SIGKILL" else 128 + number)
    finally:
        process.kill()
        if (tmp_path / "started").exists() and alive(int((tmp_path / "started").read_text())):
            os.kill(int((tmp_path / "started").read_text()), signal.SIGKILL)
        process.communicate(timeout=20)


MISBEHAVE = {
    "a process": "__import__('subprocess').Popen(['sleep', '600'])",
    "a copy that stays": "os.fork() or time.sleep(600)",
    "a copy that goes on": "os.fork()",
}


def write_model(folder: Path, what: str) -> None:
    """The model of docs/your-own-model.md, which does ``what`` at its first step."""
    lines = f"        if not hasattr(self, 'did'):\n            self.did = {what}\n        down, right"
    text = "import os, time\n" + user_files.MODEL.replace("        down, right", lines, 1)
    (folder / "my_model.py").write_text(text)


@pytest.mark.parametrize(("kind", "workers"), [(kind, 1) for kind in MISBEHAVE] + [("a copy that stays", 2)])
def test_what_a_model_starts_ends_with_the_run(tmp_path, kind, workers):
    write_model(tmp_path, MISBEHAVE[kind])
    command = (*CLI, "run", "speed", "--set", "experiment.speeds_cm_s=20,30", "--repeats", "1", "--no-recordings")
    process = start(tmp_path, *command, "--only", "--model", "my_model.py", "--out", "out", "--workers",
                    f"{workers}", "-q",
                    PYTHONPATH=str(ROOT))  # fmt: skip
    output = process.communicate(timeout=200)
    assert (process.returncode, output) == (0, ("", ""))
    assert pq.read_table(tmp_path / "out" / "trials.parquet")["trial"].to_pylist() == [0, 1]
    assert wait_until(lambda: not members(process.pid), 10)


def test_what_a_model_starts_ends_with_a_killed_driver(tmp_path):
    write_model(tmp_path, "os.fork() or time.sleep(600)")
    command = (*CLI, "run", "speed", "--set", "experiment.speeds_cm_s=20", "--repeats", "500", "--no-recordings")
    process = start(tmp_path, *command, "--model", "my_model.py", "--out", "out", "--workers", "1",
                    PYTHONPATH=str(ROOT))  # fmt: skip
    try:
        assert wait_until(lambda: parts_of(tmp_path / "out") or process.poll() is not None)
        assert process.poll() is None
    finally:
        process.kill()
        process.communicate(timeout=60)
    assert wait_until(lambda: not members(process.pid), 20)


def idle() -> None:
    time.sleep(600)


def double(job: int) -> int:
    return 2 * job


def die(job: int) -> int:
    os.kill(os.getpid(), signal.SIGKILL)
    return job


def test_a_pool_ends_its_own_workers_alone():
    """A process that was started beside it, after it, outlives a worker's death and the pool's end."""
    other = get_context("spawn").Process(target=idle, daemon=True)
    done, failed = [], []
    try:
        with open_pool(1) as pool:
            other.start()
            Jobs(pool, die, done.append, lambda job, *_: failed.append(job)).run([1])
            Jobs(pool, double, done.append, lambda job, *_: failed.append(job)).run([2])
            assert other.is_alive()
        assert other.is_alive()
        assert (done, failed) == ([4], [1])
    finally:
        other.kill()
        other.join()


FORKED = """
import os
from experiments.bench.engine.jobs import Jobs
from experiments.bench.engine.pool import open_pool

def forked(job):
    child = os.fork()
    return os.getpid(), child

with open_pool(0) as pool:
    Jobs(pool, forked, lambda done: print(*done, os.getpid(), flush=True), lambda *_: print("failed")).run([1])
print(os.waitpid(-1, 0)[1], "over")
"""


def test_a_copy_made_by_a_job_does_not_answer_for_it(tmp_path):
    """Both branches of a fork return to us; the copy's then ends."""
    process = start(tmp_path, sys.executable, "-c", FORKED, PYTHONPATH=str(ROOT))
    printed, errors = process.communicate(timeout=60)
    assert errors == ""
    (worker, _, driver), (status, over) = (line.split() for line in printed.splitlines())
    assert (worker, status, over) == (driver, "0", "over")


def test_a_folder_is_free_once_its_run_is_over(tmp_path):
    """In a process that goes on: another may then write there."""
    code = (
        "from pathlib import Path\n"
        "from experiments.bench import registry\n"
        "from experiments.bench.engine.batch import Resources\n"
        "from experiments.bench.robot.plan import plan\n"
        "from experiments.bench.robot.run import run\n"
        "if __name__ == '__main__':\n"
        "    made = plan(registry.load('speed'), ['dsnn'], ['experiment.speeds_cm_s=20'], 1, 0)\n"
        "    run(made, Path('out'), Resources(0, None, True), recordings=False)\n"
        "    import fcntl\n"
        "    with open('out/.lock', 'w') as lock:\n"
        "        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)\n"
        "    made = plan(registry.load('speed'), ['dsnn'], ['experiment.speeds_cm_s=20'], 1, 0)\n"
        "    run(made, Path('out'), Resources(0, None, True), recordings=False)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, timeout=200, check=False,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
