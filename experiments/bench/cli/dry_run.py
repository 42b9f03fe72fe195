"""Output of ``colias run --dry-run``: the plan, checked, and where its results would be."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import typer

from experiments.bench.engine.terminal import count
from experiments.bench.offline import OfflinePlan
from experiments.bench.public.run import missing_models
from experiments.bench.run.folder import has_tables, read_table
from experiments.bench.run.models import rate_notes
from experiments.bench.store.description import begun, reconciled
from experiments.bench.trials import Plan, describe


def say(plan: Plan | OfflinePlan, folder: Path, recordings: bool, other_code: bool) -> None:
    """Print what a run would do.

    Parameters
    ----------
    plan
        The run.
    folder
        Where it would be written.
    recordings
        Whether recordings are asked for.
    other_code
        Whether it may go on with a run that other code began.

    Raises
    ------
    UsageError
        The folder holds another run.
    """
    done = _done(plan, folder, recordings, other_code) if begun(folder) else None
    for line in _lines(plan, done):
        typer.echo(line)
    specs = plan.trials if isinstance(plan, OfflinePlan) else plan.specs()
    for note in missing_models(plan):
        typer.echo(note)
    for note in rate_notes(pair for spec in specs for pair in spec.frame_rates()):
        typer.echo(f"note: {note}")
    typer.echo(f"nothing was run; the results would be in {folder}")


def _done(plan: Plan | OfflinePlan, folder: Path, recordings: bool, other_code: bool) -> int:
    """Count the trials or clips that the folder has already."""
    if isinstance(plan, OfflinePlan):
        description = {**plan.describe(), "recordings": recordings and plan.experiment.recorded}
    else:
        description = {**describe(plan), "recordings": recordings}
    reconciled(folder, description, other_code)
    if not has_tables(folder):
        return 0
    return read_table(folder, "trials", ["trial"])["trial"].n_unique()


def _lines(plan: Plan | OfflinePlan, done: int | None) -> Iterator[str]:
    if isinstance(plan, OfflinePlan):
        conditions, jobs = [clip.name for clip in plan.experiment.clips], len(plan.trials)
        models, amount, kind = plan.models, plan.amount(), "clip"
    else:
        conditions, jobs = [condition.label() for condition in plan.experiment.conditions()], len(plan.specs())
        models, amount, kind = plan.settings.models, f"{jobs} trials, about {plan.frames():,} frames", "condition"
    already = "" if done is None else f"; {done} of {jobs} are done already"
    yield f"{plan.experiment.name}: {amount}{already}"
    yield f"{count(len(conditions), kind)}, {count(plan.repeats, 'repeat')} of each, seed {plan.seed}:"
    yield from (f"  {label}" for label in conditions)
    yield f"models: {', '.join(model.label for model in models)}"
    for key, values in plan.changed().items():
        yield from (f"set: {key}={value} ({label})" for label, value in values.items() if value is not None)
