"""Make a map: run the trials that its folder lacks, judge, tabulate and draw."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from experiments.bench.core.batch import Batch, Resources
from experiments.bench.core.store.rows import Failure
from experiments.bench.robot import run as robot_run
from experiments.bench.robot.experiment import TrialSpec
from experiments.bench.robot.map.judging import Cell, cells, table
from experiments.bench.robot.map.plan import MapPlan
from experiments.bench.robot.rows import FRAME_SCHEMA, TRIAL_SCHEMA, robot_contents


@dataclass(frozen=True, slots=True)
class Map:
    """A map that was made.

    Parameters
    ----------
    folder
        Its folder: ``trials.parquet``, ``map.csv``, ``map.svg`` and ``map.png``.
    plan
        What was planned.
    cells
        The counts of every claim at every point.
    failures
        Trials that failed, and models that failed in a trial.
    """

    folder: Path
    plan: MapPlan
    cells: list[Cell]
    failures: list[Failure]


def batch(made: MapPlan) -> Batch[TrialSpec]:
    """Return all trials of a map as a batch. They leave neither recordings nor frames."""
    several = f", {made.replicates} replicates" if made.replicates > 1 else ""
    return Batch(
        name="map",
        specs=made.specs,
        work=partial(robot_run.work, keep=robot_run.ROWS_ONLY),
        description=made.describe(),
        contents=robot_contents(made.specs, recordings=False, frames=False, parameters=made.parameters()),
        schemas=(TRIAL_SCHEMA, FRAME_SCHEMA),
        amount=lambda: f"{len(made.points)} points{several}, {len(made.specs)} trials",
        size=robot_run.seconds,
    )


def run(made: MapPlan, out: Path, resources: Resources, *, resume: bool) -> Map:
    """Run a map's trials, and write its table and figure.

    Parameters
    ----------
    made
        From `experiments.bench.robot.map.plan.planned`.
    out
        The map's folder: a new one, or with ``resume`` one that holds a part of this map.
    resources
        Workers, or a cluster.
    resume
        Whether to go on with a map that was begun.

    Raises
    ------
    FileExistsError
        The folder holds a run, and ``resume`` is False.
    UsageError
        There is nothing to go on with, or another run.
    """
    whole = batch(made)
    with resources.pool() as pool, closing(whole.open(out, resources, resume)) as folder:
        failures = whole.fill(folder, pool, resources)
        from experiments.bench.core.figures import plotting  # not before: workers do without matplotlib
        from experiments.bench.robot.map import figure

        found = cells(made, folder.rows())
        folder.write_rows("map.csv", table(made, found))
        plotting.save(figure.draw(made, found), out, "map")
        return Map(out, made, found, failures)
