"""The settings of trials with the robot: models, robot, camera, scene and design, from ``--set`` and the experiment."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from colias_sim.config import CameraConfig, ProcessorConfig, RobotConfig, SceneConfig, known_arena
from experiments.base.errors import UsageError, as_usage_error
from experiments.declare.experiment import Design, Experiment
from experiments.settings.models import look_up
from experiments.settings.parameters import Parameters, differing
from experiments.settings.pictures import Pictures
from experiments.settings.settings import Settings, applied, changed, collect
from experiments.settings.settings import assignments as of_mapping

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
    table["processor"] = ProcessorConfig()
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
    robot, camera, scene, processor, design = (
        changed(section, values[section], collected.get(section, {}))
        for section in ("robot", "camera", "scene", "processor", "experiment")
    )
    chosen = tuple(dataclasses.replace(model, processor=processor) for model in chosen)
    if lacking := [name for name in ("pose_sd_mm", "heading_sd_deg") if not hasattr(design, name)]:
        where = f"{experiment.file or experiment.name}: the design {type(design).__name__}"
        raise UsageError(f"{where} must have {' and '.join(lacking)}, spreads of the start from 0 to 100")
    settings = Settings(chosen, robot, camera, scene, design.pose_sd_mm, design.heading_sd_deg)
    with as_usage_error("--set: "):
        return dataclasses.replace(experiment, design=design), settings
