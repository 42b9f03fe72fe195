"""Do independent jobs on whatever keeps to `concurrent.futures`: this process, local processes, a Dask cluster."""

from __future__ import annotations

import contextlib
import logging
import multiprocessing
import os
import pickle
import re
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from dataclasses import dataclass
from multiprocessing import resource_tracker
from multiprocessing.context import SpawnContext, SpawnProcess
from typing import Any, Generic, Protocol, TypeVar

from experiments.bench import interrupts
from experiments.bench.files import message, printable

Job = TypeVar("Job")
Done = TypeVar("Done")

ATTEMPTS = 3
QUEUED = 2
"""Jobs handed out for each worker: one under way, one waiting, so that nobody idles and little is lost."""

LOOK_EVERY_S = 2.0
"""How often to see whether the pool is still there while nothing comes back."""

LONGEST_REASON = 20_000
"""Characters of the reason of a job's failure, which may name many models."""

DIED = "its worker process died each time"


@dataclass(frozen=True, slots=True)
class Raised:
    """What a job raised, in words: not every exception survives the way back from a worker."""

    kind: str
    text: str

    def __str__(self) -> str:
        return f"{self.kind}: {self.text}" if self.kind else self.text


class Pool(Protocol):
    """Where jobs run: ``width`` at a time on ``executor``, which `renew` replaces after it broke."""

    width: int
    executor: Executor

    def renew(self) -> None:
        """Replace an executor that lost a worker."""
        ...

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
    """No workers: jobs run one by one in this process."""

    width = 1

    def __init__(self) -> None:
        self.executor: Executor = _Here()

    def renew(self) -> None:
        """Nothing to replace."""

    def look(self) -> None:
        """This process is there."""

    def close(self) -> None:
        """Nothing to stop."""


class _Worker(SpawnProcess):
    """A worker process, deaf to Ctrl-C from its first moment: it inherits what is blocked."""

    def start(self) -> None:
        """Start it."""
        if not hasattr(signal, "pthread_sigmask"):
            return super().start()
        resource_tracker.ensure_running()  # which would begin with the first process, and in beginning unblocks SIGINT
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class _Context(SpawnContext):
    """Starts processes by spawn, as one forked with an OpenGL context hangs; ``started`` are those it has made."""

    def __init__(self) -> None:
        super().__init__()
        self.started: list[_Worker] = []

    def Process(self, *args: Any, **options: Any) -> _Worker:  # type: ignore[override]
        """A process to start."""
        worker = _Worker(*args, **options)
        self.started.append(worker)
        return worker


class LocalPool:
    """Worker processes on this machine, each with whatever processes its jobs start: they end with it."""

    def __init__(self, workers: int) -> None:
        self.width = workers
        self._open()

    def _open(self) -> None:
        self._context = _Context()
        executor = ProcessPoolExecutor(self.width, mp_context=self._context, initializer=_prepare_worker)
        self.executor: Executor = executor
        for _ in range(self.width):
            executor.submit(os.getpid)  # a worker starts for each job that finds none idle: start them all
        # Of a worker killed while it sends its result the executor waits for the rest until the pipe ends, which is
        # when nobody holds its sending end: not this process, which has no use for it, and no worker: see `look`.
        if len(self._context.started) == self.width:
            queue: Any = executor._result_queue
            queue._writer.close()

    def renew(self) -> None:
        """Start anew after a worker died, which ends them all."""
        self.close()
        self._open()

    def look(self) -> None:
        """Where a worker is dead and the executor has not noticed, kill the others: then it does."""
        if not all(worker.is_alive() for worker in self._context.started):
            self._kill()

    def close(self) -> None:
        """Kill the workers, whatever they are doing: nothing of a trial is kept in them."""
        self._kill()
        self.executor.shutdown(wait=True, cancel_futures=True)

    def _kill(self) -> None:
        for worker in self._context.started:
            _kill_group(worker.pid)
            worker.kill()


class ClusterPool:
    """The workers of a Dask scheduler. Raises ``OSError`` if none answers at ``address``, or none is left."""

    PATIENCE_S = 20.0
    """How long a cluster may be without workers, which it may be replacing, before a run gives up."""

    def __init__(self, address: str) -> None:
        if not re.fullmatch(r"(tcp|tls|ws|wss|ucx)://\S+:\d+", address):
            raise OSError(
                f"--cluster {address}: expected the address of a Dask scheduler, such as tcp://127.0.0.1:8786"
            )
        try:
            from distributed import Client
        except ImportError:
            raise OSError("--cluster needs Dask: install colias-sim[cluster]") from None
        for name in list(logging.root.manager.loggerDict):
            if name.startswith(("distributed", "tornado", "asyncio")):  # a lost connection is pages of traceback there
                logging.getLogger(name).setLevel(logging.CRITICAL + 1)
        self._address = address
        client: Any = Client  # untyped
        try:
            self._client = client(address, timeout="10s", set_as_default=False)
        except Exception as error:  # of many kinds: unknown host, refused, another protocol, another version
            said = " ".join(str(error).split())
            raise OSError(f"--cluster {address}: no Dask scheduler answers there ({said})") from None
        threads = self._client.nthreads()
        if not threads:
            self._client.close()
            raise OSError(f"--cluster {address}: that scheduler has no workers")
        self.width = sum(threads.values())
        self._seen = time.monotonic()
        self.executor: Executor = self._client.get_executor(pure=False, retries=0)

    def renew(self) -> None:
        """Dask replaces its own workers."""

    def look(self) -> None:
        """Raise ``OSError`` if the scheduler is gone, or has had no worker for `PATIENCE_S`."""
        now = time.monotonic()
        try:
            threads = self._client.nthreads() if self._client.status == "running" else None
        except Exception:  # the connection broke in mid-question, in one of many ways
            threads = None
        if threads is None:
            raise OSError(f"--cluster {self._address}: lost the scheduler")
        if threads:
            self._seen = now
        elif now - self._seen > self.PATIENCE_S:
            raise OSError(f"--cluster {self._address}: the scheduler has lost all its workers")

    def close(self) -> None:
        """Cancel what is under way and leave the cluster."""
        with contextlib.suppress(Exception):
            self.executor.shutdown(wait=False)
        with contextlib.suppress(Exception):
            self._client.close(timeout=2)


@contextlib.contextmanager
def open_pool(workers: int, cluster: str | None = None) -> Iterator[Pool]:
    """A pool of ``workers`` processes (0: none, in this one), or of the cluster at an address; closed at the end."""
    remote = ClusterPool(cluster) if cluster else None
    # A worker half made would complain of its missing parent, so Ctrl-C waits until there is something to close.
    with interrupts.held():
        pool: Pool = remote or (LocalPool(workers) if workers else InProcess())
        try:
            interrupts.check()
            yield pool
        finally:
            pool.close()


class Jobs(Generic[Job, Done]):
    """Runs jobs on a pool and hands over what comes back, in order of completion.

    When a worker dies, every job under way is suspect. Each suspect then runs alone, so that its deaths are its
    own: after `ATTEMPTS` it counts as failed. A job that raises counts as failed at once, unless what it raises
    is ``fatal``, which ends the run.
    """

    def __init__(
        self,
        pool: Pool,
        work: Callable[[Job], Done],
        deliver: Callable[[Done], None],
        fail: Callable[[Job, int, str], None],
        fatal: tuple[type[Exception], ...] = (),
    ) -> None:
        self._pool, self._work, self._deliver, self._fail, self._fatal = pool, work, deliver, fail, fatal
        self._suspects: deque[tuple[Job, int]] = deque()
        self._under_way: dict[Future[Done | Raised], tuple[Job, int]] = {}

    def run(self, jobs: Iterable[Job]) -> None:
        """Run them all. Raises ``OSError`` when the pool is lost for good."""
        waiting = deque((job, 0) for job in jobs)
        while waiting or self._suspects or self._under_way:
            self._hand_out(waiting)
            with interrupts.window():
                done, _ = wait(self._under_way, timeout=LOOK_EVERY_S, return_when=FIRST_COMPLETED)
            if done:
                self._take_in(done)
            else:
                self._pool.look()

    def _hand_out(self, waiting: deque[tuple[Job, int]]) -> None:
        if self._suspects:
            if not self._under_way:
                self._submit(*self._suspects.popleft())
            return
        while waiting and len(self._under_way) < QUEUED * self._pool.width:
            self._submit(*waiting.popleft())

    def _submit(self, job: Job, deaths: int) -> None:
        # Pickled here and unpickled in `_attempt`: a job that cannot be, or whose work cannot be imported, is then
        # that job's failure, not a dead worker.
        parcel = pickle.dumps((self._fatal, self._work, job))
        try:
            future: Future[Done | Raised] = self._pool.executor.submit(_attempt, parcel)
        except BrokenExecutor:  # it broke between two jobs
            self._pool.renew()
            future = self._pool.executor.submit(_attempt, parcel)
        self._under_way[future] = (job, deaths)

    def _take_in(self, done: Iterable[Future[Done | Raised]]) -> None:
        broken: list[tuple[Job, int]] = []
        alone = len(self._under_way) == 1
        for future in done:
            job, deaths = self._under_way.pop(future)
            error = self._error(future)
            if error is None:
                self._settle(job, deaths, future.result())
            elif isinstance(error, BrokenExecutor):
                broken.append((job, deaths))
            elif type(error).__name__ == "KilledWorker":  # Dask has tried again by itself
                self._fail(job, getattr(error, "allowed_failures", ATTEMPTS - 1) + 1, DIED)
            else:
                raise error
        if broken:
            self._recover(broken, alone)

    def _error(self, future: Future[Done | Raised]) -> BaseException | None:
        try:
            return future.exception()
        except CancelledError:
            self._pool.look()
            return OSError("the pool dropped a trial under way")

    def _settle(self, job: Job, deaths: int, result: Done | Raised) -> None:
        if isinstance(result, Raised):
            self._fail(job, deaths + 1, str(result))
        else:
            self._deliver(result)

    def _recover(self, broken: list[tuple[Job, int]], alone: bool) -> None:
        """A worker died: whatever was handed out is suspect; a job that was alone is the culprit."""
        for future, (job, deaths) in self._under_way.items():
            if future.done() and future.exception() is None:
                self._settle(job, deaths, future.result())
            else:
                broken.append((job, deaths))
        self._under_way.clear()
        self._pool.renew()
        for job, deaths in broken:
            deaths += alone
            if deaths >= ATTEMPTS:
                self._fail(job, deaths, DIED)
            else:
                self._suspects.append((job, deaths))


def _attempt(parcel: bytes) -> Any:
    """In the worker: do the job, and put what it raises into words."""
    own = os.getpid()
    fatal: tuple[type[Exception], ...] = ()
    try:
        fatal, work, job = pickle.loads(parcel)
        return work(job)
    except fatal:
        raise
    except (Exception, SystemExit) as error:
        kind = "" if isinstance(error, RuntimeError) else type(error).__name__
        return Raised(kind, printable(message(error), LONGEST_REASON) or type(error).__name__)
    finally:
        if os.getpid() != own:  # a copy of the worker, which a job made by fork: the answer is the worker's own to give
            os._exit(0)


def _prepare_worker() -> None:
    """Leave interrupts to the driver, and do not outlive it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setpgid"):
        os.setpgid(0, 0)  # what jobs start belongs to this worker's group, and is killed with it
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: Any) -> None:
    parent.join()
    _kill_group(os.getpid())
    os._exit(1)


def _kill_group(leader: int | None) -> None:
    """Kill a worker and all it started; nothing happens before it has made itself the leader of a group."""
    if leader is not None and hasattr(os, "killpg"):
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(leader, signal.SIGKILL)
