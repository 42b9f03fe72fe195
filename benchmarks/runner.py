"""Two workers against one, and a Dask cluster of two against them: the same 170 trials, start-up included."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from rich.table import Table

from experiments.bench import registry
from experiments.bench.run.runs import Resources
from experiments.bench.run.workers import open_workers
from experiments.bench.trials import Keep, Plan, batch, plan

TRIALS = 170


def table() -> Table:
    """The paper's angular approaches, 34 repeats at 5 angles, without recordings."""
    work = plan(registry.load("angular-approach"), ["dsnn"], (), TRIALS // 5, 0)
    taken = {
        "1 worker": _timed(work, lambda: open_workers(1)),
        "2 workers": _timed(work, lambda: open_workers(2)),
        "Dask, 2 workers": _on_cluster(work),
    }
    timings = Table(title=f"{TRIALS} trials, seconds")
    for name in ("where", "s", "trials a second", "times 1 worker", "times 2 workers"):
        timings.add_column(name, justify="left" if name == "where" else "right")
    for name, seconds in taken.items():
        timings.add_row(
            name,
            f"{seconds:.1f}",
            f"{TRIALS / seconds:.1f}",
            f"{seconds / taken['1 worker']:.2f}",
            f"{seconds / taken['2 workers']:.2f}",
        )
    return timings


def _timed(work: Plan, opened: Callable) -> float:  # type: ignore[type-arg]
    with tempfile.TemporaryDirectory() as name:
        resources = Resources(0, quiet=True)
        trials = batch(work, Keep(recordings=False))
        folder = trials.open(Path(name) / "run", resources)
        began = time.perf_counter()
        with opened() as pool:
            trials.fill(folder, pool, resources)
        return time.perf_counter() - began


def _on_cluster(work: Plan) -> float:
    """A cluster's own start is not counted: it is there before the run."""
    from distributed import LocalCluster

    with LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=":0") as cluster:
        return _timed(work, lambda: open_workers(0, cluster.scheduler_address))
