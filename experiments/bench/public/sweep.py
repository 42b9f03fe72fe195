"""Sweeps from Python; the command line does them by the same functions."""

from __future__ import annotations

import os
from collections.abc import Sequence

import polars as pl

from experiments.bench import sweep as sweeps
from experiments.bench import sweep_plan
from experiments.bench.public.arguments import folder
from experiments.bench.run.errors import UsageError
from experiments.bench.run.runs import Resources, worker_count
from experiments.bench.store.description import check_own
from experiments.bench.store.files import new_folder
from experiments.bench.study import Study, called


def sweep(
    experiment: str | Study,
    over: Sequence[str] = (),
    models: Sequence[str] = ("dsnn",),
    seeds: range = range(1),
    *,
    claims: Sequence[str] = (),
    measures: Sequence[str] = (),
    repeats: int | None = None,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    quiet: bool = False,
) -> pl.DataFrame:
    """Judge claims and measure numbers at every point of a grid of parameters, as ``colias sweep`` does.

    Points that differ in parameters of models alone share their frames.

    Parameters
    ----------
    experiment
        Experiments, names or files joined by commas; or a study, by its name, its file, or as it is.
    over
        Axes: ``KEY=V1,V2`` texts, as ``--over`` takes them. A study has its own.
    models
        The models judged, one by one.
    seeds
        The seed of each replicate. A study has its own number of replicates; only the first seed counts.
    claims, measures
        Ids of claims, and names of measures; without both, all claims that are declared about the models.
    repeats
        Trials of each condition in a replicate; ``None``: the experiment's own number.
    out
        The folder for the trials and tables; otherwise a new one, ``runs/NAME-TIME``. There, what is missing is done.
    workers
        Number of worker processes; otherwise one for each core. 0: none, for debuggers.
    quiet
        Whether to print neither plan nor progress.

    Returns
    -------
    polars.DataFrame
        A row for each point, model, claim and replicate: ``verdict``, what ``decided``, what was ``measured``. Without
        claims, a row for each point, model and measure: ``value``, and its 95 % interval.

    Raises
    ------
    UsageError
        It cannot be run so.

    Examples
    --------
    >>> from experiments import sweep
    >>> table = sweep("general", over=("dsnn.t_sp=0.1,0.2",), claims=("C14",), repeats=5, quiet=True)
    >>> table.select("dsnn.t_sp", "verdict").rows()
    [(0.1, 'holds'), (0.2, 'holds')]
    """
    if seeds.step != 1 or not seeds:
        raise UsageError(f"seeds must be a range of one or more that count up by 1, got {seeds}")
    if isinstance(experiment, Study):
        study = experiment
    else:
        named = None if over else called(experiment)
        study = named or sweeps.typed(experiment, over, claims, measures, models, (), repeats, len(seeds))
    plan = sweep_plan.planned(study, seeds.start)
    place = new_folder(study.name) if out is None else folder("out", out)
    check_own(place, f"out={place}")
    result = sweeps.run(plan, place, Resources(worker_count(workers), quiet=quiet))
    return result.table if plan.claims else result.numbers
