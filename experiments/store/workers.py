"""Play trials in this process, in worker processes (loky) or on a Dask cluster, and collect them as they finish."""

from __future__ import annotations

import contextlib
import os
import pickle
import signal
import sys
import sysconfig
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from multiprocessing import resource_tracker
from typing import Any, TypeVar

from experiments.base import interrupts
from experiments.base.console import count
from experiments.base.errors import TrialError, UsageError
from experiments.base.user_code import of_users, traced

Job = TypeVar("Job")
Done = TypeVar("Done")

QUEUED = 2
"""Jobs handed out for each worker: one under way and one waiting, so that no worker idles."""
ANSWER_S, PATIENCE_S = 10.0, 20.0
"""Seconds that a Dask scheduler may take to connect; and between two looks at its workers, while no job finishes."""
SAFE_PATH = "PYTHONSAFEPATH"
"""The variable without which an interpreter looks for every module in the current folder first."""
DIED = "its worker process died, and died again when the trial was repeated alone"


class Workers:
    """Executor of a run's jobs, that is renewed when one of its processes dies.

    Parameters
    ----------
    number
        Number of worker processes; otherwise one for each core. 0 runs each job in this process, for debuggers.
    cluster
        Address of a Dask scheduler, used instead.
    quiet
        Whether runs print neither plans nor progress.

    Attributes
    ----------
    width
        Number of jobs that run at a time.

    Raises
    ------
    UsageError
        The number is not 0 up to the number of this machine's cores.
    """

    def __init__(self, number: int | None = None, cluster: str | None = None, *, quiet: bool = False) -> None:
        self._count, self._address, self.quiet = worker_count(number), cluster, quiet
        self._client: Any = None
        self.width = max(self._count, 1)

    def where(self) -> str:
        """Return what jobs run on: ``on 2 workers``."""
        return f"on {self._address or count(self.width, 'worker')}"

    @contextlib.contextmanager
    def running(self, *, rendering: bool = True) -> Iterator[Workers]:
        """Start the processes, or connect to the cluster, and let them go at the end of the block.

        Raises `GLUnavailable` where ``rendering`` is asked of this machine and it has no OpenGL, and ``OSError`` where
        no Dask scheduler with workers answers.
        """
        if rendering and self._address is None:
            from colias_sim.reference import reference_hash

            reference_hash()  # no trial is begun where nothing can be drawn
        with interrupts.once():
            if self._address is not None:
                self._client = _client(self._address)
                self.width = sum(self._client.nthreads().values())
            self.renew()
            try:
                yield self
            finally:
                self.close()

    def renew(self) -> None:
        """Start new processes in place of a pool that broke."""
        if self._client is not None:
            self._executor: Executor = self._client.get_executor(pure=False, retries=0)
        elif self._count:
            import loky  # type: ignore[import-untyped]  # not before: commands that run nothing do without it

            # It renews a worker that has grown by 300 MB, as those of long runs do, and suspects a leak.
            warnings.filterwarnings("ignore", "A worker was restarted")
            with starting():
                self._executor = loky.ProcessPoolExecutor(
                    self._count, timeout=None, initializer=_begin_worker, initargs=(os.getpid(),), env={SAFE_PATH: "1"}
                )
        else:
            self._executor = _InProcess()

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Hand out a job; its future raises ``BrokenExecutor`` if a worker process dies meanwhile."""
        with starting():
            return self._executor.submit(function, *arguments)

    def look(self) -> None:
        """Raise ``OSError`` if the cluster has no workers left."""
        if self._client is not None and not self._client.nthreads():
            raise OSError(f"--cluster {self._address}: the scheduler has lost all its workers")

    def close(self) -> None:
        """Stop every job at once and free the workers."""
        if self._client is not None:
            with contextlib.suppress(Exception):
                self._executor.shutdown(wait=False)
            with contextlib.suppress(Exception):
                self._client.close(timeout=2)
        elif self._count:
            self._executor.shutdown(kill_workers=True)  # type: ignore[call-arg]


class _InProcess(Executor):
    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except (Exception, SystemExit) as error:
            future.set_exception(error)
        return future


def worker_count(given: int | None) -> int:
    """Return the number of worker processes asked for, or one for each core that this process may use."""
    if given is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if isinstance(given, bool) or not isinstance(given, int) or not 0 <= given <= 256:
        raise UsageError(f"--workers must be between 0 and 256, got {given}")
    return given


def finished(
    jobs: Iterable[Job], work: Callable[[Job], Done], workers: Workers, fatal: tuple[type[Exception], ...] = ()
) -> Iterator[tuple[Job, Done | None, str]]:
    """Do independent jobs and yield each when it is finished, in order of completion.

    When a worker process dies, the jobs under way are repeated one at a time; one that dies again has failed.

    Parameters
    ----------
    jobs
        What to do. They are pickled.
    work
        A job's function, of a module or a `functools.partial` of one.
    workers
        Where they are done.
    fatal
        What ends the whole run when a job raises it. Anything else that a job raises is that job's failure.

    Yields
    ------
    tuple of Job, Done or None, str
        The job, its result, and an empty text; of a failed job no result, and the traceback or the reason.

    Raises
    ------
    OSError
        The cluster is lost.
    """
    waiting, alone, lost = deque(jobs), deque[Job](), list[Job]()
    under_way: dict[Future[tuple[Done | None, str]], Job] = {}
    repeating = False
    while waiting or alone or under_way or lost:
        if lost and not under_way:
            workers.renew()
            if repeating:
                yield lost[0], None, DIED
            else:
                alone.extend(lost)
            lost = []
        if not under_way:
            repeating = bool(alone)
        queue = alone if repeating else waiting
        while queue and not lost and len(under_way) < (1 if repeating else QUEUED * workers.width):
            job = queue.popleft()
            # Pickled here and unpickled in `_attempt`: a job that cannot be is its own failure, not a dead worker.
            try:
                under_way[workers.submit(_attempt, pickle.dumps((fatal, work, job)))] = job
            except BrokenExecutor:  # a process died just now: what it was at comes back below
                queue.appendleft(job)
                if under_way:
                    break
                workers.renew()
        done, _ = wait(under_way, timeout=PATIENCE_S, return_when=FIRST_COMPLETED)
        if not done:
            workers.look()
        for future in done:
            job = under_way.pop(future)
            try:
                result, trouble = future.result()
            except BrokenExecutor:
                lost.append(job)
            except CancelledError:
                raise OSError("--cluster: lost the scheduler") from None
            except Exception as error:
                if type(error).__name__ != "KilledWorker":  # Dask has repeated it by itself
                    raise
                yield job, None, DIED
            else:
                yield job, result, trouble


def _attempt(parcel: bytes) -> tuple[Any, str]:
    """Do a job in the worker; not every exception survives the way back, so that its text is returned."""
    fatal: tuple[type[Exception], ...] = ()
    try:
        fatal, work, job = pickle.loads(parcel)
        return work(job), ""
    except fatal:
        raise
    except (Exception, SystemExit) as error:
        checked = isinstance(error, TrialError | UsageError) and not of_users(error)
        return None, str(error) if checked else traced(error)


@contextlib.contextmanager
def starting() -> Iterator[None]:
    """Start processes that never see Ctrl-C, and in which no file of a user's hides a module of Python's.

    They inherit that it is blocked in this thread, and ``sys.path``: a notebook has the current folder first there.
    """
    interrupts.open_streams()
    path, safe, python = [*sys.path], os.environ.get(SAFE_PATH), sysconfig.get_path("stdlib")
    sys.path.sort(key=lambda entry: not entry.startswith(python) or "-packages" in entry)
    os.environ[SAFE_PATH] = "1"
    resource_tracker.ensure_running()  # it would be started with the first process, and unblock SIGINT in doing so
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        sys.path[:] = path
        os.environ.pop(SAFE_PATH)
        os.environ.update({SAFE_PATH: safe} if safe is not None else {})


def _begin_worker(parent: int) -> None:
    """Leave Ctrl-C to the parent process, and end with it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(1.0)
    os._exit(1)


def _client(address: str) -> Any:
    """Connect to a Dask scheduler that has workers."""
    from distributed import Client  # the extra [cluster]

    try:
        client: Any = Client(address, timeout=ANSWER_S, set_as_default=False)  # type: ignore[no-untyped-call]
    except Exception as error:  # of many kinds: unknown host, refused, another protocol, another version
        raise OSError(f"--cluster {address}: no Dask scheduler answers there ({error})") from None
    if not client.nthreads():
        client.close()
        raise OSError(f"--cluster {address}: that scheduler has no workers")
    return client
