"""Do independent jobs on whatever keeps to `concurrent.futures`: this process, local processes, a Dask cluster."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from typing import Any, Protocol

from experiments.bench.engine import interrupts
from experiments.bench.engine.workers.cluster import ClusterPool
from experiments.bench.engine.workers.local import LocalPool


class Pool(Protocol):
    """Pool of workers: ``width`` jobs run at a time on ``executor``, whose futures raise `WorkerDied` where that
    happened.
    """

    width: int
    executor: Executor

    def look(self) -> None:
        """Raise ``OSError`` if there is nothing left that could do a job."""
        ...

    def close(self) -> None:
        """Stop every job at once and free the workers."""
        ...


class _Here(Executor):
    """Runs a job in this process, when it is submitted: for debuggers."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        interrupts.check()
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class InProcess:
    """Pool without workers: jobs run one by one in this process."""

    width = 1

    def __init__(self) -> None:
        self.executor: Executor = _Here()

    def look(self) -> None:
        """Do nothing: this process is there."""

    def close(self) -> None:
        """Do nothing: there is nothing to stop."""


@contextlib.contextmanager
def open_pool(workers: int, cluster: str | None = None) -> Iterator[Pool]:
    """Yield a pool of ``workers`` processes (0: none, in this one), or the cluster at an address, closed after."""
    remote = ClusterPool(cluster) if cluster else None
    # A worker half made would complain of its missing parent, so Ctrl-C waits until there is something to close.
    with interrupts.held():
        pool: Pool = remote or (LocalPool(workers) if workers else InProcess())
        try:
            interrupts.check()
            yield pool
        finally:
            pool.close()
