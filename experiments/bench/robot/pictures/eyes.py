"""Two eyes on the same physics: models that see a trial by a model of the robot's eye, and those that see it as set.

A model whose label ends with ``@NAME`` sees the frames of the camera preset ``NAME``. The trial is then simulated once
for each eye. A camera changes nothing in the physics, and that is checked.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from pydantic import ValidationError

from colias_sim.config import CameraConfig
from experiments.bench.robot.experiment import Settings
from experiments.bench.robot.plan import Plan
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import ConfiguredModel

MARK = "@"
TRUE = "ov7670"
"""The preset that is a model of the robot's eye."""
GEOMETRY = ("width", "height", "hfov_deg", "fps", "forward_cm", "up_cm")
"""Settings that both eyes have in common: size, field of view, clock and place."""


def through(label: str) -> str:
    """Return the camera preset that a model sees through; empty: the camera of the settings."""
    _, mark, name = label.rpartition(MARK)
    return name if mark and name in CameraConfig.presets() else ""


def camera(settings: Settings, eye: str) -> CameraConfig:
    """Return an eye's settings, with the size, field of view, clock and place of the camera as it is set."""
    if not eye:
        return settings.camera
    common = {name: getattr(settings.camera, name) for name in GEOMETRY}
    return dataclasses.replace(CameraConfig.preset(eye), **common)


def models_by_eye(models: Sequence[ConfiguredModel]) -> Mapping[str, list[ConfiguredModel]]:
    """Return the models of each eye, the eye of the first model first."""
    by_eye: dict[str, list[ConfiguredModel]] = {}
    for model in models:
        by_eye.setdefault(through(model.label), []).append(model)
    return by_eye


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
