"""Run an experiment from Python; the command line runs it by the same function."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from experiments.bench import registry, viewer
from experiments.bench.engine.pictures import Pictures, folder_pictures
from experiments.bench.engine.terminal import error_console, tell_troubles
from experiments.bench.offline import OfflinePlan
from experiments.bench.offline import plan as clips_plan
from experiments.bench.public.result import Run, load
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import shown_models
from experiments.bench.run.runs import Resources, worker_count
from experiments.bench.run.settings import assignments
from experiments.bench.sources import visit
from experiments.bench.sources.clips import OfflineExperiment
from experiments.bench.sources.experiment import Experiment
from experiments.bench.stats.claim import Claim
from experiments.bench.store import commands
from experiments.bench.store.description import check_own
from experiments.bench.store.files import new_folder
from experiments.bench.trials import Plan, both
from experiments.bench.trials import plan as robot_plan

if TYPE_CHECKING:
    from experiments.bench.offline import OfflineReport
    from experiments.bench.trials import Report


ONE_EYE, BOTH_EYES = "one", "both"


@dataclass(frozen=True, slots=True)
class RunRequest:
    """A request to run an experiment, with its options.

    Parameters
    ----------
    models, only
        Models to show beside the experiment's own, or with ``only`` instead of them.
    assignments
        ``SECTION.NAME=VALUE`` texts.
    repeats
        Of each condition; ``None``: the experiment's own number.
    seed
        Of the whole run.
    eyes
        ``one``: the camera as it is set. ``both``: each model sees through the model of the robot's eye too.
    pictures
        A user's own, behind the objects of clips in place of the scenes, or on the arena's wall.
    """

    models: Sequence[str] = ()
    only: bool = False
    assignments: Sequence[str] = ()
    repeats: int | None = None
    seed: int = 0
    eyes: str = ONE_EYE
    pictures: Pictures | None = None


def perform(
    experiment: Experiment | OfflineExperiment, asked: RunRequest, folder: Path, resources: Resources, *,
    recordings: bool, live: bool | str = False,
) -> Report | OfflineReport:  # fmt: skip
    """Plan, run and conclude an experiment of either kind.

    ``live`` streams trials into a viewer while they run, see `viewer_for`.

    Raises
    ------
    UsageError
        It cannot be run so; nothing is written then.
    FileExistsError
        There are tables in ``folder``, and nothing that tells of which run.
    """
    plan = planned(experiment, asked)
    address = viewer_for(experiment, live, resources)
    for note in missing_models(plan):
        error_console.print(note, soft_wrap=True, markup=False)
    if isinstance(plan, OfflinePlan):
        from experiments.bench import offline  # not before: it draws, and a wrong use should be quick

        with resources.pool(rendering=False) as pool:
            return offline.run(plan, folder, pool, resources, recordings=recordings and plan.experiment.recorded)
    from experiments.bench import trials as robot_run

    return robot_run.run(plan, folder, resources, recordings=recordings, viewer=address)


def viewer_for(experiment: Experiment | OfflineExperiment, live: bool | str, resources: Resources) -> str | None:
    """Find the viewer that trials are streamed to, or open one.

    Parameters
    ----------
    experiment
        The experiment.
    live
        The viewer's address, HOST:PORT. True: the one that listens at Rerun's own port of this machine, otherwise a new
        one, which stays open. False: none.
    resources
        What the trials run on.

    Returns
    -------
    str or None
        Its address.

    Raises
    ------
    UsageError
        There is none, or nothing to stream.
    """
    if live is False:
        return None
    if isinstance(experiment, OfflineExperiment):
        raise UsageError(f"--live: {experiment.name} shows clips; legal is an experiment with the robot")
    if resources.cluster is not None:
        raise UsageError("--live: a viewer listens on this machine alone; legal is --workers, not --cluster")
    instead = "leave --live out and use colias view RUN --web, or open one elsewhere and give its address to --viewer"
    usual = f"{viewer.HOST}:{viewer.PORT}"
    if live is not True:
        address = viewer.parsed(live)
        if not viewer.listens(address):
            raise UsageError(f"--viewer {address}: no Rerun viewer listens there; start one with: rerun --bind HOST")
    elif viewer.listens(usual):
        address = usual
    else:
        viewer.require_screen("--live: ", instead)
        _, address = viewer.opened(f"--live: Rerun's viewer did not open on this screen: {instead}")
    if not resources.quiet:
        error_console.print(f"live: each trial is a recording of the viewer at {address}", soft_wrap=True, markup=False)
    return address


def planned(experiment: Experiment | OfflineExperiment, asked: RunRequest) -> Plan | OfflinePlan:
    """Check what is asked for, and list its trials or clips; nothing is written.

    Raises
    ------
    UsageError
        It cannot be run so.
    """
    if not isinstance(asked.eyes, str) or asked.eyes not in (ONE_EYE, BOTH_EYES):
        raise UsageError(f"--eyes {asked.eyes}: legal is {ONE_EYE}, {BOTH_EYES}")
    models = shown_models(experiment.models, asked.models, asked.only)
    if isinstance(experiment, OfflineExperiment):
        if asked.eyes == BOTH_EYES:
            raise UsageError(f"--eyes {BOTH_EYES}: {experiment.name} shows clips, which no camera sees")
        if asked.pictures and not any(clip.takes_scene() for clip in experiment.clips):
            raise UsageError(f"--pictures: no clip of {experiment.name} has a background to show them")
        return clips_plan(experiment, models, asked.assignments, asked.repeats, asked.seed, asked.pictures)
    trials = robot_plan(experiment, models, asked.assignments, asked.repeats, asked.seed, asked.pictures)
    return both(trials) if asked.eyes == BOTH_EYES else trials


def missing_models(plan: Plan | OfflinePlan) -> list[str]:
    """Return a line for each claim of a user's own that compares models of which some are not shown."""
    models = plan.models if isinstance(plan, OfflinePlan) else plan.settings.models
    labels, notes = [model.label for model in models], []
    for claim in plan.experiment.claims:
        missing = sorted(getattr(claim, "models", frozenset()) - set(labels))
        if missing and isinstance(claim, Claim) and claim.own:
            needs = f"needs the models {', '.join(missing)}, which are not shown"
            notes.append(f"note: claim {claim.id} {needs}; shown are {', '.join(labels)}")
    return notes


def run(
    experiment: str | os.PathLike[str] | Experiment | OfflineExperiment,
    *,
    seed: int = 0,
    repeats: int | None = None,
    eyes: str = ONE_EYE,
    models: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    only: bool = False,
    settings: Mapping[str, Any] | None = None,
    pictures: str | os.PathLike[str] | None = None,
    out: str | os.PathLike[str] | None = None,
    recordings: bool = True,
    live: bool | str = False,
    workers: int | None = None,
    cluster: str | None = None,
    other_code: bool = False,
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
        Of the whole run, 0 or more.
    repeats
        Trials of each condition; otherwise the experiment's own number.
    eyes
        ``"both"``: each model sees the same physics through the model of the robot's eye too, as ``dsnn@ov7670``.
    models
        Models to show beside those that the experiment declares, which is ``dsnn`` for most: names, or paths of .py
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
    live
        Whether to stream trials into a Rerun viewer while they run; or the viewer's address, ``"127.0.0.1:9876"``.
    workers
        Number of worker processes; otherwise one for each core. 0: none, for debuggers.
    cluster
        Address of a Dask scheduler, used instead.
    other_code
        Whether to go on with a run that other code began; the column ``code`` marks its rows.
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
        declared, name = experiment, f"experiment {experiment.name}"
    else:
        name = str(experiment)
        declared = registry.find(name)
    registry.check_claims(declared, name)
    count = None if repeats is None else operator.index(repeats)
    asked = RunRequest(
        model_texts(models), only, assignments(settings), count, operator.index(seed), eyes,
        None if pictures is None else folder_pictures(pictures),
    )  # fmt: skip
    place = new_folder(declared.name) if out is None else Path(out)
    check_own(place, f"out={place}")
    resources = Resources(worker_count(workers), cluster, quiet, other_code)

    def call() -> dict[str, Any]:
        arguments = {
            "experiment": (
                name if declared is not experiment else visit.described(declared) or {"object": declared.name}
            ),
            "seed": asked.seed,
            "repeats": count, "eyes": eyes, "models": list(asked.models), "only": asked.only,
            "settings": dict(text.split("=", 1) for text in asked.assignments),
            "pictures": None if pictures is None else str(os.fspath(pictures)), "recordings": recordings,
        }  # fmt: skip
        defaults: dict[str, Any] = {
            "repeats": None, "eyes": ONE_EYE, "models": [], "only": False, "settings": {}, "pictures": None,
            "recordings": True,
        }  # fmt: skip
        given = {name: value for name, value in arguments.items() if name not in defaults or value != defaults[name]}
        return commands.called("experiments.run", given)

    with commands.noting(call):
        report = perform(declared, asked, place, resources, recordings=recordings, live=live)
    tell_troubles((verdict.id, verdict.trouble) for verdict in report.verdicts)
    return load(place)


def model_texts(models: str | os.PathLike[str] | Iterable[str | os.PathLike[str]]) -> list[str]:
    """Return models, one or several names and paths, as ``--model`` takes them."""
    return [os.fspath(model) for model in ([models] if isinstance(models, str | os.PathLike) else models)]
