"""Run an experiment's trials with the robot into a folder, and conclude."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
from threadpoolctl import threadpool_limits

from experiments.bench.robot.summary import Report
from experiments.bench.run.runs import Batch, Resources
from experiments.bench.sources.course import nominal
from experiments.bench.sources.experiment import TrialSpec
from experiments.bench.sources.robot import TrialResult, Watch, run_trial
from experiments.bench.sources.rows import FRAME_SCHEMA, TRIAL_SCHEMA, finished
from experiments.bench.store.drawing import drawn_here
from experiments.bench.store.rows import TrialRecord, recording_of
from experiments.bench.trials import Plan, describe, notes


@dataclass(frozen=True, slots=True)
class Keep:
    """Parts that are kept of a trial beside its rows."""

    recordings: bool = True
    frames: bool = True
    viewer: str | None = None
    """Address, HOST:PORT, of a viewer that trials are streamed to while they run."""


ROWS_ONLY = Keep(recordings=False, frames=False)


def work(spec: TrialSpec, *, keep: Keep) -> TrialRecord:
    """Run one trial in a worker, with its recording if that is kept."""
    result = simulated(spec, keep_media=keep.recordings) if keep.viewer is None else _streamed(spec, keep.viewer)
    recorded = None
    if keep.recordings:
        from experiments.bench.robot import recording  # not before: Rerun takes its time to load

        with threadpool_limits(1):
            recorded = recording_of(partial(recording.record, result))
    return drawn_here(finished(result, recorded, frames=keep.frames))


def _streamed(spec: TrialSpec, address: str) -> TrialResult:
    from experiments.bench.robot.recording import LiveTrial  # not before: Rerun takes its time to load

    live = LiveTrial(spec, address)
    try:
        return simulated(spec, keep_media=True, watch=live.see)
    finally:
        live.close()


def simulated(spec: TrialSpec, *, keep_media: bool, watch: Watch | None = None) -> TrialResult:
    """Run one trial in a worker, on one thread. ``keep_media`` keeps its pictures; ``watch`` sees each frame."""
    cv2.setNumThreads(1)  # more threads cost a second core for a sixth of the time
    with threadpool_limits(1):
        return run_trial(spec, keep_media=keep_media, watch=watch)


def seconds(spec: TrialSpec) -> float:
    """Return the planned duration of a trial: what it costs goes by that."""
    return nominal(spec.condition, spec.settings).seconds


def amount(plans: Sequence[Plan]) -> str:
    """Say how many trials and frames the plans have, and which of their parameters act out of sight."""
    trials = sum(len(plan.specs()) for plan in plans)
    noted = dict.fromkeys(note for plan in plans for note in notes(plan))
    return "\n".join([f"{trials} trials, about {sum(plan.frames() for plan in plans):,} frames", *noted])


def batch(plan: Plan, keep: Keep) -> Batch[TrialSpec]:
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
