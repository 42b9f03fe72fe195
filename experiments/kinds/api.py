"""Run, sweep, fit and watch from Python; the commands ask for the same."""

import operator
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from experiments.base.console import print_troubles
from experiments.base.errors import UsageError
from experiments.base.files import results_folder
from experiments.base.values import by_key
from experiments.declare.clip import OfflineExperiment
from experiments.declare.experiment import LIVE, Experiment
from experiments.declare.study import Fit, Study, tuple_of
from experiments.kinds import registry
from experiments.kinds.result import Run, perform, plan_of
from experiments.settings.models import model_texts
from experiments.store.asked import Asked, begun_by
from experiments.store.workers import Workers

__all__ = ["fit", "run", "sweep", "watch"]


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
    truth: bool = False,
    controls: bool = False,
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
    truth
        Whether frames and recordings have what truly moved in each pixel: see "Compare with true motion".
    controls
        Whether models see each trial again, as ``MODEL~frozen`` and so on: see "Is my model's response vision?".
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
    given = os.fspath(experiment) if isinstance(experiment, str | os.PathLike) else experiment
    found = registry.find(given)
    hand = found.conditions()[0].hand if isinstance(found, Experiment) and found.name == LIVE else None
    own = None if isinstance(given, str) or hand else found
    options = {"eyes": eyes, "recordings": recordings, "truth": truth, "controls": controls,
               "pictures": pictures and os.fspath(pictures)}  # fmt: skip
    asked = Asked(
        kind=found.kind, what=(given,) if isinstance(given, str) else (), models=tuple(model_texts(models)), only=only,
        values=by_key(settings), repeats=None if repeats is None else operator.index(repeats),
        seed=operator.index(seed), options={**options, **({"hand": asdict(hand)} if hand else {})}, declared=own,
    )  # fmt: skip
    return _done(asked, "experiments.run", out, Workers(workers, cluster, quiet=quiet))


def _done(asked: Asked, call: str, out: str | os.PathLike[str] | None, pool: Workers) -> Run:
    """Do a run in the folder asked for, or in a new one, and print what went wrong in users' claims."""
    plan = plan_of(asked)
    with begun_by({"call": call}):
        done = perform(plan, results_folder(out, plan.name), pool)
    print_troubles(done.troubles)
    return done


def fit(
    fit: Fit,
    *,
    seed: int = 0,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    quiet: bool = False,
) -> Run:
    """Search a box of parameters for settings under which all claims hold.

    The winner and the ten next best are judged again at seeds that the search never saw, and only that is a result.
    On one machine, equal arguments give equal numbers, on any number of workers. ``colias fit`` does the same.

    Parameters
    ----------
    fit
        The claims, the trials and the box.
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
    asked = Asked(kind="fit", declared=fit, seed=operator.index(seed))
    return _done(asked, "experiments.fit", out, Workers(workers, cluster, quiet=quiet))


def sweep(
    experiment: str | os.PathLike[str] | Experiment | OfflineExperiment | Study,
    over: Iterable[str] | Mapping[str, Any] = (),
    models: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] | None = None,
    seeds: range | None = None,
    *,
    claims: Sequence[str] | None = None,
    measures: Sequence[str] | None = None,
    repeats: int | None = None,
    settings: Mapping[str, Any] | None = None,
    out: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    quiet: bool = False,
) -> Run:
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
    settings
        Parameter -> value that holds at every point, as of `run`.
    out
        The folder for the trials and tables; otherwise a new one, ``runs/NAME-TIME``. There, what is missing is done.
    workers
        Number of worker processes; otherwise one for each core. 0: none, for debuggers.
    cluster
        Address of a Dask scheduler, used instead.
    quiet
        Whether to print neither plan nor progress.

    Returns
    -------
    Run
        Its ``outcomes`` have a row for each point, model, claim and replicate. Its ``summary`` has a row for each
        point, model, and claim or measure.

    Raises
    ------
    UsageError
        It cannot be run so.

    Examples
    --------
    >>> from experiments import sweep
    >>> swept = sweep("general", over=("dsnn.t_sp=0.1,0.2",), claims=("C14",), repeats=5, quiet=True)
    >>> swept.outcomes.select("dsnn.t_sp", "verdict").rows()
    [(0.1, 'holds'), (0.2, 'holds')]
    """
    if seeds is not None and (seeds.step != 1 or not seeds):
        raise UsageError(f"seeds must be a range of one or more that count up by 1, got {seeds!r}")
    named = tuple(os.fspath(experiment).split(",")) if isinstance(experiment, str | os.PathLike) else ()
    counted = seeds and len(seeds)
    options = {"over": tuple_of(over, "over"), "claims": claims, "measures": measures, "replicates": counted}
    asked = Asked(
        kind="sweep", what=named, declared=None if named else experiment, models=tuple(model_texts(models or ())),
        values=by_key(settings), repeats=repeats, seed=seeds.start if seeds else 0,
        options={name: value if isinstance(value, int) else list(value) for name, value in options.items() if value},
    )  # fmt: skip
    return _done(asked, "experiments.sweep", out, Workers(workers, cluster, quiet=quiet))


def watch(
    source: str | os.PathLike[str],
    *,
    models: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    only: bool = False,
    settings: Mapping[str, Any] | None = None,
    size: tuple[int, int] | None = None,
    fps: float | None = None,
    seconds: float | None = None,
    seed: int = 0,
    judge: bool = False,
    controls: bool = False,
    out: str | os.PathLike[str] | None = None,
    recordings: bool = True,
    quiet: bool = False,
) -> Run:
    """Show a video, a camera, pictures or a stimulus to models, with progress, and find when what moved which way.

    Parameters
    ----------
    source
        A video file, the index of a camera as a text (``"0"``), a folder of pictures, or a stimulus: a name, or the
        path of a .py file that declares ``STIMULUS``.
    models
        Models to show it to beside ``dsnn``: names, or paths of .py files.
    only
        Whether to show it just to those of ``models``.
    settings
        Parameter -> value, as ``{"dsnn.n_con": 6}``, of models and of the stimulus.
    size
        Width and height that the models see, px; otherwise 320 px along the longer side, of a stimulus its own.
    fps
        The models' frame rate; otherwise 30, to which the default thresholds belong, whatever the source's.
    seconds
        How much to show; otherwise all. A camera has no end.
    seed
        Seed of a stimulus's random draws.
    judge
        Whether to compute optical flow between frames, to grade the models and judge claim C12 by it.
    controls
        Whether models see it again, frozen, mirrored, reversed and shuffled. All frames stay in memory for that.
    out
        A new folder for the results; otherwise ``runs/watch-TIME``.
    recordings
        Whether to write a Rerun recording.
    quiet
        Whether to show no progress.

    Returns
    -------
    Run
        ``summary``: a row per interval of motion and model, with ``direction`` (rightward, leftward, downward, upward,
        looming), ``start_s``, ``end_s``, ``frames`` over the threshold, ``peak`` and ``spikes``. ``frames``: a row per
        frame and model. ``trials``: a row per model. ``failures``, ``claims``, and ``description["notes"]``: what is to
        be known of the source.

    Raises
    ------
    UsageError
        There is nothing to read, or an argument is invalid. It is a ``ValueError``.

    Examples
    --------
    >>> from experiments import watch
    >>> watch("street.mp4", models=["hybrid"]).summary
    """
    options = {"size": size, "fps": fps, "seconds": seconds, "judge": judge, "recordings": recordings,
               "controls": controls}  # fmt: skip
    asked = Asked(
        kind="watch", what=(os.fspath(source),), models=tuple(model_texts(models)), only=only,
        values=by_key(settings), seed=seed, options=options,
    )  # fmt: skip
    return _done(asked, "experiments.watch", out, Workers(0, quiet=quiet))
