"""Run an experiment's trials with the robot into a folder, and conclude."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from experiments.bench.robot.summary import Report
from experiments.bench.run.play import play
from experiments.bench.run.runs import Batch, Resources
from experiments.bench.sources.course import nominal
from experiments.bench.sources.robot import RobotTrial
from experiments.bench.sources.rows import FRAME_SCHEMA, TRIAL_SCHEMA
from experiments.bench.store.drawing import drawn_here
from experiments.bench.store.rows import TrialRecord
from experiments.bench.trials import Plan, describe, notes


@dataclass(frozen=True, slots=True)
class Keep:
    """Parts that are kept of a trial beside its rows."""

    recordings: bool = True
    frames: bool = True
    viewer: str | None = None
    """Address, HOST:PORT, of a viewer that trials are streamed to while they run."""


ROWS_ONLY = Keep(recordings=False, frames=False)


def work(trial: RobotTrial, *, keep: Keep) -> TrialRecord:
    """Play one trial in a worker, with its recording if that is kept."""
    if not keep.recordings and keep.viewer is None:
        return drawn_here(play(trial, frames=keep.frames))
    from experiments.bench.robot import recording  # not before: Rerun takes its time to load

    record = recording.record if keep.recordings else None
    viewer = None if keep.viewer is None else recording.LiveTrial(trial, keep.viewer)
    try:
        return drawn_here(play(trial, record, frames=keep.frames, maps=True, watch=viewer.see if viewer else None))
    finally:
        if viewer:
            viewer.close()


def seconds(trial: RobotTrial) -> float:
    """Return the planned duration of a trial: what it costs goes by that."""
    return nominal(trial.condition, trial.settings).seconds


def amount(plans: Sequence[Plan]) -> str:
    """Say how many trials and frames the plans have, and which of their parameters act out of sight."""
    trials = sum(len(plan.specs()) for plan in plans)
    noted = dict.fromkeys(note for plan in plans for note in notes(plan))
    return "\n".join([f"{trials} trials, about {sum(plan.frames() for plan in plans):,} frames", *noted])


def batch(plan: Plan, keep: Keep) -> Batch[RobotTrial]:
    """Return the trials of a checked plan as a batch."""
    specs = plan.specs()
    return Batch(
        name=plan.experiment.name,
        specs=specs,
        work=partial(work, keep=keep),
        description={**describe(plan), "recordings": keep.recordings},
        schemas=(TRIAL_SCHEMA, FRAME_SCHEMA),
        parameters=plan.changed(),
        amount=partial(amount, [plan]),
        size=seconds,
    )


def run(
    plan: Plan, out: Path, resources: Resources, *, recordings: bool, viewer: str | None = None
) -> Report:  # fmt: skip
    """Run a checked plan's trials with a pool of its own.

    Parameters
    ----------
    plan
        From `plan`.
    out
        The run's folder: a new one, or one that holds a part of this run.
    resources
        Workers, or a cluster.
    recordings
        Whether to record each trial for Rerun.
    viewer
        Address, HOST:PORT, of a viewer that trials are streamed to while they run.

    Returns
    -------
    Report
        What the run amounts to, as its files say.
    """
    trials = batch(plan, Keep(recordings, viewer=viewer))
    with resources.pool() as pool, closing(trials.open(out, resources)) as folder:
        failures = trials.fill(folder, pool, resources)
        from experiments.bench.robot.summary import conclude  # not before: workers do without matplotlib

        return conclude(plan, folder, failures)
