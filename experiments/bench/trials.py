"""Trials with the robot: plan an experiment's trials, describe the run, and play them into its folder."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from colias_sim.config import CameraConfig, RobotConfig, SceneConfig, known_arena
from experiments.bench.engine.pictures import Pictures
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import look_up
from experiments.bench.run.settings import Parameter, applied, changed, check_counts, collect, described
from experiments.bench.run.settings import assignments as of_mapping
from experiments.bench.sources import room
from experiments.bench.sources.conditions import SCRIPTED, START_CM_S2
from experiments.bench.sources.course import nominal
from experiments.bench.sources.experiment import Design, Experiment, Settings
from experiments.bench.sources.robot import MARK, TRUE, RobotTrial, camera, trials_of
from experiments.bench.store import provenance
from experiments.bench.store.description import THRESHOLDS
from experiments.bench.store.parameters import Parameters, differing

if TYPE_CHECKING:
    pass

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
    """The wall of the arena has one of them in each replicate; a run is replicate 0."""

    def replicate(self, number: int) -> Plan:
        """Return the plan of another replicate: its seed, and the picture on its wall."""
        return dataclasses.replace(self, seed=self.seed + number, settings=self._walled(number))

    def _walled(self, replicate: int) -> Settings:
        if self.pictures is None:
            return self.settings
        scene = dataclasses.replace(self.settings.scene, wall=self.pictures.of(replicate))
        return dataclasses.replace(self.settings, scene=scene)

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

    def frames(self) -> int:
        """About how many frames the trials have, as planned."""
        conditions = self.experiment.conditions()
        seconds = sum(nominal(condition, self.settings).seconds for condition in conditions)
        return round(self.repeats * seconds * self.settings.camera.fps)


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
        **({"pictures": plan.pictures.described()} if plan.pictures else {}),
        **({"changed": changed_ones} if changed_ones else {}),
        THRESHOLDS: {model.label: model.thresholds for model in plan.settings.models},
        **provenance.of(sources(plan), plan.experiment),
    }


def sources(plan: Plan) -> list[str]:
    """Return the models of a plan, and the files of its scene: what may be the user's own."""
    scene = plan.settings.scene
    if plan.pictures:  # which are noted apart
        scene = dataclasses.replace(scene, wall="")
    return [*(model.source for model in plan.settings.models), *room.files(scene)]


def _paths(plan: Plan) -> dict[str, Any]:
    """Return the paths of conditions of one's own, by the condition's label: rows have no column for them."""
    return {
        condition.label(): {name: getattr(condition, name) for name in SCRIPTED if name != "hand" or condition.hand}
        for condition in plan.experiment.conditions()
        if condition.path is not None or condition.hand is not None
    }


def notes(plan: Plan) -> list[str]:
    """Return what a person should know of parameters that are set but act where nothing of it is seen."""
    crossings = [c for c in plan.experiment.conditions() if c.motion == "translation"]
    return [
        f"acceleration_cm_s2={value:g} of a crossing acts outside the view: it starts there, and comes in at its "
        "speed. For one that accelerates in view give it a path (Condition.along)"
        for value in sorted({c.acceleration_cm_s2 for c in crossings} - {START_CM_S2})
    ]


def sections(experiment: Experiment | None, models: Sequence[str]) -> dict[str, Any]:
    """Section name -> its default value: each model under its family's name, the apparatus, then the design.

    Models of one family with the same parameters (``dsnn``, ``dsnn-reference``) share a section: the first one's
    defaults.
    """
    models_shown = look_up(models)
    applied(models_shown, {})  # what is asked of them has to be legal too
    table: dict[str, Any] = {}
    for model in models_shown:
        table.setdefault(model.section, model.chosen.network)
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
    whole = whole.replicate(0)
    option = f"{experiment.name}: repeats" if repeats is None else "--repeats"
    check_counts(seed, count, option, len(whole.experiment.conditions()))
    room.check(whole.experiment.conditions(), whole.settings)
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
        common = f"camera.height={settings.camera.height}, camera.fps={settings.camera.fps:g}"
        reason = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise UsageError(
            f"--eyes both: both eyes have {common}, which the true one ({TRUE}) cannot have: {reason}"
        ) from None
    if eye == settings.camera:
        raise UsageError(f"--eyes both: the camera is that of preset {TRUE} already; leave out --set camera.*")
    more = tuple(dataclasses.replace(model, label=f"{model.label}{MARK}{TRUE}") for model in settings.models)
    return dataclasses.replace(plan, settings=dataclasses.replace(settings, models=(*settings.models, *more)))


def parameters(experiment: Experiment, models: Sequence[str]) -> Iterator[Parameter]:
    """Every key that ``--set`` takes for an experiment, with its present value."""
    return described(sections(experiment, models))
