"""Trials with the robot: plan an experiment's trials, play them into a run's folder, and conclude."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from colias_sim.config import CameraConfig, RobotConfig, SceneConfig, known_arena
from experiments.bench.result import Run, load, whole_networks
from experiments.bench.run import provenance
from experiments.bench.run.description import THRESHOLDS
from experiments.bench.run.errors import UsageError, explain
from experiments.bench.run.folder import RunFolder
from experiments.bench.run.models import look_up
from experiments.bench.run.parameters import Parameters, differing
from experiments.bench.run.play import play
from experiments.bench.run.rows import Failure, TrialRecord, drawn_here, group
from experiments.bench.run.runs import Batch, Resources
from experiments.bench.run.settings import applied, changed, check_counts, collect, described
from experiments.bench.run.settings import assignments as of_mapping
from experiments.bench.sources import course
from experiments.bench.sources.conditions import CONDITION_COLUMNS, SCRIPTED
from experiments.bench.sources.course import nominal
from experiments.bench.sources.experiment import Design, Experiment, Settings
from experiments.bench.sources.judge import judge
from experiments.bench.sources.pictures import Pictures, digests, picture
from experiments.bench.sources.robot import MARK, TRUE, RobotTrial, camera, trials_of
from experiments.bench.sources.trial_rows import FRAME_SCHEMA, TRIAL_SCHEMA
from experiments.bench.stats import stored
from experiments.bench.stats.claim import Claim, find_claim
from experiments.bench.stats.tests import holm, paired, summary_rows
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


@dataclass(frozen=True, slots=True)
class Plan:
    """A run to do: everything that decides its numbers."""

    experiment: Experiment
    settings: Settings
    repeats: int
    seed: int
    declared: Design | None = None
    """The experiment's design before ``--set`` changed it."""
    pictures: Pictures | None = None
    """The wall of the arena has the first of them: a run is replicate 0."""

    @property
    def thresholds(self) -> dict[str, float | None]:
        """Each model's spiking threshold."""
        return {model.label: model.threshold for model in self.settings.models}

    def specs(self) -> list[RobotTrial]:
        """Every trial of the run."""
        return trials_of(self.experiment, self.settings, self.repeats, self.seed)

    def changed(self) -> Parameters:
        """Return the parameters that are not at their defaults, by key and model; files by their names alone."""
        settings, design = self.settings, self.experiment.design
        others = {
            "robot": (RobotConfig(), settings.robot),
            "camera": (CameraConfig(), settings.camera),
            "scene": (
                dataclasses.replace(usual_scene(self.experiment), wall=settings.scene.wall if self.pictures else ""),
                settings.scene,
            ),
            "experiment": (self.declared or design, design),
        }
        return {
            key: {label: Path(text).name for label, text in values.items()} if key in FILES else values
            for key, values in differing(settings.models, others=others).items()
        }


def describe(plan: Plan) -> dict[str, Any]:
    """Return what ``run.json`` holds: every parameter, the seed, and what computes it (see `provenance`).

    ``changed``, where it is there, has the parameters that are not at their defaults.
    """
    changed_ones = plan.changed()
    return {
        "kind": "trials",
        "experiment": plan.experiment,
        "repeats": plan.repeats,
        "seed": plan.seed,
        "trials": len(plan.specs()),
        "settings": plan.settings,
        **({"paths": paths} if (paths := _paths(plan)) else {}),
        **({"pictures": digests(plan.pictures)} if plan.pictures else {}),
        **({"changed": changed_ones} if changed_ones else {}),
        THRESHOLDS: {model.label: model.thresholds for model in plan.settings.models},
        **provenance.of(sources(plan), plan.experiment),
    }


def sources(plan: Plan) -> list[str]:
    """Return the models of a plan, and the files of its scene: what may be the user's own."""
    scene = plan.settings.scene
    if plan.pictures:  # which are noted apart
        scene = dataclasses.replace(scene, wall="")
    return [*(model.source for model in plan.settings.models), *course.files(scene)]


def _paths(plan: Plan) -> dict[str, Any]:
    """Return the paths of conditions of one's own, by the condition's label: rows have no column for them."""
    return {
        condition.label(): {name: getattr(condition, name) for name in SCRIPTED if name != "hand" or condition.hand}
        for condition in plan.experiment.conditions()
        if condition.path is not None or condition.hand is not None
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
    try:
        return SceneConfig(arena=known_arena(experiment.arena))
    except ValueError as error:
        raise UsageError(f"experiment {experiment.name}: {error}") from error


def configure(experiment: Experiment, models: Sequence[str], assignments: Iterable[str]) -> tuple[Experiment, Settings]:
    """Apply ``SECTION.NAME=VALUE`` texts; raises `UsageError` naming the value, its range and its origin."""
    values = sections(experiment, models)
    collected = collect([*of_mapping(experiment.settings), *assignments], values)
    chosen = applied(look_up(models), collected)
    for section in ("robot", "camera", "scene", "experiment"):
        values[section] = changed(section, values[section], collected.get(section, {}))
    design = values["experiment"]
    settings = Settings(
        models=chosen,
        robot=values["robot"],
        camera=values["camera"],
        scene=values["scene"],
        pose_sd_mm=design.pose_sd_mm,
        heading_sd_deg=design.heading_sd_deg,
    )
    try:
        return dataclasses.replace(experiment, design=design), settings
    except ValueError as error:
        raise UsageError(f"--set: {error}") from error


def plan(
    experiment: Experiment, models: Sequence[str], assignments: Iterable[str], repeats: int | None, seed: int,
    pictures: Pictures | None = None,
) -> Plan:  # fmt: skip
    """A checked plan from what a person typed; `UsageError` for what cannot be run."""
    count = experiment.repeats if repeats is None else repeats
    whole = Plan(*configure(experiment, models, assignments), count, seed, experiment.design, pictures)
    if pictures and whole.settings.scene.wall:
        raise UsageError(f"--set scene.wall={whole.settings.scene.wall}: --pictures sets the wall; give one of them")
    if pictures:
        settings = dataclasses.replace(
            whole.settings, scene=dataclasses.replace(whole.settings.scene, wall=picture(pictures, 0))
        )
        whole = dataclasses.replace(whole, settings=settings)
    option = f"{experiment.name}: repeats" if repeats is None else "--repeats"
    check_counts(seed, count, option)
    course.check(whole.experiment.conditions(), whole.settings)
    return whole


def both(plan: Plan) -> Plan:
    """Return the plan with each of its models seeing through the model of the robot's eye too.

    Raises
    ------
    UsageError
        The camera of the plan is that eye already, or has a size or a clock that the eye cannot have.
    """
    settings = plan.settings
    try:
        eye = camera(settings, TRUE)
    except ValidationError as error:
        raise UsageError(
            f"--eyes both: the camera of preset {TRUE} cannot have the set size or rate: {explain(error)}"
        ) from None
    if eye == settings.camera:
        raise UsageError(f"--eyes both: the camera is that of preset {TRUE} already; leave out --set camera.*")
    more = tuple(dataclasses.replace(model, label=f"{model.label}{MARK}{TRUE}") for model in settings.models)
    return dataclasses.replace(plan, settings=dataclasses.replace(settings, models=(*settings.models, *more)))


def parameters(experiment: Experiment, models: Sequence[str]) -> Iterator[dict[str, str]]:
    """Every key that ``--set`` takes for an experiment, with its present value."""
    return described(sections(experiment, models))


def work(trial: RobotTrial, *, recordings: bool = False, frames: bool = False) -> TrialRecord:
    """Play one trial in a worker, with a row per frame and its recording as far as they are wanted."""
    if not recordings:
        return drawn_here(play(trial, frames=frames))
    from experiments.bench.sources.recording import record  # not before: Rerun takes its time to load

    return drawn_here(play(trial, record, frames=frames, maps=True))


def seconds(trial: RobotTrial) -> float:
    """Return the planned duration of a trial: what it costs goes by that."""
    return nominal(trial.condition, trial.settings).stimulus.seconds


def batch(plan: Plan, *, recordings: bool = False, frames: bool = False) -> Batch[RobotTrial]:
    """Return the trials of a checked plan as a batch; the options are those of `work`."""
    specs = plan.specs()
    return Batch(
        name=plan.experiment.name,
        specs=specs,
        work=partial(work, recordings=recordings, frames=frames),
        description={**describe(plan), "recordings": recordings},
        schemas=(TRIAL_SCHEMA, FRAME_SCHEMA),
        parameters=plan.changed(),
        size=seconds,
    )


def run(plan: Plan, out: Path, resources: Resources, *, recordings: bool) -> Run:
    """Run a checked plan's trials with a pool of its own.

    Parameters
    ----------
    plan
        From `plan`.
    out
        The run's folder: a new one, or one that holds a part of this run.
    resources
        Workers, or a cluster.
    recordings
        Whether to record each trial for Rerun.

    Returns
    -------
    Run
        The run as its files have it.
    """
    trials = batch(plan, recordings=recordings, frames=True)
    with resources.pool() as pool, trials.run(out, pool, resources) as folder:
        return conclude(plan, folder)


def conclude(plan: Plan, folder: RunFolder) -> Run:
    """Judge the claims of the trials in ``folder``, and write verdicts, summary and figure.

    Returns
    -------
    Run
        The run as its files have it.
    """
    rows = folder.table("trials").to_dicts()
    folder.write_json("claims.json", stored.document(_verdicts(plan, rows, folder.failures())))
    run = load(folder.folder)
    if not rows:
        return run
    from experiments.bench.report import style  # not before: workers do without matplotlib

    whole = whole_networks(run)
    folder.write_rows("summary.csv", summary_rows(whole, ("model", *CONDITION_COLUMNS), QUANTITIES, SIGNED))
    if compared := compare(whole, plan.settings.models[0].label if len(plan.experiment.models) > 1 else ""):
        folder.write_rows("comparisons.csv", compared)
    if run.excitations.height:
        folder.write_rows("excitation.csv", run.excitations.to_dicts())
    style.save(run.figure(), folder.folder / "figure")
    return run


def _verdicts(plan: Plan, rows: Sequence[Any], failures: Sequence[Failure]) -> list[Verdict]:
    """Judge each claim, for each model that it is about, or once for the models that it compares."""
    claims = [find_claim(claim, "robot") for claim in plan.experiment.claims]
    asked: list[tuple[Claim, str, float | None, Sequence[Any]]] = [
        (claim, model.label, model.threshold, [row for row in rows if row["model"] == model.label])
        for model in plan.settings.models
        for claim in claims
        if not claim.models and claim.concerns(model.channels)
    ]
    asked += [(claim, "", plan.thresholds.get(claim.spiking), rows) for claim in claims if claim.models]
    verdicts = []
    for claim, label, threshold, about in asked:
        judged = judge(claim, about, threshold)
        lost = sum(failure.model in ("", label, *claim.models) for failure in failures)
        failed = f"{lost} trial{'s' * (lost != 1)} of the run failed" if lost else ""
        verdict = Verdict.of(claim, [judged], model=label, experiment=plan.experiment.name)
        verdicts.append(dataclasses.replace(verdict, outcome=judged.noting([failed])))
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
    models = list(dict.fromkeys(row["model"] for row in rows))
    table: list[dict[str, Any]] = []
    for condition, chosen in group(rows, *CONDITION_COLUMNS).items():
        counted = [row for row in chosen if row["spikes"] is not None]
        spikes = {m: {row["trial"]: row["spikes"] for row in counted if row["model"] == m} for m in models}
        for one, other in combinations(models, 2):
            both = [trial for trial in spikes[one] if trial in spikes[other]]  # one may have failed in some
            if not both or reference not in ("", one):  # the first of the models
                continue
            first, second = ([spikes[m][trial] for trial in both] for m in (one, other))
            test = paired(first, second)
            table.append(
                {
                    **dict(zip(CONDITION_COLUMNS, condition, strict=True)), "model": one, "against": other,
                    "n": len(both), "mean_difference": (sum(first) - sum(second)) / len(both),
                    "rank_biserial": test.effect, "test": test.name, "p": test.p,
                }
            )  # fmt: skip
    for row, p in zip(table, holm([row["p"] for row in table]), strict=True):
        row["p_holm"] = p
    return table
