"""Do independent jobs on a pool, hand over what comes back, and count how much work is left."""

from __future__ import annotations

import pickle
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Mapping
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, wait
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from experiments.bench.engine import interrupts
from experiments.bench.engine.pool import Pool
from experiments.bench.engine.workers.local import WorkerDied
from experiments.bench.run.errors import TrialError, UsageError
from experiments.bench.run.user_code import of_users, traced

Job = TypeVar("Job")
Done = TypeVar("Done")
ATTEMPTS = 3
QUEUED = 2
"""Jobs handed out for each worker: one under way, one waiting, so that nobody idles and little is lost."""

LOOK_EVERY_S = 2.0
"""Seconds between looks whether the pool is still there while nothing comes back."""

DIED = "its worker process died each time"


@dataclass(frozen=True, slots=True)
class Raised:
    """The traceback of what a job raised, or one line: not every exception survives the way back from a worker."""

    text: str


class Jobs(Generic[Job, Done]):
    """Runs jobs on a pool and hands over what comes back, in order of completion.

    A job whose worker dies is done again later, and counts as failed when that has happened `ATTEMPTS` times. A job
    that raises counts as failed at once, unless what it raises is ``fatal``, which ends the run.
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
        self._waiting: deque[tuple[Job, int]] = deque()
        """Jobs, and how many workers each has lost."""
        self._under_way: dict[Future[Done | Raised], tuple[Job, int]] = {}

    def run(self, jobs: Iterable[Job]) -> None:
        """Run them all. Raises ``OSError`` when the pool is lost for good."""
        self._waiting = deque((job, 0) for job in jobs)
        while self._waiting or self._under_way:
            while self._waiting and len(self._under_way) < QUEUED * self._pool.width:
                self._submit(*self._waiting.popleft())
            with interrupts.window():
                done, _ = wait(self._under_way, timeout=LOOK_EVERY_S, return_when=FIRST_COMPLETED)
            if done:
                self._take_in(done)
            else:
                self._pool.look()

    def _submit(self, job: Job, deaths: int) -> None:
        # Pickled here and unpickled in `_attempt`: a job that cannot be, or whose work cannot be imported, is then
        # that job's failure, not a dead worker.
        parcel = pickle.dumps((self._fatal, self._work, job))
        self._under_way[self._pool.executor.submit(_attempt, parcel)] = (job, deaths)

    def _take_in(self, done: Iterable[Future[Done | Raised]]) -> None:
        for future in done:
            job, deaths = self._under_way.pop(future)
            error = self._error(future)
            if error is None:
                self._settle(job, deaths, future.result())
            elif isinstance(error, WorkerDied):
                self._try_again(job, deaths + 1)
            elif type(error).__name__ == "KilledWorker":  # Dask has tried again by itself
                self._fail(job, getattr(error, "allowed_failures", ATTEMPTS - 1) + 1, DIED)
            else:
                raise error

    def _error(self, future: Future[Done | Raised]) -> BaseException | None:
        try:
            return future.exception()
        except CancelledError:
            self._pool.look()
            return OSError("the pool dropped a trial under way")

    def _settle(self, job: Job, deaths: int, result: Done | Raised) -> None:
        if isinstance(result, Raised):
            self._fail(job, deaths + 1, result.text)
        else:
            self._deliver(result)

    def _try_again(self, job: Job, deaths: int) -> None:
        if deaths < ATTEMPTS:
            self._waiting.append((job, deaths))
        else:
            self._fail(job, deaths, DIED)


def _attempt(parcel: bytes) -> Any:
    """Do the job in the worker, and return what it raises as `Raised`."""
    fatal: tuple[type[Exception], ...] = ()
    try:
        fatal, work, job = pickle.loads(parcel)
        return work(job)
    except fatal:
        raise
    except Exception as error:
        checked = isinstance(error, TrialError | UsageError) and of_users(error) is None
        return Raised(str(error) if checked else traced(error))


class Workload:
    """The work of jobs of several kinds.

    What a job takes may be less than planned: an episode ends at a collision. Jobs of one kind are alike in that, so
    the rest of a kind is its planned size times the share of theirs that its jobs took so far.

    Parameters
    ----------
    sizes
        Index of a job -> its planned size, above 0, in any unit.
    kinds
        Index of a job -> its kind.
    """

    def __init__(self, sizes: Mapping[int, float], kinds: Mapping[int, Hashable]) -> None:
        self._sizes, self._kinds = sizes, kinds
        self._rest: dict[Hashable, float] = dict.fromkeys(kinds.values(), 0.0)
        for index, size in sizes.items():
            self._rest[kinds[index]] += size
        self._planned: dict[Hashable, float] = {}
        self._taken: dict[Hashable, float] = {}

    @property
    def kinds(self) -> int:
        """The number of kinds."""
        return len(self._rest)

    def back(self, index: int, taken: float | None) -> float:
        """Count a job as back.

        Parameters
        ----------
        index
            The job.
        taken
            What it took, in the unit of the sizes; ``None`` where that is not known, as of a job that failed.

        Returns
        -------
        float
            What it took; where that is not known, what a job like it takes.
        """
        kind, size = self._kinds[index], self._sizes[index]
        self._rest[kind] -= size
        if taken is None:
            return size * self._share(kind)
        self._planned[kind] = self._planned.get(kind, 0.0) + size
        self._taken[kind] = self._taken.get(kind, 0.0) + taken
        return taken

    def left(self) -> float:
        """Return what the jobs that are not back will take, by those that are."""
        return sum(rest * self._share(kind) for kind, rest in self._rest.items())

    def _share(self, kind: Hashable) -> float:
        """Return the share of its planned size a job takes: by its own kind, or by all where none of it is back."""
        if kind in self._planned:
            return self._taken[kind] / self._planned[kind]
        planned = sum(self._planned.values())
        return sum(self._taken.values()) / planned if planned else 1.0
