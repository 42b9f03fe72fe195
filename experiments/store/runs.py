"""The engine of every kind of run: jobs on a pool of workers, their rows into one folder, with progress.

A job that the folder has already is not done again.

Trials with the robot, clips, tuning curves, episodes, the leaderboard, sweeps and the studies of a reproduction
are all a `Batch`. Footage is not: it is a stream without a plan.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

import polars as pl

from colias_sim import GLUnavailable
from dsnn import forms
from experiments.base.console import error_console, progress
from experiments.settings.models import ConfiguredModel, rate_notes
from experiments.settings.parameters import Parameters
from experiments.store import provenance
from experiments.store.folder import RunFolder
from experiments.store.tables import TrialRecord, in_words
from experiments.store.workers import Workers, finished

SHOWN_FAILURES = 10
"""Failures that are named on the terminal; failures.json has all."""


class Job(Protocol):
    """A trial, a clip, an episode: wholly determined, so that doing it is a pure function of it."""

    @property
    def index(self) -> int:
        """Its number in the run."""

    @property
    def seed(self) -> int:
        """Seed of every random draw."""

    @property
    def fps(self) -> float:
        """Rate of the frames that its models are shown, 1/s."""

    @property
    def models(self) -> Sequence[ConfiguredModel]:
        """The models that it is shown to."""

    def label(self) -> str:
        """Return its name in messages."""


AnyTrial = TypeVar("AnyTrial", bound=Job)


@dataclass(frozen=True, slots=True)
class Batch(Generic[AnyTrial]):
    """Jobs whose rows go into one folder.

    Parameters
    ----------
    name
        What the run is called on the terminal.
    specs
        The jobs. Equal specs give equal rows, in any process.
    work
        A job's pure function. It is pickled, so it is a function of a module or a `functools.partial` of one.
    description
        The contents of ``run.json``: every parameter, the seed, and the code (`provenance.of`).
    schemas
        Columns of ``trials.parquet`` and ``frames.parquet``; ``parameters`` are further columns.
    parameters
        The parameters that have columns, by key and model.
    things
        What a job is called in the plural.
    """

    name: str
    specs: Sequence[AnyTrial]
    work: Callable[[AnyTrial], TrialRecord]
    description: Mapping[str, Any]
    schemas: tuple[pl.Schema, pl.Schema]
    parameters: Parameters = field(default_factory=dict)
    things: str = "trials"

    @contextmanager
    def run(self, out: Path, pool: Workers) -> Iterator[RunFolder]:
        """Do the jobs that a folder lacks, with progress, and close it at the end of the block.

        Yields
        ------
        RunFolder
            The folder, filled. Its ``failures()`` are those of whole jobs, and of single models in the others.

        Raises
        ------
        UsageError
            The folder holds another run.
        """
        with closing(RunFolder(out, *self.schemas, self.parameters)) as folder:
            folder.enter(self.description, [spec.index for spec in self.specs])
            done = folder.done()
            left = [spec for spec in self.specs if spec.index not in done]
            if not pool.quiet:
                known = f"{len(done)} of them done already"
                how = f"{pool.where()}{f'; {known}' if done else ''}" if left else f"complete: all {known}"
                place = f"{'into' if left else 'in'} {out}"
                error_console.print(f"{self.name}: {len(self.specs)} {self.things}, {how}, {place}")
                if note := forms.note():
                    error_console.print(f"note: {note}")
            rates = ((model, rate) for spec in self.specs for rate in [spec.fps] for model in spec.models)
            for note in rate_notes(rates):  # quiet or not
                error_console.print(f"note: {note}")
            with progress(self.name, len(left), pool.quiet, self.things) as advance:
                try:
                    self._play(left, folder, pool, advance)
                except BaseException:
                    have = f"{len(folder.done())} of {len(self.specs)} {self.things}"
                    error_console.print(f"stopped after {have}; they are in {out}")
                    raise
            if left:
                folder.end()
            print_notes(folder)
            yield folder

    def _play(self, left: Sequence[AnyTrial], folder: RunFolder, pool: Workers, advance: Callable[[], None]) -> None:
        """Do the jobs. Those that are finished stay readable whenever this ends, by an exception or a kill too."""
        work = partial(_by_same_code, self.work, provenance.digest())
        try:
            for spec, done, trouble in finished(left, work, pool, fatal=(GLUnavailable, provenance.OtherCode)):
                if done is None:
                    folder.fail(spec.index, spec.label(), spec.seed, trouble)
                else:
                    folder.add(done, spec.label(), spec.seed)
                advance()
        finally:
            folder.flush()


def _by_same_code(work: Callable[[AnyTrial], TrialRecord], digest: str, spec: AnyTrial) -> TrialRecord:
    """Do a job in a worker that has the same code, which one of a cluster may not have."""
    if digest != provenance.digest():
        raise provenance.OtherCode("a worker has other code of colias-sim than this process: install one everywhere")
    return work(spec)


def print_notes(folder: RunFolder) -> None:
    """Print the notes about a run's tables, and the first failures."""
    for note in folder.notes():
        error_console.print(f"note: {note}")
    failures = in_words(folder.failures())
    for text in failures[:SHOWN_FAILURES]:
        error_console.print(text)
    if len(failures) > SHOWN_FAILURES:
        error_console.print(f"... {len(failures) - SHOWN_FAILURES} more: see failures.json")
