"""Do independent jobs on whatever keeps to `concurrent.futures`: this process, local processes, a Dask cluster."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, ProcessPoolExecutor, wait
from typing import Any, Generic, Protocol, TypeVar

Job = TypeVar("Job")
Done = TypeVar("Done")

ATTEMPTS = 3
QUEUED = 2
"""Jobs handed out for each worker: one under way, one waiting, so that nobody idles and little is lost."""


class Pool(Protocol):
    """Where jobs run: ``width`` at a time on ``executor``, which `renew` replaces after it broke."""

    width: int
    executor: Executor

    def renew(self) -> None:
        """Replace an executor that lost a worker."""
        ...

    def close(self) -> None:
        """Stop every job at once and free the workers."""
        ...


class _Here(Executor):
    """Runs a job in this process, when it is submitted: for debuggers."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class InProcess:
    """No workers: jobs run one by one in this process."""

    width = 1

    def __init__(self) -> None:
        self.executor: Executor = _Here()

    def renew(self) -> None:
        """Nothing to replace."""

    def close(self) -> None:
        """Nothing to stop."""


class LocalPool:
    """Worker processes on this machine, started by spawn: a process forked with an OpenGL context hangs."""

    def __init__(self, workers: int) -> None:
        self.width = workers
        self._before = set(multiprocessing.active_children())
        self._open()

    def _open(self) -> None:
        self.executor: Executor = ProcessPoolExecutor(
            self.width, mp_context=multiprocessing.get_context("spawn"), initializer=_prepare_worker
        )

    def renew(self) -> None:
        """Start anew after a worker died, which ends them all."""
        self.close()
        self._open()

    def close(self) -> None:
        """Kill the workers, whatever they are doing: nothing of a trial is kept in them."""
        for child in set(multiprocessing.active_children()) - self._before:
            child.kill()
        self.executor.shutdown(wait=True, cancel_futures=True)


class ClusterPool:
    """The workers of a Dask scheduler. Raises ``OSError`` if none answers at ``address``."""

    def __init__(self, address: str) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise OSError("--cluster needs Dask: install colias-sim[cluster]") from None
        try:
            client: Any = Client  # untyped
            self._client = client(address, timeout="10s", set_as_default=False)
        except (OSError, ValueError) as error:
            raise OSError(f"--cluster {address}: no Dask scheduler answers there ({error})") from None
        threads = self._client.nthreads()
        if not threads:
            self._client.close()
            raise OSError(f"--cluster {address}: that scheduler has no workers")
        self.width = sum(threads.values())
        self.executor: Executor = self._client.get_executor(pure=False, retries=0)

    def renew(self) -> None:
        """Dask replaces its own workers."""

    def close(self) -> None:
        """Cancel what is under way and leave the cluster."""
        with contextlib.suppress(Exception):
            self.executor.shutdown(wait=False)
        self._client.close()


@contextlib.contextmanager
def open_pool(workers: int, cluster: str | None = None) -> Iterator[Pool]:
    """A pool of ``workers`` processes (0: none, in this one), or of the cluster at an address; closed at the end."""
    pool: Pool = ClusterPool(cluster) if cluster else LocalPool(workers) if workers else InProcess()
    try:
        yield pool
    finally:
        pool.close()


class Jobs(Generic[Job, Done]):
    """Runs jobs on a pool and hands over what comes back, in order of completion.

    When a worker dies, every job under way is suspect. Each suspect then runs alone, so that its deaths are its
    own: after `ATTEMPTS` it counts as failed. A job that raises counts as failed at once, unless it is ``fatal``.
    """

    def __init__(
        self,
        pool: Pool,
        work: Callable[[Job], Done],
        deliver: Callable[[Done], None],
        fail: Callable[[Job, int, BaseException], None],
        fatal: tuple[type[BaseException], ...] = (),
    ) -> None:
        self._pool, self._work, self._deliver, self._fail, self._fatal = pool, work, deliver, fail, fatal
        self._suspects: deque[tuple[Job, int]] = deque()
        self._under_way: dict[Future[Done], tuple[Job, int]] = {}

    def run(self, jobs: Iterable[Job]) -> None:
        """Run them all."""
        waiting = deque((job, 0) for job in jobs)
        while waiting or self._suspects or self._under_way:
            self._hand_out(waiting)
            done, _ = wait(self._under_way, return_when=FIRST_COMPLETED)
            self._take_in(done)

    def _hand_out(self, waiting: deque[tuple[Job, int]]) -> None:
        if self._suspects:
            if not self._under_way:
                self._submit(*self._suspects.popleft())
            return
        while waiting and len(self._under_way) < QUEUED * self._pool.width:
            self._submit(*waiting.popleft())

    def _submit(self, job: Job, deaths: int) -> None:
        try:
            future = self._pool.executor.submit(self._work, job)
        except BrokenExecutor:  # it broke between two jobs
            self._pool.renew()
            future = self._pool.executor.submit(self._work, job)
        self._under_way[future] = (job, deaths)

    def _take_in(self, done: Iterable[Future[Done]]) -> None:
        broken: list[tuple[Job, int, BaseException]] = []
        alone = len(self._under_way) == 1
        for future in done:
            job, deaths = self._under_way.pop(future)
            error = future.exception()
            if error is None:
                self._deliver(future.result())
            elif isinstance(error, self._fatal):
                raise error
            elif isinstance(error, BrokenExecutor):
                broken.append((job, deaths, error))
            else:
                self._fail(job, deaths + 1, error)
        if broken:
            self._recover(broken, alone)

    def _recover(self, broken: list[tuple[Job, int, BaseException]], alone: bool) -> None:
        """A worker died: whatever was handed out is suspect; a job that was alone is the culprit."""
        for future, (job, deaths) in self._under_way.items():
            if future.done() and future.exception() is None:
                self._deliver(future.result())
            else:
                broken.append((job, deaths, BrokenExecutor()))
        self._under_way.clear()
        self._pool.renew()
        for job, deaths, _ in broken:
            deaths += alone
            if deaths >= ATTEMPTS:
                self._fail(job, deaths, RuntimeError("its worker process died each time"))
            else:
                self._suspects.append((job, deaths))


def _prepare_worker() -> None:
    """Leave interrupts to the driver, and do not outlive it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: Any) -> None:
    parent.join()
    os._exit(1)
