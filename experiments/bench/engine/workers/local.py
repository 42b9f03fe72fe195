"""Worker processes on this machine, of which each does one job at a time."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import queue
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, Executor, Future
from multiprocessing.connection import Connection
from types import ModuleType
from typing import Any


class WorkerDied(BrokenExecutor):
    """The process that was doing a job ended without an answer. No other job is affected."""


_STARTING = threading.RLock()
"""Held while a process starts: two threads at once would lose the main module, and the environment."""


@contextlib.contextmanager
def _without_script() -> Iterator[None]:
    """Let `multiprocessing` find an empty main module: what it tells a process of its script is read from there.

    A worker has no need of the user's script. One without ``if __name__ == "__main__":`` would run once more in every
    worker, and a notebook's cell or standard input cannot be imported at all.
    """
    with _STARTING:
        script = sys.modules.get("__main__")
        sys.modules["__main__"] = ModuleType("__main__")
        try:
            yield
        finally:
            if script is None:
                del sys.modules["__main__"]
            else:
                sys.modules["__main__"] = script


@contextlib.contextmanager
def without_interrupts() -> Iterator[None]:
    """Processes that this thread starts in this block never see Ctrl-C: they inherit that it is blocked.

    A Ctrl-C that arrives meanwhile is taken at the end of the block, or by another thread.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # Makes multiprocessing start its resource tracker, if it has not: it would start it with the first process, and
    # unblock SIGINT in doing so.
    multiprocessing.get_context("spawn").Lock()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Worker:
    """A process that does one job after another, and this end of the pipe to it, which no other process has.

    It is started by spawn, as one forked with an OpenGL context hangs. Raises ``OSError`` where it cannot be.
    """

    def __init__(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._pipe, theirs = context.Pipe()
        with _without_script():
            self._process = context.Process(target=_serve, args=(theirs,))
            self._process.start()
        theirs.close()
        self.ended = False

    def do(self, parcel: bytes) -> bytes:
        """Return the worker's answer to a job. Raises `WorkerDied` where it ends before it has given the whole of
        it.
        """
        try:
            self._pipe.send_bytes(parcel)
            return self._pipe.recv_bytes()
        except (EOFError, OSError):
            self.kill()
            raise WorkerDied("a worker process died") from None

    def kill(self) -> None:
        """End it at once."""
        self.ended = True
        self._process.kill()

    def close(self) -> None:
        """Wait until it has ended, and free the pipe."""
        self._process.join()
        self._pipe.close()


class _Processes(Executor):
    """Worker processes; a thread here hands one job at a time to each, so that a death is that job's alone.

    Why not a library: the test of a worker that is killed while it sends its result
    (``test_a_worker_killed_while_it_sends_its_result_is_noticed``) hangs with `concurrent.futures.ProcessPoolExecutor`
    and with Pebble 5.2's ``ProcessPool``. Their workers share one pipe, whose sending end the parent holds too, so that
    the rest of the answer is waited for without end. With a Pebble pool of one process for each worker, renewed at
    every death, it passes, but ``test_a_job_whose_worker_dies_runs_again_and_the_rest_go_on`` fails one time in three:
    Pebble gives the next job to a new process before the caller can know, and renewing kills that one.
    """

    def __init__(self, count: int) -> None:
        self._tasks: queue.SimpleQueue[tuple[Future[Any], bytes] | None] = queue.SimpleQueue()
        self._workers: dict[int, _Worker] = {}
        self._closed = False
        self._lock = threading.Lock()
        self._threads = [threading.Thread(target=self._keep, args=(place,), daemon=True) for place in range(count)]
        for thread in self._threads:
            thread.start()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self._tasks.put((future, pickle.dumps((fn, args, kwargs))))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Kill the workers, whatever they are doing: nothing of a trial is kept in them."""
        with self._lock:
            self._closed = True
            for worker in self._workers.values():
                worker.kill()
        for _ in self._threads:
            self._tasks.put(None)
        for thread in self._threads:
            thread.join()

    def _keep(self, place: int) -> None:
        """Keep a worker in a thread, and let it do one job after another."""
        with without_interrupts():
            with contextlib.suppress(Exception):  # what keeps it from starting is told to the first job
                self._worker(place)
            while (task := self._tasks.get()) is not None and not self._closed:
                future, parcel = task
                try:
                    returned, value = pickle.loads(self._worker(place).do(parcel))
                except BaseException as error:
                    returned, value = False, error
                if returned:
                    future.set_result(value)
                else:
                    future.set_exception(value)
            if place in self._workers:
                self._workers[place].close()

    def _worker(self, place: int) -> _Worker:
        """Return the living worker in a place: another where the last died."""
        with self._lock:
            if self._closed:
                raise WorkerDied("the pool was closed")
            old = self._workers.get(place)
            if old is not None and not old.ended:
                return old
            if old is not None:
                old.close()
            self._workers[place] = _Worker()
            return self._workers[place]


class LocalPool:
    """Worker processes on this machine."""

    def __init__(self, workers: int) -> None:
        self.width = workers
        self.executor: Executor = _Processes(workers)

    def look(self) -> None:
        """Replace a worker that has died."""

    def close(self) -> None:
        """Kill the workers."""
        self.executor.shutdown()


def _serve(pipe: Connection) -> None:
    """Do jobs in a worker and answer each by whether it returned, and what it returned or raised."""
    _prepare_worker()
    with contextlib.suppress(EOFError, OSError):  # the driver has ended
        while True:
            parcel = pipe.recv_bytes()
            pipe.send_bytes(_answer(parcel))


def _answer(parcel: bytes) -> bytes:
    try:
        fn, args, kwargs = pickle.loads(parcel)
        return pickle.dumps((True, fn(*args, **kwargs)))
    except BaseException as error:
        return pickle.dumps((False, error))


def _prepare_worker() -> None:
    """Leave interrupts to the driver, and do not outlive it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: Any) -> None:
    parent.join()
    os._exit(1)
