"""Run a study: do the trials, or show the clips, that its folder lacks, count, tabulate and draw."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from experiments import NAMES
from experiments.bench import registry
from experiments.bench import trials as robot_run
from experiments.bench.engine.pictures import Pictures
from experiments.bench.offline import plan as clips_plan
from experiments.bench.offline import play_clip
from experiments.bench.run.errors import UsageError
from experiments.bench.run.folder import RunFolder
from experiments.bench.run.models import shown_models
from experiments.bench.run.play import FRAMES
from experiments.bench.run.runs import Batch, Resources
from experiments.bench.sources.clips import TRIALS, OfflineExperiment, pixels
from experiments.bench.sources.experiment import Experiment
from experiments.bench.sources.rows import FRAME_SCHEMA, TRIAL_SCHEMA
from experiments.bench.stats.claim import Claim, claim_ids
from experiments.bench.store.files import Files
from experiments.bench.studies import clips, robot
from experiments.bench.studies.counts import Counts
from experiments.bench.studies.plan import StudyPlan
from experiments.bench.studies.replicates import MODEL, asked_models
from experiments.bench.studies.study import Study
from scenes.hints import nearest

TABLE = "counts.csv"


def planned(
    study: Study, seed: int = 0, models_in: Mapping[str, Sequence[str]] | None = None, pictures: Pictures | None = None
) -> StudyPlan:
    """Check and list all that a study runs.

    Parameters
    ----------
    study
        The study.
    seed
        Of replicate 0; replicate k has ``seed`` + k.
    models_in
        Experiment -> the models shown there, all judged together, in place of the study's.
    pictures
        One for each replicate, behind the objects of clips in place of the scenes, or on the arena's wall.

    Raises
    ------
    UsageError
        The experiments are of both kinds, or something that the study asks for is not legal.
    """
    experiments = [registry.find(name) for name in study.experiments or answering(study.claims)]
    with_robot = [experiment for experiment in experiments if isinstance(experiment, Experiment)]
    offline = [experiment for experiment in experiments if isinstance(experiment, OfflineExperiment)]
    if with_robot and offline:
        both = f"{with_robot[0].name} has a robot and {offline[0].name} is off-line"
        raise UsageError(f"EXPERIMENT: {both}; a study has experiments of one kind")
    if not study.models:
        models_in = models_in or {experiment.name: asked_models(experiment) for experiment in with_robot}
        study = replace(study, models=(MODEL,))
    if study.as_run:
        models = shown_models(offline[0].models, study.models[1:], only=False)
        run_plan = clips_plan(offline[0], models, (), study.replicates, seed, pictures)
        return clips.points_of_run(study, run_plan)
    if offline:
        return clips.planned(study, offline, seed, pictures)
    return robot.planned(study, with_robot, seed, models_in or {}, pictures)


def answering(claims: Sequence[str | Claim]) -> list[str]:
    """Return the paper's experiments with the robot that answer for claims: of each claim the first that declares it.

    Raises `UsageError` for a claim that none of them declares.
    """
    names = []
    for claim in claims:
        name = claim.id if isinstance(claim, Claim) else claim
        if isinstance(claim, str) and name not in claim_ids():
            near = nearest(name, claim_ids(), " (", ")")
            raise UsageError(f"unknown claim {name!r}{near}; colias list shows the paper's")
        if name not in registry.answering():
            raise UsageError(f"claim {name}: no experiment with the robot declares it; the study has to name one")
        names.append(registry.answering()[name])
    return [name for name in NAMES if name in names]


def batch(plan: StudyPlan, name: str = "") -> Batch[Any]:
    """Return all trials, or clips, of a study as a batch. They leave neither recordings nor frames."""
    several = f", {plan.replicates} replicates" if plan.replicates > 1 else ""
    of_clips, probe = plan.things == "clips", plan.study.probe
    name = name or plan.study.name
    return Batch(
        name=name,
        specs=plan.specs,
        work=partial(play_clip, frames=False) if of_clips
        else probe.work if probe
        else partial(robot_run.work, keep=robot_run.ROWS_ONLY),
        description={**plan.description, "experiment": name},
        schemas=(TRIALS, FRAMES) if of_clips else (probe.schema() if probe else TRIAL_SCHEMA, FRAME_SCHEMA),
        parameters=plan.parameters,
        things=plan.things,
        amount=lambda: f"{len(plan.points)} points{several}, {len(plan.specs)} {plan.things}",
        size=pixels if of_clips else robot_run.seconds,
    )  # fmt: skip


def run(plan: StudyPlan, out: Path, resources: Resources, *, name: str = "") -> Counts:
    """Run what a study's folder lacks, and write its table and figure.

    Parameters
    ----------
    plan
        From `planned`.
    out
        The study's folder: a new one, or one that holds a part of this study.
    resources
        Workers, or a cluster.
    name
        What the run and its files are called, otherwise by the study's name.

    Returns
    -------
    Counts
        ``counts.csv``, ``NAME.json`` and ``NAME.svg`` in the folder have them.

    Raises
    ------
    FileExistsError
        There are tables, and nothing that tells of which run.
    UsageError
        There is another run.
    """
    whole = batch(plan, name)
    with resources.pool() as pool, whole.run(out, pool, resources) as folder:
        counts = Counts(plan, folder.trials().to_dicts(), folder.failures())
        write(counts, folder, name or plan.study.name)
        return counts


def write(counts: Counts, folder: RunFolder | Files, name: str) -> None:
    """Write a study's table, its ``NAME.json`` and its figure into a folder."""
    from experiments.bench.figures import plotting  # not before: workers do without matplotlib
    from experiments.bench.studies import figure

    folder.write_rows(TABLE, counts.table())
    folder.write_json(f"{name}.json", counts.described())
    if counts.cells or counts.numbers:
        plotting.save(figure.draw(counts), folder.folder, name)
