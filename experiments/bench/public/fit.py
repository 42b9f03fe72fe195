"""Fit parameters to claims from Python; the command line does it by the same functions."""

from __future__ import annotations

import operator
import os
from pathlib import Path

from experiments.bench.fit import Fit, Fitted, planned, run
from experiments.bench.run.errors import UsageError, short
from experiments.bench.run.runs import Resources, worker_count
from experiments.bench.store.description import check_own
from experiments.bench.store.files import new_folder
from experiments.bench.study import shipped


def fit(
    fit: str | Fit,
    *,
    seed: int = 0,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    other_code: bool = False,
    quiet: bool = False,
) -> Fitted:
    """Search a box of parameters for settings under which all claims are kept or measures are largest, as
    ``colias fit`` does.

    The winner and the ten next best are judged anew at seeds that the search never saw, and only that is a result.
    Equal arguments give equal numbers, on any number of workers.

    Parameters
    ----------
    fit
        The fit, or the name of one that ships.
    seed
        Of the search, 0 or more. Those of the judging anew and of the sample follow from it.
    out
        The folder for the results; otherwise a new one, ``runs/NAME-TIME``. Where this fit was begun there, only what
        is missing is done; more settings may be searched than before.
    workers
        Number of worker processes; otherwise one for each core. 0: none, for debuggers.
    cluster
        Address of a Dask scheduler, used instead.
    other_code
        Whether to go on with a fit that other code began.
    quiet
        Whether to print neither plan nor progress.

    Returns
    -------
    Fitted
        The scores of all settings, the winner judged anew, and the answer in sentences: of claims, or of measures.

    Raises
    ------
    UsageError
        Something cannot be run so, in one line, or Optuna is not installed (the extra ``[fit]``). It is a
        ``ValueError``.

    Examples
    --------
    >>> from experiments import Fit, Study, fit
    >>> threshold = Study("threshold", "C14 and C15 at some threshold", claims=("C14", "C15"))
    >>> fitted = fit(Fit(threshold, over=("dsnn.t_sp=0.05..0.3",), trials=60))
    >>> print(*fitted.sentences(), sep="\\n")
    """
    asked = shipped(fit, "FIT") if isinstance(fit, str) else fit
    if not isinstance(asked, Fit):
        raise UsageError(f"fit {short(fit)}: legal is an experiments.Fit, or the name of one that ships")
    plan = planned(asked, operator.index(seed))
    place = new_folder(asked.study.name) if out is None else Path(out)
    check_own(place, f"out={place}")
    return run(plan, place, Resources(worker_count(workers), cluster, quiet, other_code))
