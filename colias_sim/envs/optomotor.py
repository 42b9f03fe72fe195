"""Optomotor: hold the heading against a turning drum, or under a push."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from colias_sim.config import RobotConfig
from colias_sim.envs.base import ColiasEnv
from colias_sim.envs.geometry import random_poses
from colias_sim.envs.measures import ANY, SIZE, Values, optomotor_gain, rms
from colias_sim.envs.options import MOST_ROBOTS, STRICT, Arena, EnvOptions
from colias_sim.envs.scripted import Driver
from colias_sim.envs.world import OBSERVER, parked_robots
from colias_sim.pose import Pose
from dsnn.field_docs import unit, with_field_docs

HARDEST_PUSH_DEG_S = 180.0
_PUSHED_DEG_S = (0.0, 58.0, 93.0, 130.0, 169.0, 207.0)
_PUSH_N_M = (0.0, 8.25e-4, 1.237e-3, 1.649e-3, 2.061e-3, 2.474e-3)
"""Measured: turn rates (degrees/s), and the torques (N m) that turn the default robot at these against resting wheels.

The motors yield to the torque, and the tyres creep. From 4e-3 N m on the tyres slip too.
"""


def pushes(robot: RobotConfig) -> tuple[Values, Values]:
    """Compute turn rates (degrees/s) of a robot, and the torques (N m) that turn it at these rates.

    Its servos yield by torque over gain, through wheels and track. Its tyres creep by torque over weight and track.
    """
    usual = RobotConfig()
    weight, narrow = robot.mass_g * robot.track_cm / (usual.mass_g * usual.track_cm), usual.track_cm / robot.track_cm
    soft = usual.motor_gain / robot.motor_gain * (robot.wheel_radius_cm / usual.wheel_radius_cm) ** 2
    torques = np.array(_PUSH_N_M)
    yields = math.degrees(2.0) * (usual.wheel_radius_cm / usual.track_cm) ** 2 / usual.motor_gain * torques
    return narrow * np.array(_PUSHED_DEG_S) + (weight * soft * narrow**2 - narrow) * yields, weight * torques


@with_field_docs
@dataclass(frozen=True, kw_only=True, config=STRICT)
class OptomotorOptions(EnvOptions):
    """Keyword arguments of `Optomotor`."""

    robots: int = Field(default=0, ge=0, le=MOST_ROBOTS)
    """Other robots, parked."""
    arena: Arena = "drum"
    """An arena of scenes, or your own file."""
    disturbance: Literal["drum", "push"] = "drum"
    """Disturbance of the robot: the wall turns (drum), or a torque turns the robot (push)."""
    slowest_deg_s: Annotated[float, unit("degrees/s")] = Field(default=20.0, ge=0.0, le=360.0)
    """Least rate of the disturbance."""
    fastest_deg_s: Annotated[float, unit("degrees/s")] = Field(default=90.0, gt=0.0, le=360.0)
    """Greatest rate of the disturbance; of a push at most 180, or less for stiff motors, as tyres slip."""

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.slowest_deg_s > self.fastest_deg_s:
            raise ValueError(
                f"slowest_deg_s must be at most {self.fastest_deg_s}, fastest_deg_s, got {self.slowest_deg_s}"
            )
        if self.disturbance == "push" and self.fastest_deg_s > HARDEST_PUSH_DEG_S:
            raise ValueError(f"a push needs a fastest_deg_s up to {HARDEST_PUSH_DEG_S:g}, got {self.fastest_deg_s}")
        return self


class Optomotor(ColiasEnv[OptomotorOptions]):
    """
    ## Description

    Hold the heading against a disturbance that turns the view: a striped drum that turns about the robot
    (`disturbance="drum"`), or a torque that turns the robot itself (`"push"`). Rate and direction are drawn again every
    2 to 4 s. A robot that turns with the drum, or resists the push, sees nothing move. The task is to keep the turn
    rate *relative to the wall* at 0.

    ## Rewards

    - `hold`: 1 - |slip| / `fastest_deg_s`, at least -1; the slip is the turn rate relative to the wall.
    - `effort`: -0.05 times the mean square of the two wheels.
    - `touch`: -10 when the hull touches anything.

    ## Info

    The optomotor gain of a stretch is 1 - sum(slip_deg_s * sign(drift_deg_s)) / sum(|drift_deg_s|): 0 for a robot that
    does nothing, 1 for one whose view never turns. It is a signed mean: a robot that swings about the drum's rate may
    have a gain of 1 too. The root-mean-square slip distinguishes the two.

    ## Starting State

    The observer stands in the arena's middle. The other robots are parked at random places.

    ## Episode End

    Terminated when the observer touches anything; truncated after 450 steps (15 s, times `frame_skip`).

    ## Arguments

    `help(env.unwrapped.options)` lists them. What all envs share, such as spaces and `info`: `help(colias_sim.envs)`.

    ## Version History

    - v0: first release.
    """

    options_type: ClassVar[type[EnvOptions]] = OptomotorOptions
    max_episode_steps = 450
    summary = "hold the heading against a turning drum or a push"
    baselines = ("random-walk", "straight", "oracle-heading")
    columns: ClassVar = {"optomotor_gain": ANY, "rms_slip_deg_s": SIZE}
    measures: ClassVar = {"optomotor gain": "optomotor_gain", "RMS slip (deg/s)": "rms_slip_deg_s"}
    note = (
        "Gain: 0 for a robot that does nothing, 1 for one whose view never turns. It is a signed mean, in which swings"
        " to either side cancel; in the RMS slip they do not."
    )

    def _others(self) -> Mapping[str, str]:
        return parked_robots(self.options.robots)

    def _begin(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        places = {OBSERVER: Pose(0.0, 0.0, float(rng.uniform(-math.pi, math.pi)))}
        others = random_poses(rng, self.options.robots, places.values(), obstacles=self._sim.obstacles)
        places |= dict(zip(self._others(), others, strict=True))
        self._rate = self._left = 0.0
        return places, {}

    def _disturb(self, dt: float) -> float:
        self._left -= dt
        if self._left <= 0.0:
            options, rng = self.options, self.np_random
            self._left = float(rng.uniform(2.0, 4.0))
            rate = math.radians(float(rng.uniform(options.slowest_deg_s, options.fastest_deg_s)))
            self._rate = rate if rng.random() < 0.5 else -rate
        if self.options.disturbance == "push":
            rates, torques = pushes(self._body)
            torque = float(np.interp(abs(math.degrees(self._rate)), rates, torques))
            self._observer.twist(math.copysign(torque, self._rate))
            return math.copysign(min(abs(self._rate), math.radians(rates[-1])), self._rate)
        self._sim.turn_wall(self._sim.wall_turn + self._rate * dt)
        return -self._rate

    def _wall_rate(self) -> float:
        return self._rate if self.options.disturbance == "drum" else 0.0

    def _reward(self) -> dict[str, float]:
        slip = abs(self.slip) / math.radians(self.options.fastest_deg_s)
        return {"hold": max(1.0 - slip, -1.0), "effort": self._effort()}

    def measured(self, infos: Mapping[str, Values]) -> dict[str, float | None]:
        """Compute the columns of an episode."""
        slip = infos["slip_deg_s"]
        return {"optomotor_gain": optomotor_gain(slip, infos["drift_deg_s"]), "rms_slip_deg_s": rms(slip)}
