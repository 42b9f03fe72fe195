"""What a run is to do, whether it can be done, and how ``experiment.json`` tells of it."""

from __future__ import annotations

import dataclasses
from typing import Any

from experiments.bench import provenance
from experiments.bench.courses import clearance_cm, nominal, reach_cm
from experiments.bench.declaration import Condition, Experiment, Settings, TrialSpec, trial_specs
from experiments.bench.files import UsageError, is_file
from scenes import ARENA_RADIUS_CM

STEERING_SHARE = 0.95
"""How much of a wheel's top speed a straight drive may use; the rest keeps it on its line."""


SHORTEST_STEADY_CM = 2.0
"""Of a line, what must be left at constant speed: the speed is measured there."""


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

    def frames(self) -> int:
        """About how many frames the trials have, as planned."""
        conditions = self.experiment.conditions()
        seconds = sum(nominal(condition, self.settings).seconds for condition in conditions)
        return round(self.repeats * seconds * self.settings.camera.fps)


def check(plan: Plan) -> None:
    """Raise `UsageError` for a plan that the robot, the arena or the observer's own body make impossible."""
    for condition in plan.experiment.conditions():
        _check_condition(condition, plan.settings)


def _check_condition(condition: Condition, settings: Settings) -> None:
    said, robot = condition.label(), settings.robot
    top = STEERING_SHARE * robot.max_speed_cm_s
    if condition.speed_cm_s > top:
        raise UsageError(
            f"{said}: too fast for robot.max_speed_cm_s={robot.max_speed_cm_s:g}, of which "
            f"{STEERING_SHARE:.0%} is left beside steering: up to {top:g} cm/s"
        )
    try:
        route = nominal(condition, settings)
    except ValueError as error:
        raise UsageError(f"{said}: {error}") from None
    if route.leave - route.enter < SHORTEST_STEADY_CM / 100:
        raise UsageError(
            f"{said}: with {condition.acceleration_cm_s2:g} cm/s2 it takes {100 * route.enter:.1f} cm to reach that "
            f"speed, and the line has {100 * route.line.length:.1f}"
        )
    reach = reach_cm(route)
    if reach > ARENA_RADIUS_CM:
        raise UsageError(
            f"{said}: seen through {settings.camera.hfov_deg:g} degrees the stimulus reaches "
            f"{reach:.0f} cm from the centre; the arena ends at {ARENA_RADIUS_CM:g} cm"
        )
    room = clearance_cm(condition, settings, route)
    if room <= 0:
        raise UsageError(
            f"{said}: counting 3 sd of the start pose's errors the bodies come within {room:.1f} cm: "
            "the robots would touch"
        )


def describe(plan: Plan) -> dict[str, Any]:
    """What ``experiment.json`` holds: every parameter, the seed, and what computes it (see `provenance`)."""
    return {
        "experiment": plan.experiment,
        "repeats": plan.repeats,
        "seed": plan.seed,
        "trials": len(plan.specs()),
        "settings": plan.settings,
        **provenance.of([model.source for model in plan.settings.models if is_file(model.source)], plan.experiment),
    }
