"""What a run is to do, whether it can be done, and how ``experiment.json`` tells of it."""

from __future__ import annotations

import dataclasses
import importlib.metadata
import math
import platform
from typing import Any

from experiments.bench.declaration import Experiment, Settings, TrialSpec, trial_specs
from experiments.bench.settings import UsageError
from experiments.bench.trial import ROBOT_RADIUS_CM, reach_cm
from scenes import ARENA_RADIUS_CM

LIBRARIES = ("colias-sim", "mujoco", "numpy", "opencv-python-headless", "rerun-sdk", "scipy", "pyarrow")

STEERING_SHARE = 0.95
"""How much of a wheel's top speed a straight drive may use; the rest keeps it on its line."""


@dataclasses.dataclass(frozen=True, slots=True)
class Plan:
    """A run to do: everything that decides its numbers."""

    experiment: Experiment
    settings: Settings
    repeats: int
    seed: int

    def specs(self) -> list[TrialSpec]:
        """Every trial of the run."""
        return trial_specs(self.experiment, self.settings, self.repeats, self.seed)


def check(plan: Plan) -> None:
    """Raise `UsageError` for a plan that the robot, the arena or the observer's own body make impossible."""
    top = STEERING_SHARE * plan.settings.robot.max_speed_cm_s
    for condition in plan.experiment.design.conditions():
        said, camera = condition.label(), plan.settings.camera
        if condition.speed_cm_s > top:
            raise UsageError(
                f"{said}: too fast for robot.max_speed_cm_s={plan.settings.robot.max_speed_cm_s:g}, of which "
                f"{STEERING_SHARE:.0%} is left beside steering: up to {top:g} cm/s"
            )
        reach = reach_cm(condition, plan.settings)
        if reach > ARENA_RADIUS_CM:
            raise UsageError(
                f"{said}: seen through {camera.hfov_deg:g} degrees the crossing reaches "
                f"{reach:.0f} cm from the centre; the arena ends at {ARENA_RADIUS_CM:g} cm"
            )
        room = camera.forward_cm + condition.distance_cm - 2 * ROBOT_RADIUS_CM
        spread = 0.3 * plan.settings.pose_sd_mm + reach * math.sin(math.radians(3 * plan.settings.heading_sd_deg))
        if room < spread:
            raise UsageError(
                f"{said}: passes the observer's body at {room:.1f} cm, and the start pose's errors (3 sd) may take "
                f"{spread:.1f} cm of that: the robots would touch"
            )


def describe(plan: Plan) -> dict[str, Any]:
    """What ``experiment.json`` holds: every parameter, the seed, the versions that computed the numbers."""
    return {
        "experiment": plan.experiment,
        "repeats": plan.repeats,
        "seed": plan.seed,
        "trials": len(plan.specs()),
        "settings": plan.settings,
        "versions": {
            "python": platform.python_version(),
            **{name: importlib.metadata.version(name) for name in LIBRARIES},
        },
    }
