"""The runner under fire: workers killed, jobs that fail, a driver killed, a full disk."""

import contextlib
import multiprocessing
import os
import signal
import struct
import sys
import threading
import time
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from experiments.bench.engine.jobs import ATTEMPTS, Jobs
from experiments.bench.engine.pool import InProcess, open_pool


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


def blocked(_):
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, ())


@contextlib.contextmanager
def dask():
    from distributed import LocalCluster

    with (
        LocalCluster(
            n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0", protocol="tcp://"
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


def test_a_fatal_error_ends_the_run():
    with pytest.raises(ValueError, match="three"), open_pool(1) as pool:
        run(pool, complain, range(6), fatal=(ValueError,))
    with pytest.raises(ValueError, match="three"):
        run(InProcess(), complain, range(6), fatal=(ValueError,))


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
