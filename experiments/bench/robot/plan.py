"""Plan of a run, its checks, and its description in ``run.json``."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from colias_sim import PathFollower
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig, known_arena
from colias_sim.motors import TOP_POWER, Motors
from experiments.bench.engine.pictures import Pictures
from experiments.bench.robot import scripted, surroundings
from experiments.bench.robot.experiment import (
    SCRIPTED,
    START_CM_S2,
    Condition,
    Design,
    Experiment,
    Settings,
    TrialSpec,
    trial_specs,
)
from experiments.bench.robot.scripted import STEERING_SHARE
from experiments.bench.robot.trajectory import body_cm, clearance_cm, nominal, reach_cm
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import look_up
from experiments.bench.run.settings import Parameter, applied, changed, check_counts, collect, described
from experiments.bench.store import provenance
from experiments.bench.store.description import THRESHOLDS
from experiments.bench.store.parameters import Parameters, differing
from scenes import ARENA_RADIUS_CM

FILES = ("scene.arena", "scene.wall", "scene.shell_picture")
"""Parameters that may be paths: tables and titles have the names of the files, as these may be moved."""
SHORTEST_STEADY_CM = 2.0
"""Least length of a line that must be left at constant speed: the speed is measured there."""


@dataclasses.dataclass(frozen=True, slots=True)
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

    def specs(self) -> list[TrialSpec]:
        """Every trial of the run."""
        return trial_specs(self.experiment, self.settings, self.repeats, self.seed)

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


def check(plan: Plan) -> None:
    """Raise `UsageError` for a plan that the robot, the arena or the observer's own body make impossible."""
    conditions = [condition for condition in plan.experiment.conditions() if condition.hand is None]
    for condition in conditions:
        _check_condition(condition, plan.settings)
    surroundings.check(conditions, plan.settings)


def _check_condition(condition: Condition, settings: Settings) -> None:
    label, robot = condition.label(), settings.robot
    if condition.path is not None:
        scripted.check(condition, settings)
        return
    top = STEERING_SHARE * robot.max_speed_cm_s
    if condition.speed_cm_s > top:
        raise UsageError(
            f"{label}: too fast for robot.max_speed_cm_s={robot.max_speed_cm_s:g}, of which "
            f"{STEERING_SHARE:.0%} is left beside steering: up to {top:g} cm/s"
        )
    _check_powers(condition, robot)
    try:
        route = nominal(condition, settings)
    except ValueError as error:
        raise UsageError(f"{label}: {error}") from None
    ((enter, leave),) = route.parts
    if leave - enter < SHORTEST_STEADY_CM / 100:
        start = PathFollower.run_up(condition.speed_cm_s / 100, condition.acceleration_cm_s2 / 100)
        raise UsageError(
            f"{label}: with {condition.acceleration_cm_s2:g} cm/s2 it takes {100 * start:.1f} cm to reach that "
            f"speed, and the line has {100 * route.stimulus.route.length:.1f}"
        )
    reach = reach_cm(route, body_cm(settings))
    if reach > ARENA_RADIUS_CM:
        raise UsageError(
            f"{label}: seen through {settings.camera.hfov_deg:g} degrees the stimulus reaches "
            f"{reach:.0f} cm from the centre; the arena ends at {ARENA_RADIUS_CM:g} cm"
        )
    room = clearance_cm(condition, settings, route)
    if room <= 0:
        raise UsageError(
            f"{label}: counting 3 sd of the start pose's errors the bodies come within {room:.1f} cm: "
            "the robots would touch"
        )


def _check_powers(condition: Condition, robot: RobotConfig) -> None:
    """Refuse speeds that no power gives, and those at which a wheel stands because of the dead band."""
    step, half_track = robot.power_step_cm_s, robot.track_cm / 2
    if not step:
        return
    turn = math.radians(condition.observer_turn_deg_s) * half_track
    wanted = {
        "the stimulus": (condition.speed_cm_s, condition.speed_cm_s),
        "the observer": (condition.observer_speed_cm_s - turn, condition.observer_speed_cm_s + turn),
    }
    motors = Motors(robot)
    for who, wheels in wanted.items():
        powers = motors.powers(*(speed / 100 for speed in wheels))
        problem = f"{condition.label()}: {who} would drive its wheels at powers of {powers[0]} and {powers[1]}"
        if any(abs(speed) > (TOP_POWER + 0.5) * step for speed in wheels):
            raise UsageError(f"{problem}: robot.power_step_cm_s={step:g} gives up to {TOP_POWER * step:g} cm/s")
        if any(speed and abs(power) < max(robot.dead_band, 1) for speed, power in zip(wheels, powers, strict=True)):
            raise UsageError(f"{problem}: below robot.dead_band={robot.dead_band} a wheel does not turn")


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
    return [*(model.source for model in plan.settings.models), *surroundings.files(scene)]


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
    collected = collect(assignments, values)
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
    check(whole)
    return whole


def parameters(experiment: Experiment, models: Sequence[str]) -> Iterator[Parameter]:
    """Every key that ``--set`` takes for an experiment, with its present value."""
    return described(sections(experiment, models))
