"""Run an off-line experiment's clips into a folder, and conclude."""

from __future__ import annotations

from contextlib import closing
from functools import partial
from pathlib import Path

from experiments.bench.clips.experiment import Showing
from experiments.bench.clips.plan import OfflinePlan, pixels
from experiments.bench.clips.rows import CLIP_SCHEMA, SERIES_SCHEMA
from experiments.bench.clips.show import show, show_first_seed, show_without_frames
from experiments.bench.clips.summary import OfflineReport, conclude
from experiments.bench.run.runs import Batch, Resources
from experiments.bench.run.workers import Workers

SCHEMAS = (CLIP_SCHEMA, SERIES_SCHEMA)


def batch(plan: OfflinePlan, *, record: bool = False, frames: bool = True) -> Batch[Showing]:
    """Return the clips of a checked plan as a batch.

    ``record`` keeps recordings of the first seed's clips; ``frames`` keeps a row a frame.
    """
    return Batch(
        name=plan.experiment.name,
        specs=plan.showings,
        work=partial(show_first_seed, record=record) if record else show if frames else show_without_frames,
        description={**plan.describe(), "recordings": record},
        schemas=SCHEMAS,
        parameters=plan.changed(),
        things="clips",
        amount=plan.amount,
        size=pixels,
    )


def run(plan: OfflinePlan, out: Path, pool: Workers, resources: Resources, *, record: bool = False) -> OfflineReport:
    """Show what has not been shown, and conclude.

    Parameters
    ----------
    plan
        From `experiments.bench.clips.plan.plan`.
    out
        The run's folder: a new one, or one that holds a part of this run.
    pool, resources
        Where the clips are shown.
    record
        Whether to record the first seed's clips for Rerun.
    """
    work = batch(plan, record=record)
    with closing(work.open(out, resources)) as folder:
        return conclude(plan, folder, work.fill(folder, pool, resources))
