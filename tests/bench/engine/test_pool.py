"""The runner under fire: workers killed, jobs that fail, a driver killed, a full disk."""

import contextlib
import multiprocessing
import os
import signal
import struct
import subprocess
import sys
import threading
import time
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from experiments.bench.engine.jobs import ATTEMPTS, Jobs
from experiments.bench.engine.pool import InProcess, open_pool
from experiments.bench.engine.user_code import declared


def double(job):
    return 2 * job[0]


def die_or_double(job):
    """Kill this process: always for 13; once, leaving a mark, for 7."""
    number, folder = job
    mark = Path(folder) / f"died-{number}"
    with (Path(folder) / f"tried-{number}").open("a") as tries:
        tries.write("x")
    if number == 13 or (number == 7 and not mark.exists()):
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return 2 * number


def complain(job):
    if job[0] == 3:
        raise ValueError("three is not a number I like")
    return 2 * job[0]


def run(pool, work, numbers, folder="", fatal=()):
    done, failed = [], {}
    Jobs(
        pool, work, done.append, lambda job, attempts, error: failed.update({job[0]: (attempts, str(error))}), fatal
    ).run([(number, str(folder)) for number in numbers])
    return sorted(done), failed


@pytest.mark.parametrize("workers", [0, 1, 2])
def test_every_job_is_done_once(workers):
    with open_pool(workers) as pool:
        assert run(pool, double, range(20)) == ([2 * n for n in range(20)], {})


def test_a_job_whose_worker_dies_runs_again_and_the_rest_go_on(tmp_path):
    with open_pool(2) as pool:
        done, failed = run(pool, die_or_double, range(20), tmp_path)
    assert done == [2 * n for n in range(20) if n != 13]
    assert failed == {13: (ATTEMPTS, "its worker process died each time")}
    assert len((tmp_path / "tried-7").read_text()) == 2
    assert len((tmp_path / "tried-13").read_text()) == ATTEMPTS
    assert {len(path.read_text()) for path in tmp_path.glob("tried-*")} == {1, 2, ATTEMPTS}, "nobody else's is repeated"


def sending_ends(frame):
    """The pipes that the functions up the stack hold, whatever keeps the workers."""
    while frame is not None:
        for value in list(frame.f_locals.values()):
            parts = (value, *getattr(value, "__dict__", {}).values())
            yield from (part for part in parts if isinstance(part, Connection) and part.writable)
        frame = frame.f_back


def send_half(job):
    """Be killed while a result is on its way: once, leaving a mark."""
    mark = Path(job[1]) / f"sent-{job[0]}"
    if job[0] == 2 and not mark.exists():
        mark.touch()
        pipe = next(sending_ends(sys._getframe()))
        os.write(pipe.fileno(), struct.pack("!i", 1_000_000) + b"half")
        os.kill(os.getpid(), signal.SIGKILL)
    return 2 * job[0]


def test_a_worker_killed_while_it_sends_its_result_is_noticed(tmp_path):
    with open_pool(2) as pool:
        assert run(pool, send_half, range(5), tmp_path) == ([0, 2, 4, 6, 8], {})
    assert (tmp_path / "sent-2").exists()


def die_leaving_a_copy(job):
    """Be killed once, while a copy in a session of its own still holds all pipes."""
    note = Path(job[1]) / f"copy-{job[0]}"
    if job[0] == 1 and not note.exists():
        copy = os.fork()
        if not copy:
            os.setsid()
            time.sleep(600)
        note.write_text(str(copy))
        os.kill(os.getpid(), signal.SIGKILL)
    return 2 * job[0]


def test_a_dead_worker_s_copy_keeps_nobody_waiting(tmp_path):
    try:
        with open_pool(1) as pool:
            assert run(pool, die_leaving_a_copy, range(3), tmp_path) == ([0, 2, 4], {})
    finally:
        os.kill(int((tmp_path / "copy-1").read_text()), signal.SIGKILL)


def blocked(_):
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())


BLOCKED = """
import signal
from experiments.bench.engine.jobs import Jobs
from experiments.bench.engine.pool import open_pool
from tests.bench.engine.test_pool import blocked

if __name__ == "__main__":
    with open_pool(2) as pool:
        Jobs(pool, blocked, lambda done: print(done, flush=True), print).run(range(4))
    print(signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ()))
"""


def test_workers_are_born_deaf_to_ctrl_c(tmp_path):
    """In a process of its own, where multiprocessing starts its resource tracker, which may unblock SIGINT."""
    (tmp_path / "main.py").write_text(BLOCKED)
    done = subprocess.run(
        [sys.executable, "main.py"], cwd=tmp_path, capture_output=True, text=True, timeout=60, check=False,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])},
    )  # fmt: skip
    assert (done.stdout.split(), done.stderr) == (["True"] * 4 + ["False"], "")


@contextlib.contextmanager
def dask():
    from distributed import LocalCluster

    with (
        LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None, protocol="tcp://"
        ) as c,
        open_pool(0, c.scheduler_address) as pool,
    ):
        yield pool


POOLS = {"here": lambda: open_pool(0), "one worker": lambda: open_pool(1), "two": lambda: open_pool(2), "dask": dask}


@pytest.mark.parametrize("kind", POOLS)
def test_a_job_that_raises_fails_alone_with_its_traceback(kind):
    with POOLS[kind]() as pool:
        done, failed = run(pool, complain, range(6))
    assert done == [0, 2, 4, 8, 10]
    ((attempts, why),) = failed.values()
    assert attempts == 1 and why.endswith("ValueError: three is not a number I like")
    assert f'File "{__file__}", line {complain.__code__.co_firstlineno + 2}, in complain' in why


def test_a_refusal_is_one_line():
    told = []
    Jobs(InProcess(), partial(declared, name="MODEL"), print, lambda *failed: told.append(failed[-1])).run(
        [Path("absent.py")]
    )
    assert "absent.py" in told[0] and "\n" not in told[0]


class Odd(Exception):
    """Cannot be made again from its arguments: unpickling one fails."""

    def __init__(self, one, two):
        super().__init__(f"{one} and {two}")


class Fragile:
    """A job that cannot be unpickled where it is to be done."""

    def __init__(self, number):
        self.number = number

    def __reduce__(self):
        return explode, (self.number,)


def explode(number):
    raise LookupError(f"no {number} here")


def raise_odd(job):
    raise Odd(job[0], "more")


@pytest.mark.parametrize("workers", [0, 1])
def test_what_cannot_travel_is_told_in_words(workers):
    failed = []
    with open_pool(workers) as pool:
        odd = run(pool, raise_odd, range(3))[1]
        assert [attempts for attempts, _ in odd.values()] == [1, 1, 1]
        assert all(why.endswith(f"Odd: {n} and more") for n, (_, why) in odd.items())
        jobs = [Fragile(5), Fragile(6)]
        Jobs(pool, double, print, lambda job, attempts, why: failed.append((job.number, attempts, why))).run(jobs)
        assert run(pool, double, range(3)) == ([0, 2, 4], {}), "and the pool is whole"
    assert [(n, attempts) for n, attempts, _ in sorted(failed)] == [(5, 1), (6, 1)]
    assert all(why.endswith(f"LookupError: no {n} here") for n, _, why in failed)


def test_a_fatal_error_ends_the_run():
    with pytest.raises(ValueError, match="three"), open_pool(1) as pool:
        run(pool, complain, range(6), fatal=(ValueError,))
    with pytest.raises(ValueError, match="three"):
        run(InProcess(), complain, range(6), fatal=(ValueError,))


def test_a_pool_closed_at_once_says_nothing(capfd):
    for _ in range(10):
        with open_pool(2):
            pass
    assert capfd.readouterr().err == ""


def sleep_long(job):
    Path(job[1], f"{os.getpid()}.pid").touch()
    time.sleep(600)


def test_closing_a_pool_leaves_no_process(tmp_path):
    """It is interrupted once both workers are busy, however long they take to start."""

    def interrupt(*_):
        raise KeyboardInterrupt

    def ring():
        while len(list(tmp_path.glob("*.pid"))) < 2:
            time.sleep(0.05)
        os.kill(os.getpid(), signal.SIGALRM)

    before = set(multiprocessing.active_children())
    old = signal.signal(signal.SIGALRM, interrupt)
    try:
        with pytest.raises(KeyboardInterrupt), open_pool(2) as pool:
            threading.Thread(target=ring, daemon=True).start()
            run(pool, sleep_long, range(4), tmp_path)
    finally:
        signal.signal(signal.SIGALRM, old)
    assert set(multiprocessing.active_children()) <= before
    for path in tmp_path.glob("*.pid"):
        with pytest.raises(ProcessLookupError):
            os.kill(int(path.stem), 0)
