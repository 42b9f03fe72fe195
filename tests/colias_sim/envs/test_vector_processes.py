"""The processes of a vector env: whatever happens to one is one clear error, and none is left behind."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gymnasium import error

import colias_sim
from dsnn import Response
from tests.helpers.vector import actions, make

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(colias_sim.__file__).parents[1])}


def gone(pids: list[int]) -> bool:
    """Whether these processes end within some seconds."""
    deadline = time.monotonic() + 20
    while any(Path(f"/proc/{pid}").exists() and "zombie" not in status(pid) for pid in pids):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.02)
    return True


def status(pid: int) -> str:
    try:
        return Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return "zombie"


CHILDREN = """
import os
from pathlib import Path

def children():
    found = []
    for entry in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = entry.read_text().rpartition(")")[2].split()[1]
        except OSError:
            continue
        if int(parent) == os.getpid():
            found.append(int(entry.parent.name))
    return found
"""
"""For a script; ``children()`` lists also those that have ended and were not asked how."""
_here: dict[str, Any] = {}
exec(CHILDREN, _here)


def workers() -> list[int]:
    return [pid for pid in _here["children"]() if "colias_sim" in Path(f"/proc/{pid}/cmdline").read_text()]


@pytest.fixture(autouse=True)
def nothing_left() -> Iterator[None]:
    before = set(_here["children"]())
    yield
    gc.collect()
    assert set(_here["children"]()) <= before


class Failing:
    """A model's factory in a worker: kills it, or raises, when built or at a later frame; "lose" as a pipe would."""

    def __init__(self, how: str, frame: int) -> None:
        self.how, self.left = how, frame

    def __call__(self, shape: tuple[int, int]) -> Failing:
        self._fail()
        return self

    def step(self, frame: np.ndarray) -> Response:
        self._fail()
        return Response()

    def reset(self) -> None: ...

    def _fail(self) -> None:
        self.left -= 1
        if self.left < 0 and self.how == "kill":
            os.kill(os.getpid(), signal.SIGKILL)
        if self.left < 0 and self.how == "lose":
            raise ConnectionResetError("no picture")
        if self.left < 0:
            raise colias_sim.GLUnavailable("no picture")


@pytest.mark.parametrize("how", ["kill", "raise", "lose"])
@pytest.mark.parametrize("frame", [0, 6])
def test_a_failing_worker_is_one_error_and_the_end(how: str, frame: int) -> None:
    raised: dict[str, type[Exception]] = {"kill": RuntimeError, "lose": ConnectionResetError}
    expected = raised.get(how, colias_sim.GLUnavailable)
    message = r"envs 0\.\.1 died, signal SIGKILL" if how == "kill" else "no picture"
    if frame == 0:
        with pytest.raises(expected, match=message):
            make(2, workers=1, observation="neural", model=Failing(how, frame))
        return
    env = make(2, workers=1, observation="neural", model=Failing(how, frame))
    env.reset(seed=0)
    with pytest.raises(expected, match=message) as caught:
        for action in actions(5, 2):
            env.step(action)
    assert how == "kill" or "envs 0..1" in "".join(caught.value.__notes__)
    with pytest.raises(error.ClosedEnvironmentError):
        env.step(actions(1, 2)[0])


def test_a_worker_killed_between_steps_is_one_error() -> None:
    env = make(2, workers=2, observation="state")
    env.reset(seed=0)
    pids = workers()
    os.kill(pids[0], signal.SIGKILL)
    with pytest.raises(RuntimeError, match=r"env [01] died, signal SIGKILL: this vector env is closed"):
        env.step(actions(1, 2)[0])
    assert env.closed and gone(pids)


def test_no_opengl_in_a_worker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "off")  # this process has chosen already, its workers choose anew
    with pytest.raises(colias_sim.GLUnavailable, match="no OpenGL library"):
        make(2, workers=1)


def test_garbage_collection_ends_the_workers() -> None:
    env = make(2, workers=1, observation="state")
    pids = workers()
    del env
    gc.collect()
    assert gone(pids)


SCRIPT = (
    CHILDREN
    + """
import gymnasium as gym, numpy as np, sys, time
import colias_sim
if __name__ == "__main__":
    env = gym.make_vec("colias_sim/Fixation-v0", num_envs=2, observation="state")
    env.reset(seed=0)
    print(*children(), flush=True)
    if sys.argv[1:] == ["fork"] and os.fork() == 0:
        time.sleep(60)  # a copy of all pipes lives on
        os._exit(0)
    while len(sys.argv) > 1:
        env.step(np.zeros((2, 2)))
"""
)


def heeds_interrupts() -> None:
    """What a shell starts in the background is deaf to Ctrl-C, and so is all that comes of it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.mark.parametrize("end", [None, signal.SIGINT, signal.SIGTERM, signal.SIGKILL], ids=str)
def test_the_workers_go_with_their_parent(end: signal.Signals | None, tmp_path: Path) -> None:
    """At its own end nothing is said; Ctrl-C, which goes to all, shows one traceback."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    process = subprocess.Popen(
        [sys.executable, "-W", "error", script, *(["run"] if end else [])], env=ENVIRONMENT, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True, preexec_fn=heeds_interrupts,
    )  # fmt: skip
    assert process.stdout is not None
    pids = [int(pid) for pid in process.stdout.readline().split()]
    assert len(pids) == min(2, len(os.sched_getaffinity(0)))
    if end == signal.SIGINT:
        os.killpg(process.pid, end)
    elif end:
        process.send_signal(end)
    try:
        _, complaints = process.communicate(timeout=60)
    finally:
        process.kill()  # whatever has gone wrong, it does not go on for ever
    assert gone(pids)
    assert complaints.count("Traceback") == (1 if end == signal.SIGINT else 0), complaints
    assert "leaked" not in complaints


def test_the_workers_of_a_killed_parent_do_not_wait_for_its_forked_copy(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(SCRIPT.replace("    while len", "    print(*children(), flush=True)\n    while len"))
    process = subprocess.Popen(
        [sys.executable, script, "fork"], env=ENVIRONMENT, text=True, stdout=subprocess.PIPE, start_new_session=True
    )
    assert process.stdout is not None
    try:
        before, after = ({int(pid) for pid in process.stdout.readline().split()} for _ in range(2))
        assert len(after - before) == 1 <= len(before)
        process.kill()
        assert gone(list(before))
        assert all("zombie" not in status(pid) for pid in after - before)
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


FORKING = """
import gymnasium as gym, numpy as np, os, sys
import colias_sim
env = gym.make_vec("colias_sim/Fixation-v0", num_envs=2, workers=1, observation="state")
env.reset(seed=0)
child = os.fork()
if child == 0:
    try:
        env.step(np.zeros((2, 2)))
    except RuntimeError as error:
        print(error)
    env.close()
    sys.exit(0)
assert os.waitpid(child, 0)[1] == 0
env.step(np.zeros((2, 2)))
env.close()
"""


def test_a_forked_copy_neither_steps_nor_closes_it(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", FORKING], env=ENVIRONMENT, capture_output=True, text=True, timeout=120
    )
    assert (done.stderr, done.returncode) == ("", 0)
    assert "belongs to the process that made it" in done.stdout


def sockets(*arguments: Any) -> list[str]:
    """The sockets and shared memory that a process has open."""
    links = [str(entry.readlink()) for entry in Path("/proc/self/fd").iterdir() if entry.is_symlink()]
    return [link for link in links if link.startswith("socket:") or "colias" in link]


def test_a_process_has_no_other_ones_files() -> None:
    listing = ["ls", "-l", "/proc/self/fd"]
    before = subprocess.run(listing, close_fds=False, capture_output=True, text=True, check=True)
    envs = [make(2, workers=2, observation="state") for _ in range(2)]
    after = subprocess.run(listing, close_fds=False, capture_output=True, text=True, check=True)
    assert after.stdout.count("\n") == before.stdout.count("\n")
    for env in envs:
        env.set_attr("sockets", sockets)
        assert [len(open_sockets) for open_sockets in env.call("sockets")] == [2, 2]  # its pipe and its board
        env.close()


def test_a_dying_worker_says_by_which_signal() -> None:
    """Signals without a name of their own too."""
    env = make(2, workers=1, observation="state")
    env.set_attr("die", [lambda: os.kill(os.getpid(), signal.SIGRTMIN + 1)] * 2)
    with pytest.raises(
        RuntimeError, match=rf"envs 0\.\.1 died, signal {signal.SIGRTMIN + 1}: this vector env is closed"
    ):
        env.call("die")
    assert env.closed


@pytest.mark.parametrize(("number", "cycles"), [(0, 25), (1, 6)])
def test_cycles_leave_threads_files_and_memory_alone(number: int, cycles: int) -> None:
    """What leaks is left by every cycle; the allocator's arenas grow in a few of them, by some megabytes at a time."""

    def cycle() -> tuple[int, int, int]:
        env = make(2, workers=number, observation="state" if number else "pixels")
        env.reset(seed=0)
        env.step(actions(1, 2)[0])
        env.close()
        gc.collect()
        resident = int(Path("/proc/self/statm").read_text().split()[1]) * 4096
        return threading.active_count(), len(list(Path("/proc/self/fd").iterdir())), resident

    seen = [cycle() for _ in range(cycles)]
    assert seen[-1][:2] == seen[4][:2]
    assert np.median(np.diff([resident for _, _, resident in seen[4:]])) < 400_000
