"""Run a grid of parameters into a folder, a run for each rendering; tabulate and draw them together."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.bench.engine.batch import Resources
from experiments.bench.engine.terminal import error_console
from experiments.bench.robot import run as robot_run
from experiments.bench.robot.sweep.grid import Part, Point
from experiments.bench.store.files import Files
from experiments.bench.store.parameters import in_title
from experiments.bench.store.places import inside


@dataclass(frozen=True, slots=True)
class Sweep:
    """What became of a sweep: a row a trial, model and point, the summary, and whether trials failed.

    ``picture`` is the figure's path, ``None`` where no trial was finished.
    """

    folder: Path
    keys: list[str]
    varies: str
    rows: list[dict[str, Any]]
    summary: list[dict[str, Any]]
    picture: Path | None
    failed: bool


def run(parts: Sequence[Part], points: Sequence[Point], varies: str, out: Path, resources: Resources) -> Sweep:
    """Run what is missing of a sweep's parts, and write its table and figure.

    Parameters
    ----------
    parts, points
        From `experiments.bench.robot.sweep.grid`.
    varies
        The column of conditions that the figure is drawn against.
    out
        The sweep's folder: a new one, or one that holds a part of it.
    resources
        Workers, or a cluster.

    Raises
    ------
    FileExistsError
        The folder holds a whole sweep.
    """
    rows: list[dict[str, Any]] = []
    failed = False
    if (out / "sweep.csv").exists():
        raise FileExistsError(f"{out} already holds a sweep: choose another --out, or remove it")
    if not resources.quiet and len(parts) > 1:
        whole = f"{robot_run.amount([part.plan for part in parts])}, {resources.where()}"
        error_console.print(f"{len(points)} points: {whole}, into {out}", soft_wrap=True, markup=False)
    with resources.pool() as pool:
        for part in parts:
            batch = robot_run.batch(part.plan, robot_run.TABLES_ONLY)
            with closing(batch.open(inside(out, part.folder), resources)) as folder:
                failed |= bool(batch.fill(folder, pool, resources))
                rows += part.tagged(folder.rows())
    keys = [key for key, _ in points[0].values]
    if not rows:
        return Sweep(out, keys, varies, [], [], None, failed)
    from experiments.bench.figures import plotting  # not before: workers do without matplotlib
    from experiments.bench.robot.sweep import figure

    summary = figure.table(rows, keys)
    changed = {key: values for key, values in parts[0].plan.changed().items() if key not in keys}
    title = f"{parts[0].plan.experiment.name}, n = {parts[0].plan.repeats}{in_title(changed)}"
    picture = plotting.save(figure.draw(rows, keys, varies, title), out)
    # Last, as it makes the sweep a whole one, which is not gone on with.
    Files(out).write_rows("sweep.csv", summary)
    return Sweep(out, keys, varies, rows, summary, picture, failed)
