"""Trials with the robot: plan an experiment's trials, play them into a run's folder, and conclude."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any

import polars as pl
from pydantic import ValidationError

from colias_sim.config import CameraConfig, RobotConfig, SceneConfig, known_arena
from experiments.bench.compare import corrected, tested
from experiments.bench.result import COMPARISONS, Run, load, whole_networks
from experiments.bench.run import provenance
from experiments.bench.run.description import THRESHOLDS
from experiments.bench.run.errors import UsageError, as_usage_error
from experiments.bench.run.folder import RunFolder
from experiments.bench.run.models import look_up
from experiments.bench.run.parameters import Parameters, differing
from experiments.bench.run.play import play
from experiments.bench.run.rows import TrialRecord, drawn_here
from experiments.bench.run.runs import Batch
from experiments.bench.run.settings import applied, changed, check_counts, collect
from experiments.bench.run.settings import assignments as of_mapping
from experiments.bench.run.workers import Workers
from experiments.bench.sources import course
from experiments.bench.sources.conditions import CONDITION_COLUMNS, SCRIPTED
from experiments.bench.sources.experiment import Design, Experiment, Settings
from experiments.bench.sources.judge import judge
from experiments.bench.sources.pictures import Pictures, digests
from experiments.bench.sources.robot import MARK, TRUE, RobotTrial, camera, is_random, trials_of
from experiments.bench.sources.trial_rows import FRAME_SCHEMA, TRIAL_SCHEMA
from experiments.bench.stats import stored
from experiments.bench.stats.claim import find_claim
from experiments.bench.stats.tests import summary_rows
from experiments.bench.stats.verdict import Verdict

QUANTITIES = (
    "spikes", "firing_rate_hz", "peak_hs", "trough_hs", "peak_vs", "achieved_speed_cm_s", "path_error_mm", "drift_mm",
    "seconds_in_view", "spikes_in_view", "rate_in_view_hz", "mean_hs_in_view", "mean_hs_near_axis", "spikes_in_window",
    "spikes_in_inner_window",
)  # fmt: skip

SIGNED = ("peak_hs", "trough_hs", "peak_vs", "drift_mm", "mean_hs_in_view", "mean_hs_near_axis")
"""Those of them that can be negative: of the others no interval goes below 0."""


FILES = ("scene.arena", "scene.wall", "scene.shell_picture")
"""Parameters that may be paths: tables and titles have the names of the files, as these may be moved."""


def changes(
    experiment: Experiment, settings: Settings, declared: Design, pictures: Pictures | None = None
) -> Parameters:
    """Return the parameters that are not at their defaults, by key and model; files by their names alone.

    The wall of ``pictures`` is no parameter.
    """
    usual = dataclasses.replace(usual_scene(experiment), wall=settings.scene.wall if pictures else "")
    others = {
        "robot": (RobotConfig(), settings.robot),
        "camera": (CameraConfig(), settings.camera),
        "scene": (usual, settings.scene),
        "experiment": (declared, experiment.design),
    }
    return {
        key: {label: Path(text).name for label, text in values.items()} if key in FILES else values
        for key, values in differing(settings.models, others=others).items()
    }


def sections(experiment: Experiment | None, models: Sequence[str]) -> dict[str, Any]:
    """Section name -> its default value: each model under its family's name, the apparatus, then the design.

    Models of one family with the same parameters (``dsnn``, ``dsnn-reference``) share a section: the first one's
    defaults.
    """
    models_shown = look_up(models)
    applied(models_shown, {})  # what is asked of them has to be legal too
    table: dict[str, Any] = {}
    for model in models_shown:
        table.setdefault(model.section, model.network)
    table |= {"robot": RobotConfig(), "camera": CameraConfig(), "scene": usual_scene(experiment)}
    return table if experiment is None else {**table, "experiment": experiment.design}


def usual_scene(experiment: Experiment | None) -> SceneConfig:
    """Return the scene that trials have where ``--set`` says nothing: the default one, in the experiment's arena.

    Raises
    ------
    UsageError
        The experiment's arena is unknown.
    """
    if experiment is None or not experiment.arena:
        return SceneConfig()
    with as_usage_error(f"experiment {experiment.name}: "):
        return SceneConfig(arena=known_arena(experiment.arena))


def configure(experiment: Experiment, models: Sequence[str], assignments: Iterable[str]) -> tuple[Experiment, Settings]:
    """Apply ``SECTION.NAME=VALUE`` texts; raises `UsageError` naming the value, its range and its origin."""
    values = sections(experiment, models)
    collected = collect([*of_mapping(experiment.settings), *assignments], values)
    chosen = applied(look_up(models), collected)
    robot, camera, scene, design = (
        changed(section, values[section], collected.get(section, {}))
        for section in ("robot", "camera", "scene", "experiment")
    )
    if lacking := [name for name in ("pose_sd_mm", "heading_sd_deg") if not hasattr(design, name)]:
        where = f"{experiment.file or experiment.name}: the design {type(design).__name__}"
        raise UsageError(f"{where} must have {' and '.join(lacking)}, spreads of the start from 0 to 100")
    settings = Settings(chosen, robot, camera, scene, design.pose_sd_mm, design.heading_sd_deg)
    with as_usage_error("--set: "):
        return dataclasses.replace(experiment, design=design), settings


def checked(
    experiment: Experiment, models: Sequence[str], assignments: Iterable[str], repeats: int | None, seed: int,
    pictures: Pictures | None = None,
) -> tuple[Experiment, Settings, int]:  # fmt: skip
    """Check what a person typed; return the experiment and its settings with the values set, and the repeats.

    The wall of the arena has the first of the ``pictures``, as a run is replicate 0. Raises `UsageError` for what
    cannot be run.
    """
    count = experiment.repeats if repeats is None else repeats
    whole, settings = configure(experiment, models, assignments)
    if pictures and settings.scene.wall:
        raise UsageError(f"--set scene.wall={settings.scene.wall}: --pictures sets the wall; give one of them")
    if pictures:
        settings = dataclasses.replace(settings, scene=dataclasses.replace(settings.scene, wall=pictures[0]))
    check_counts(seed, count, f"{experiment.name}: repeats" if repeats is None else "--repeats")
    course.check(whole.conditions(), settings)
    return whole, settings, count


def plan(
    experiment: Experiment, models: Sequence[str], assignments: Iterable[str], repeats: int | None, seed: int,
    pictures: Pictures | None = None, *, both: bool = False,
) -> Batch[RobotTrial]:  # fmt: skip
    """Return an experiment's trials as a batch, from what a person typed.

    With ``both``, each model sees through the model of the robot's eye too. Raises `UsageError` for what cannot be run.
    """
    whole, settings, count = checked(experiment, models, assignments, repeats, seed, pictures)
    settings = both_eyes(settings) if both else settings
    return batch(whole, settings, count, seed, experiment.design, pictures)


def both_eyes(settings: Settings) -> Settings:
    """Return settings with each of the models seeing through the model of the robot's eye too.

    Raises
    ------
    UsageError
        The camera is that eye already, or has a size or a clock that the eye cannot have.
    """
    try:
        eye = camera(settings, TRUE)
    except ValidationError as error:
        raise UsageError(
            f"--eyes both: the camera of preset {TRUE} cannot have the set size or rate: {error.errors()[0]['msg']}"
        ) from None
    if eye == settings.camera:
        raise UsageError(f"--eyes both: the camera is that of preset {TRUE} already; leave out --set camera.*")
    more = tuple(dataclasses.replace(model, label=f"{model.label}{MARK}{TRUE}") for model in settings.models)
    return dataclasses.replace(settings, models=(*settings.models, *more))


def work(trial: RobotTrial, *, recordings: bool = False, frames: bool = False) -> TrialRecord:
    """Play one trial in a worker, with a row per frame and its recording as far as they are wanted."""
    if not recordings:
        return drawn_here(play(trial, frames=frames))
    from experiments.bench.sources.recording import record  # not before: Rerun takes its time to load

    return drawn_here(play(trial, record, frames=frames, maps=True))


def batch(
    experiment: Experiment, settings: Settings, repeats: int, seed: int, declared: Design,
    pictures: Pictures | None = None,
) -> Batch[RobotTrial]:  # fmt: skip
    """Return checked trials as a batch, which keeps neither frames nor recordings.

    ``declared`` is the experiment's design before ``--set`` changed it. Where ``changed`` is in the description, it has
    the parameters that are not at their defaults.
    """
    scene = dataclasses.replace(settings.scene, wall="") if pictures else settings.scene  # they are noted apart
    changed = changes(experiment, settings, declared, pictures)
    specs = trials_of(experiment, settings, repeats, seed)
    paths = {  # of conditions of one's own: rows have no column for them
        condition.label(): {name: getattr(condition, name) for name in SCRIPTED if name != "hand" or condition.hand}
        for condition in experiment.conditions()
        if condition.path is not None or condition.hand is not None
    }
    description = {
        "kind": "trials",
        "experiment": experiment,
        "repeats": repeats,
        "seed": seed,
        "trials": len(specs),
        "settings": settings,
        **({"paths": paths} if paths else {}),
        **({"pictures": digests(pictures)} if pictures else {}),
        **({"changed": changed} if changed else {}),
        THRESHOLDS: {model.label: model.thresholds for model in settings.models},
        "recordings": False,
        **provenance.of([*(model.source for model in settings.models), *course.files(scene)], experiment),
    }
    schemas = TRIAL_SCHEMA, FRAME_SCHEMA
    return Batch(experiment.name, specs, work, description, schemas, parameters=changed)


def run(trials: Batch[RobotTrial], out: Path, pool: Workers, *, recordings: bool) -> Run:
    """Run trials, judge and draw.

    Parameters
    ----------
    trials
        From `plan`.
    out
        The run's folder: a new one, or one that holds a part of this run.
    pool
        Where the trials are played.
    recordings
        Whether to record each trial for Rerun.

    Returns
    -------
    Run
        The run as its files have it.
    """
    playing = partial(work, recordings=recordings, frames=True)
    trials = dataclasses.replace(trials, work=playing, description={**trials.description, "recordings": recordings})
    with trials.run(out, pool) as folder:
        return conclude(trials.description, folder)


def conclude(description: Mapping[str, Any], folder: RunFolder) -> Run:
    """Judge the claims of the trials in ``folder``, of a batch's description, and write verdicts, summary and figure.

    Returns
    -------
    Run
        The run as its files have it.
    """
    experiment, models = description["experiment"], description["settings"].models
    rows = folder.table("trials").to_dicts()
    folder.write_json("claims.json", stored.document(_verdicts(description, rows, folder.failures())))
    run = load(folder.folder)
    if not rows:
        return run
    from experiments.bench.report import style  # not before: workers do without matplotlib

    whole = whole_networks(run)
    folder.write_rows("summary.csv", summary_rows(whole, ("model", *CONDITION_COLUMNS), QUANTITIES, SIGNED))
    if compared := compare(whole, models[0].label if len(experiment.models) > 1 else ""):
        folder.write_rows("comparisons.csv", compared)
    if run.excitations.height:
        folder.write_rows("excitation.csv", run.excitations.to_dicts())
    style.save(run.figure(), folder.folder / "figure")
    return run


def _verdicts(description: Mapping[str, Any], rows: Sequence[Any], failures: Sequence[Any]) -> list[Verdict]:
    """Judge each claim, for each model that it is about, or once for the models that it compares."""
    experiment, models = description["experiment"], description["settings"].models
    random = description["kind"] != "trials" or is_random(description["settings"])  # what a real robot did always is
    claims = [find_claim(claim, "robot") for claim in experiment.claims]
    thresholds = {model.label: model.threshold for model in models}
    asked = [
        (claim, model.label)
        for model in models
        for claim in claims
        if not claim.models and (claim.about == "looming") != ("hs" in model.channels)
    ]
    asked += [(claim, "") for claim in claims if claim.models]
    verdicts = []
    for claim, label in asked:
        about = [row for row in rows if label in ("", row["model"])]
        lost = sum(failure["model"] in ("", label, *claim.models) for failure in failures)
        failed = f"{lost} trial{'s' * (lost != 1)} of the run failed" if lost else ""
        outcome = judge(claim, about, thresholds.get(label or claim.spiking)).noting(failed)
        verdicts.append(claim.verdict([outcome], random=random, model=label, experiment=experiment.name))
    return verdicts


def compare(rows: Sequence[Any], reference: str = "") -> list[dict[str, Any]]:
    """Models on the same trials, per condition: a paired test of their spikes, p by Holm over all rows.

    A model that does not spike has nothing to be tested.

    Parameters
    ----------
    rows
        Of ``trials.parquet``.
    reference
        The model that all others are compared with; empty: every two models are.
    """
    table = pl.DataFrame(rows, infer_schema_length=None)
    found = [
        row
        for _, chosen in table.group_by(CONDITION_COLUMNS, maintain_order=True)
        for pair in combinations(table["model"].unique(maintain_order=True), 2)
        if reference in ("", pair[0])
        for row in tested(chosen, chosen, pair, CONDITION_COLUMNS, "trial")  # one may have failed in some
    ]
    return corrected(found, COMPARISONS).to_dicts()
