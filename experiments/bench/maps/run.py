"""Make a map: run the trials, or show the clips, that its folder lacks, judge, tabulate and draw."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from experiments.bench.clips.plan import pixels
from experiments.bench.clips.rows import clip_contents
from experiments.bench.clips.run import SCHEMAS
from experiments.bench.clips.show import show_without_frames
from experiments.bench.engine.batch import Batch, Resources
from experiments.bench.maps.judging import Cell, Number, cells, numbers, table
from experiments.bench.maps.plan import MapPlan
from experiments.bench.robot import run as robot_run
from experiments.bench.robot.rows import FRAME_SCHEMA, TRIAL_SCHEMA, robot_contents
from experiments.bench.store.rows import Failure


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
    numbers
        Every measure at every point.
    failures
        Trials that failed, and models that failed in a trial.
    """

    folder: Path
    plan: MapPlan
    cells: list[Cell]
    numbers: list[Number]
    failures: list[Failure]


def batch(made: MapPlan) -> Batch[Any]:
    """Return all trials, or clips, of a map as a batch. They leave neither recordings nor frames."""
    several = f", {made.replicates} replicates" if made.replicates > 1 else ""
    clips = made.things == "clips"
    if clips:
        contents = replace(clip_contents(made.specs, frames=False), parameters=made.parameters)  # type: ignore[arg-type]
    else:
        contents = robot_contents(made.specs, recordings=False, frames=False, parameters=made.parameters)
    return Batch(
        name="map",
        specs=made.specs,
        work=show_without_frames if clips else partial(robot_run.work, keep=robot_run.ROWS_ONLY),
        description=made.description,
        contents=contents,
        schemas=SCHEMAS if clips else (TRIAL_SCHEMA, FRAME_SCHEMA),
        things=made.things,
        amount=lambda: f"{len(made.points)} points{several}, {len(made.specs)} {made.things}",
        size=pixels if clips else robot_run.seconds,
    )


def run(made: MapPlan, out: Path, resources: Resources) -> Map:
    """Run a map's trials, and write its table and figure.

    Parameters
    ----------
    made
        From `experiments.bench.maps.planning.planned`.
    out
        The map's folder: a new one, or one that holds a part of this map.
    resources
        Workers, or a cluster.

    Raises
    ------
    FileExistsError
        There are tables, and nothing that tells of which run.
    UsageError
        There is another run.
    """
    whole = batch(made)
    with resources.pool() as pool, closing(whole.open(out, resources)) as folder:
        failures = whole.fill(folder, pool, resources)
        from experiments.bench.figures import plotting  # not before: workers do without matplotlib
        from experiments.bench.maps import figure

        rows = folder.rows()
        found, measured = cells(made, rows), numbers(made, rows)
        folder.write_rows("map.csv", table(made, found, measured))
        plotting.save(figure.draw(made, found, measured), out, "map")
        return Map(out, made, found, measured, failures)
