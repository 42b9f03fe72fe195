"""Run, sweep and fit from Python; the commands do it by the same functions."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import polars as pl

from experiments.bench import fit as fits
from experiments.bench import offline, registry, trials
from experiments.bench import sweep as sweeps
from experiments.bench.report.terminal import print_troubles
from experiments.bench.result import Run
from experiments.bench.run.command import begun_by
from experiments.bench.run.errors import UsageError, check_known, short
from experiments.bench.run.files import new_folder
from experiments.bench.run.models import model_texts, shown_models
from experiments.bench.run.runs import Batch
from experiments.bench.run.settings import assignments
from experiments.bench.run.workers import Workers
from experiments.bench.sources.clips import OfflineExperiment
from experiments.bench.sources.experiment import LIVE, Experiment
from experiments.bench.sources.pictures import Pictures, folder_pictures
from experiments.bench.stats.claim import Claim
from experiments.bench.study import Fit, Study, shipped, typed
from experiments.bench.sweep_plan import planned as planned_sweep

__all__ = ["Claim", "fit", "perform", "planned", "run", "sweep"]


def planned(
    experiment: Experiment | OfflineExperiment,
    *,
    models: Sequence[str] = (),
    only: bool = False,
    settings: Sequence[str] = (),
    repeats: int | None = None,
    seed: int = 0,
    eyes: str = "one",
    pictures: Pictures | None = None,
) -> Batch[Any]:
    """Check what is asked for, and list its trials or clips; nothing is written.

    Parameters
    ----------
    experiment
        The experiment.
    models, only, repeats, seed, eyes
        As of `run`.
    settings
        ``SECTION.NAME=VALUE`` texts.
    pictures
        A user's own, behind the objects of clips in place of the scenes, or on the arena's wall.

    Raises
    ------
    UsageError
        It cannot be run so.
    """
    check_known("--eyes", eyes, ("one", "both"))
    shown = shown_models(experiment.models, models, only)
    if isinstance(experiment, OfflineExperiment):
        if eyes == "both":
            raise UsageError(f"--eyes both: {experiment.name} shows clips, which no camera sees")
        if pictures and not any(clip.takes_scene() for clip in experiment.clips):
            raise UsageError(f"--pictures: no clip of {experiment.name} has a background to show them")
        return offline.plan(experiment, shown, settings, repeats, seed, pictures)
    return trials.plan(experiment, shown, settings, repeats, seed, pictures, both=eyes == "both")


def perform(
    experiment: Experiment | OfflineExperiment, folder: Path, pool: Workers, *, recordings: bool = True,
    **asked: Any,
) -> Run:  # fmt: skip
    """Run an experiment of either kind into a folder, and judge its claims.

    Parameters
    ----------
    experiment, folder, pool
        What to run, into which folder, on what.
    recordings
        Whether to write a recording of each trial.
    **asked
        As of `planned`.

    Raises
    ------
    UsageError
        It cannot be run so; nothing is written then.
    """
    plan = planned(experiment, **asked)
    if isinstance(experiment, OfflineExperiment):
        with pool.running(rendering=False):
            return offline.run(plan, folder, pool, recordings=recordings and experiment.recorded)
    with pool.running():
        return trials.run(plan, folder, pool, recordings=recordings)


def run(
    experiment: str | os.PathLike[str] | Experiment | OfflineExperiment,
    *,
    seed: int = 0,
    repeats: int | None = None,
    eyes: str = "one",
    models: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    only: bool = False,
    settings: Mapping[str, Any] | None = None,
    pictures: str | os.PathLike[str] | None = None,
    out: str | os.PathLike[str] | None = None,
    recordings: bool = True,
    workers: int | None = None,
    cluster: str | None = None,
    quiet: bool = False,
) -> Run:
    """Run an experiment, with progress, as ``colias run`` does: equal arguments give equal rows.

    It works in a script with or without ``if __name__ == "__main__":``, in a notebook, and from standard input:
    worker processes do not import the script.

    Parameters
    ----------
    experiment
        A name (`NAMES`, `OFFLINE`), the path of a .py file that declares ``EXPERIMENT``, or the experiment itself.
    seed
        Seed of the whole run, 0 or more.
    repeats
        Trials of each condition; otherwise the experiment's own number.
    eyes
        ``"both"``: each model sees the same physics through the model of the robot's eye too, as ``dsnn@ov7670``.
    models
        Models to show besides those of the experiment, which is ``dsnn`` for most: names, or paths of .py
        files that declare ``MODEL``; with settings of their own as ``"dsnn:w_i=1,n_con=6"``.
    only
        Whether to show just those of ``models``.
    settings
        Parameter -> value, as ``{"dsnn.n_con": 6, "experiment.speeds_cm_s": [4, 6]}``. ``colias list parameters`` lists
        them all.
    pictures
        A folder of your own pictures. Repeat r of a clip has picture r behind its object; of trials with the robot,
        which are one replicate, the arena's wall has the first.
    out
        The folder for the results; otherwise a new one, ``runs/NAME-TIME``. Where this run was begun there, only what
        is missing is done.
    recordings
        Whether to write a Rerun recording of each trial.
    workers
        Number of worker processes; otherwise one for each core. 0: none, for debuggers.
    cluster
        Address of a Dask scheduler, used instead.
    quiet
        Whether to print neither plan nor progress.

    Returns
    -------
    Run
        What is in the folder: tables, verdicts, figure, recordings. Trials that failed are in ``Run.failures``.

    Raises
    ------
    UsageError
        Something cannot be run so, in one line; nothing was written. It is a ``ValueError``.

    Examples
    --------
    >>> from experiments import run
    >>> speed = run("speed", repeats=2, models=["emd"], settings={"dsnn.n_con": 6})
    >>> speed.claims.select("id", "model", "count")
    """
    if isinstance(experiment, Experiment | OfflineExperiment):
        declared: Experiment | OfflineExperiment = experiment
        hand = declared.conditions()[0].hand if isinstance(declared, Experiment) and declared.name == LIVE else None
        source: Any = {LIVE: asdict(hand)} if hand else {"object": declared.name}
        registry.find(declared)  # its claims are those of its kind
    else:
        declared, source = registry.find(str(experiment)), str(experiment)
    texts = assignments(settings)
    asked = {
        "models": model_texts(models), "only": only, "settings": texts, "seed": operator.index(seed),
        "repeats": None if repeats is None else operator.index(repeats), "eyes": eyes,
        "pictures": None if pictures is None else folder_pictures(pictures),
    }  # fmt: skip
    place = new_folder(declared.name) if out is None else Path(out)
    arguments = {
        **asked, "experiment": source, "settings": dict(text.split("=", 1) for text in texts),
        "pictures": None if pictures is None else os.fspath(pictures), "recordings": recordings,
    }  # fmt: skip
    pool = Workers(workers, cluster, quiet=quiet)
    with begun_by({"call": "experiments.run", "arguments": arguments}):
        done = perform(declared, place, pool, recordings=recordings, **asked)
    print_troubles((verdict.id, verdict.trouble) for verdict in done.verdicts)
    return done


def fit(
    fit: str | Fit,
    *,
    seed: int = 0,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    quiet: bool = False,
) -> Run:
    """Search a box of parameters for settings under which all claims hold.

    The winner and the ten next best are judged again at seeds that the search never saw, and only that is a result.
    Equal arguments give equal numbers, on any number of workers. ``colias fit`` does the same.

    Parameters
    ----------
    fit
        The fit, or the name of one that ships.
    seed
        Seed of the search, 0 or more. The seeds of the second judging and of the sample follow from it.
    out
        The folder for the results; otherwise a new one, ``runs/NAME-TIME``. Where this fit was begun there, only what
        is missing is done; more settings may be searched than before.
    workers
        Number of worker processes; otherwise one for each core. 0: none, for debuggers.
    cluster
        Address of a Dask scheduler, used instead.
    quiet
        Whether to print neither plan nor progress.

    Returns
    -------
    Run
        Its ``summary`` has the scores of all settings, ``anew`` the best judged again, ``fitted`` the result.

    Raises
    ------
    UsageError
        Something cannot be run so, in one line. It is a ``ValueError``.
    ImportError
        Optuna is not installed: the extra ``[fit]``.

    Examples
    --------
    >>> from experiments import Fit, Study, fit
    >>> threshold = Study("threshold", "C14 and C15 at some threshold", claims=("C14", "C15"))
    >>> run = fit(Fit(threshold, over=("dsnn.t_sp=0.05..0.3",), trials=60))
    >>> print(*run.fitted["sentences"], sep="\\n")
    """
    asked = shipped(fit) if isinstance(fit, str) else fit
    if not isinstance(asked, Fit):
        raise UsageError(f"fit must be an experiments.Fit, or the name of one that ships, got {short(fit)}")
    place = new_folder(asked.study.name) if out is None else Path(out)
    return fits.run(asked, operator.index(seed), place, Workers(workers, cluster, quiet=quiet))


def sweep(
    experiment: str | os.PathLike[str] | Experiment | OfflineExperiment | Study,
    over: Iterable[str] | Mapping[str, Any] = (),
    models: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] | None = None,
    seeds: range | None = None,
    *,
    claims: Sequence[str] | None = None,
    measures: Sequence[str] | None = None,
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
        Experiments, names or files joined by commas, or one as it is; or a study, by its name, its file, or as it is.
    over
        Axes: ``KEY=V1,V2`` texts, as ``--over`` takes them, or ``{"dsnn.t_sp": (0.1, 0.2)}``. A study has its own.
    models
        The models judged, one by one; ``None``: those of the study, or the DSNN.
    seeds
        The seed of each replicate; ``None``: from 0, as many as the study has, or one.
    claims, measures
        Ids of claims, and names of measures; ``None``: the study's own, or all claims declared about the models.
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
        A row for each point, model, claim and replicate: ``verdict``, what ``decided``, what was ``measured``, and the
        ``slack`` in smallest differences. Without claims, a row for each point, model and measure: ``value``, and its
        95 % interval.

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
    if seeds is not None and (seeds.step != 1 or not seeds):
        raise UsageError(f"seeds must be a range of one or more that count up by 1, got {seeds!r}")
    given = {"models": None if models is None else model_texts(models), "claims": claims, "measures": measures,
             "replicates": seeds and len(seeds)}  # fmt: skip
    study = typed(experiment, over, **given)
    asked = {"over": over, "models": models, "claims": claims, "measures": measures}
    again = {name: getattr(study, name) for name, value in asked.items() if value}
    own = any(isinstance(claim, Claim) for claim in again.get("claims", ()))
    source = str(experiment) if isinstance(experiment, str | os.PathLike) and not own else {"object": study.name}
    arguments = {**again, "experiment": source, "repeats": repeats, "seeds": seeds and [seeds.start, seeds.stop]}
    place = new_folder(study.name) if out is None else Path(out)
    plan = planned_sweep(study, seeds.start if seeds else 0, repeats=repeats)
    with begun_by({"call": "experiments.sweep", "arguments": arguments}):
        result = sweeps.run(plan, place, Workers(workers, quiet=quiet))
    return result.table if plan.claims else result.numbers
