"""Run an experiment's trials on a pool of workers, tables kept up to date."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol, TypeVar

import cv2
from threadpoolctl import threadpool_limits

from colias_sim import GLUnavailable
from experiments.bench import provenance
from experiments.bench.declaration import TrialSpec
from experiments.bench.pool import Jobs, Pool
from experiments.bench.results import Failure, Finished, RunFolder, finished
from experiments.bench.trial import run_trial


@dataclass(frozen=True, slots=True)
class Keep:
    """What is kept of a trial beside its rows."""

    recordings: bool = True
    frames: bool = True


def work(spec: TrialSpec, *, keep: Keep) -> Finished:
    """One trial in a worker, with its recording."""
    cv2.setNumThreads(1)  # more threads cost a second core for a sixth of the time
    with threadpool_limits(1):
        result = run_trial(spec, keep_media=keep.recordings)
        if not keep.recordings:
            return finished(result, None, frames=keep.frames)
        from experiments.bench import log

        return finished(result, log.record(result), frames=keep.frames)


def run_trials(
    specs: Iterable[TrialSpec], folder: RunFolder, pool: Pool, on_trial: Callable[[int], None], keep: Keep
) -> list[Failure]:
    """`run_all` of the robot's trials."""
    return run_all(specs, folder, pool, on_trial, partial(work, keep=keep))


class Spec(Protocol):
    """What is to be done: a trial, or a clip to show."""

    @property
    def index(self) -> int:
        """Its number in the run."""
        ...

    @property
    def seed(self) -> int:
        """Of all its random draws."""
        ...

    @property
    def condition(self) -> Labelled:
        """What it sets."""
        ...


class Labelled(Protocol):
    """Something with a name for people."""

    def label(self) -> str:
        """The name."""
        ...


AnySpec = TypeVar("AnySpec", bound=Spec)


def run_all(
    specs: Iterable[AnySpec],
    folder: RunFolder,
    pool: Pool,
    on_trial: Callable[[int], None],
    work: Callable[[AnySpec], Finished],
) -> list[Failure]:
    """Do those trials that ``folder`` does not hold, telling ``on_trial`` the index of each finished or failed.

    Returns every failure of the run, of whole trials and of single models. What was finished stays readable
    whenever this ends, by an exception or a kill too.
    """

    def deliver(trial: Finished) -> None:
        folder.add(trial)
        on_trial(trial.index)

    def fail(spec: AnySpec, attempts: int, reason: str) -> None:
        folder.fail(Failure(spec.index, "", spec.condition.label(), spec.seed, attempts, reason))
        on_trial(spec.index)

    done = folder.done()
    left = [spec for spec in specs if spec.index not in done]
    try:
        same = partial(_by_same_code, work, folder.provenance)
        Jobs(pool, same, deliver, fail, fatal=(GLUnavailable, provenance.OtherCode)).run(left)
    finally:
        folder.flush()
    return folder.failures()


def _by_same_code(work: Callable[[AnySpec], Finished], made_by: Mapping[str, Any], spec: AnySpec) -> Finished:
    """In a worker: ``work``, if the worker has the code that the rows will be marked with."""
    if made_by:
        provenance.check(made_by)
    return work(spec)
