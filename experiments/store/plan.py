"""The plan of a run, and the engine of every kind: trials on a pool of workers, their rows into one folder.

A trial that the folder has already is not done again.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

import polars as pl

from colias_sim import GLUnavailable
from dsnn import forms
from experiments.base.console import error_console, progress
from experiments.settings.models import ConfiguredModel, rate_notes
from experiments.settings.parameters import Parameters
from experiments.store import provenance
from experiments.store.asked import ASKED, Asked
from experiments.store.folder import KIND, RunFolder
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


@dataclass(frozen=True)
class Plan(Generic[AnyTrial]):
    """What is planned from what was asked: the trials, what they are about, and what does them. It is never stored.

    Parameters
    ----------
    asked
        What was asked for.
    name
        What the run is called on the terminal.
    trials
        The trials. Equal ones give equal rows, in any process. Footage has one, a stream without an end.
    work
        A trial's pure function. It is pickled, so it is a function of a module or a `functools.partial` of one. A run
        of runs has none.
    resolved
        What ``run.json`` has beside what was asked: every parameter, the seed, and the code (`provenance.of`). Figures
        and tables read it there; a run that resumes must have an equal one.
    schemas
        Columns of ``trials.parquet`` and ``frames.parquet``; ``parameters`` are further columns.
    declared
        What the trials are of: an experiment, a source, a grid.
    models
        The models that are shown.
    parameters
        The parameters that have columns, by key and model.
    things
        What a trial is called in the plural.
    parts
        Folder -> the plan of a run there, of a run of runs.
    random
        Whether anything differs between repeats: otherwise one says all.
    live
        What only this process has, such as a viewer.
    notes
        What to know before it begins, in a line each.
    """

    asked: Asked
    name: str
    trials: Sequence[AnyTrial] = ()
    work: Callable[[AnyTrial], TrialRecord] | None = None
    resolved: Mapping[str, Any] = field(default_factory=dict)
    schemas: tuple[pl.Schema, pl.Schema] = (pl.Schema(), pl.Schema())
    declared: Any = None
    models: tuple[ConfiguredModel, ...] = ()
    parameters: Parameters = field(default_factory=dict)
    things: str = "trials"
    parts: Mapping[str, Plan[Any]] = field(default_factory=dict)
    random: bool = True
    live: Any = None
    notes: Sequence[str] = ()

    @property
    def thresholds(self) -> dict[str, float | None]:
        """The spiking threshold of each model's counted channel, by label."""
        return {model.label: model.threshold for model in self.models}

    def document(self) -> dict[str, Any]:
        """Return the contents of ``run.json``: what was asked, and what it was resolved to."""
        return {KIND: self.asked.kind, **self.resolved, ASKED: self.asked.stored()}


SAMPLED = 4
"""Trials by which a run's time and size are told."""


def forecast(plan: Plan[AnyTrial], width: int) -> dict[str, float]:
    """Tell what a run comes to, by playing a few of its trials here. Nothing is written.

    Each is played twice, as the first time compiles its scene.

    Parameters
    ----------
    plan
        The run, which has trials of its own.
    width
        Number of trials that are done at a time.

    Returns
    -------
    dict of str to float
        ``conditions``, ``trials``, ``minutes``, and ``MB``, which tables hardly exceed.
    """
    assert plan.work is not None, "a run of runs has no trials of its own"
    number, seconds, size = len(plan.trials), 0.0, 0
    places = sorted({(2 * place + 1) * number // (2 * SAMPLED) for place in range(SAMPLED)})
    for trial in (plan.trials[place] for place in places):
        plan.work(trial)
        began_s = time.perf_counter()
        done = plan.work(trial)
        seconds += time.perf_counter() - began_s
        rows = pl.DataFrame(done.rows, infer_schema_length=None)
        size += int(rows.estimated_size() + done.frames.estimated_size()) + len(done.recording or "")
    share = number / len(places)
    return {
        "conditions": len({trial.label() for trial in plan.trials}), "trials": number,
        "minutes": share * seconds / max(width, 1) / 60.0, "MB": share * size / 1e6,
    }  # fmt: skip


@contextmanager
def filled(plan: Plan[AnyTrial], out: Path, pool: Workers) -> Iterator[RunFolder]:
    """Do the trials that a folder lacks, with progress, and close it at the end of the block.

    Parameters
    ----------
    plan
        The run.
    out
        Its folder: a new one, or one that holds a part of this run.
    pool
        Where the trials are done.

    Yields
    ------
    RunFolder
        The folder, filled. Its ``failures()`` are those of whole trials, and of single models in the others.

    Raises
    ------
    UsageError
        The folder holds another run.
    """
    with closing(RunFolder(out, *plan.schemas, plan.parameters)) as folder:
        folder.enter(plan.document(), [trial.index for trial in plan.trials])
        done = folder.done()
        left = [trial for trial in plan.trials if trial.index not in done]
        if not pool.quiet:
            _announce(plan, out, pool, len(left), len(done))
        rates = ((model, rate) for trial in plan.trials for rate in [trial.fps] for model in trial.models)
        for note in rate_notes(rates):  # quiet or not
            error_console.print(f"note: {note}")
        with progress(plan.name, len(left), pool.quiet, plan.things) as advance:
            try:
                _do(plan, left, folder, pool, advance)
            except BaseException:
                have = f"{len(folder.done())} of {len(plan.trials)} {plan.things}"
                error_console.print(f"stopped after {have}; they are in {out}")
                raise
        if left:
            folder.end()
        print_notes(folder)
        yield folder


def _announce(plan: Plan[Any], out: Path, pool: Workers, left: int, done: int) -> None:
    """Say what is done, where, and how much of it is there already."""
    known = f"{done} of them done already"
    how = f"{pool.where()}{f'; {known}' if done else ''}" if left else f"complete: all {known}"
    error_console.print(f"{plan.name}: {len(plan.trials)} {plan.things}, {how}, {'into' if left else 'in'} {out}")
    for note in filter(None, (*plan.notes, forms.note())):
        error_console.print(f"note: {note}")


def _do(
    plan: Plan[AnyTrial], left: Sequence[AnyTrial], folder: RunFolder, pool: Workers, advance: Callable[[], None]
) -> None:
    """Do trials. Those that are finished stay readable whenever this ends, by an exception or a kill too."""
    assert plan.work is not None, "a run of runs has no trials of its own"
    work = partial(_by_same_code, plan.work, provenance.digest())
    try:
        for trial, done, trouble in finished(left, work, pool, fatal=(GLUnavailable, provenance.OtherCode)):
            if done is None:
                folder.fail(trial.index, trial.label(), trial.seed, trouble)
            else:
                folder.add(done, trial.label(), trial.seed)
            advance()
    finally:
        folder.flush()


def _by_same_code(work: Callable[[AnyTrial], TrialRecord], digest: str, trial: AnyTrial) -> TrialRecord:
    """Do a job in a worker that has the same code, which one of a cluster may not have."""
    if digest != provenance.digest():
        raise provenance.OtherCode("a worker has other code of colias-sim than this process: install one everywhere")
    return work(trial)


def print_notes(folder: RunFolder) -> None:
    """Print what a reader of a run's tables has to know, and the first failures."""
    if len(frames := dict.fromkeys(chain(*folder.renderers.values()))) > 1:
        differ = f"its frames were drawn with pixels that differ (reference frames {', '.join(frames)})"
        error_console.print(f"note: {folder.folder}: {differ}: trials may have other numbers on another machine")
    failures = in_words(folder.failures())
    for text in failures[:SHOWN_FAILURES]:
        error_console.print(text)
    if len(failures) > SHOWN_FAILURES:
        error_console.print(f"... {len(failures) - SHOWN_FAILURES} more: see failures.json")
