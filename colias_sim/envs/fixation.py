"""Fixation: keep a moving robot in the middle of the view."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
import numpy.typing as npt
from pydantic import Field, model_validator
from pydantic.dataclasses import dataclass

from colias_sim.envs.base import TargetEnv
from colias_sim.envs.geometry import HULL_RADIUS, random_poses
from colias_sim.envs.measures import SIZE, Values, rms
from colias_sim.envs.options import MOST_ROBOTS, STRICT, EnvOptions
from colias_sim.envs.scripted import Driver, Orbit
from colias_sim.envs.world import OBSERVER, TARGET, parked_robots
from colias_sim.pose import Pose
from dsnn.field_docs import unit, with_field_docs

if TYPE_CHECKING:
    from colias_sim.obstacles import Obstacle


@with_field_docs
@dataclass(frozen=True, kw_only=True, config=STRICT)
class FixationOptions(EnvOptions):
    """Keyword arguments of `Fixation`."""

    robots: int = Field(default=1, ge=1, le=MOST_ROBOTS)
    """Other robots: the target, the rest parked."""
    follow: bool = False
    """Whether the observer may drive; otherwise it only turns on the spot."""
    orbit_cm: Annotated[float, unit("cm")] = Field(default=15.0, ge=8.0, le=35.0)
    """Distance from the observer's start to the target's path."""
    slowest_deg_s: Annotated[float, unit("degrees/s")] = Field(default=10.0, ge=0.0, le=120.0)
    """Least angular rate of the target."""
    fastest_deg_s: Annotated[float, unit("degrees/s")] = Field(default=35.0, ge=0.0, le=120.0)
    """Greatest angular rate of the target."""

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.slowest_deg_s > self.fastest_deg_s:
            raise ValueError(
                f"slowest_deg_s must be at most {self.fastest_deg_s}, fastest_deg_s, got {self.slowest_deg_s}"
            )
        return self


class Fixation(TargetEnv[FixationOptions]):
    """
    ## Description

    Keep a moving black Colias in the middle of the view. The target circles to and fro about the observer's start:
    every 1 to 4 s it draws a new angular rate and direction. The observer turns on the spot: only the difference of
    the two wheels of an action counts. With `follow=True` it may drive about.

    ## Rewards

    - `centre`: 1 - |bearing| / half the view, at least -1; the bearing is the target's angle off the optical axis.
    - `effort`: -0.05 times the mean square of the two wheels.
    - `touch`: -10 when the hull touches anything.

    ## Info

    This env adds `bearing_deg` (right positive) and `in_view` (whether that is within half the view).

    ## Starting State

    The observer stands in the arena's middle, the target `orbit_cm` away and at most 20 degrees off the axis, as seen
    from the robot's middle; from the lens, which is ahead of it, a little more. Robots beyond the first are parked
    outside of its path.

    ## Episode End

    Terminated when the observer touches anything; truncated after 600 steps (20 s, times `frame_skip`).

    ## Arguments

    `help(env.unwrapped.options)` lists them. What all envs share, such as spaces and `info`: `help(colias_sim.envs)`.

    ## Version History

    - v0: first release.
    """

    options_type: ClassVar[type[EnvOptions]] = FixationOptions
    max_episode_steps = 600
    summary = "keep a moving robot in the middle of the view"
    baselines = ("random-walk", "straight", "oracle-target")
    columns: ClassVar = {**TargetEnv.columns, "rms_off_axis_deg": SIZE}
    measures: ClassVar = {
        "time on target": "in_view", "off axis (deg)": "off_axis_deg", "RMS off axis (deg)": "rms_off_axis_deg"
    }  # fmt: skip
    note = "Time on target: the share of frames with the target in the camera's horizontal view."

    def __init__(self, **arguments: Any) -> None:
        super().__init__(**arguments)
        if obstacle := next((o for o in self._sim.obstacles if self._stands_in_the_way(o)), None):
            self.close()
            raise ValueError(
                f"orbit_cm={self.options.orbit_cm:g}: the obstacle {obstacle.name} of the arena {self.options.arena}"
                " stands in the target's way: set another orbit_cm, or move the obstacle"
            )

    def _stands_in_the_way(self, obstacle: Obstacle) -> bool:
        return min(obstacle.nearest(pose.x, pose.y)[0] for pose in self._path()) < HULL_RADIUS

    def _path(self) -> list[Pose]:
        """Sample poses on the target's orbit."""
        far = self.options.orbit_cm / 100
        return [Pose(far * math.cos(a), far * math.sin(a), 0.0) for a in np.linspace(0, 2 * math.pi, 48)]

    def _begin(self, rng: np.random.Generator) -> tuple[Mapping[str, Pose], Mapping[str, Driver]]:
        options = self.options
        heading, off = float(rng.uniform(-math.pi, math.pi)), math.radians(float(rng.uniform(-20.0, 20.0)))
        far, turn = options.orbit_cm / 100, heading + off
        start = Pose(far * math.cos(turn), far * math.sin(turn), turn + math.pi / 2)
        places: dict[str, Pose] = {OBSERVER: Pose(0.0, 0.0, heading), TARGET: start}
        # The parked robots keep clear of the whole path, and of the observer in its middle.
        taken, obstacles = [*self._path(), places[OBSERVER]], self._sim.obstacles
        others = random_poses(rng, options.robots - 1, taken, apart=0.05, clear=0.055, obstacles=obstacles)
        places |= zip(parked_robots(options.robots - 1), others, strict=True)
        slowest, fastest = math.radians(options.slowest_deg_s), math.radians(options.fastest_deg_s)
        return places, {TARGET: Orbit(self._sim.robots[TARGET], (0.0, 0.0), far, slowest, fastest, rng)}

    def _steer(self, wheels: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        if self.options.follow:
            return wheels
        half = (wheels[1] - wheels[0]) / 2
        return np.array([-half, half], np.float32)

    def _reward(self) -> dict[str, float]:
        return {"centre": self._centre(), "effort": self._effort()}

    def measured(self, infos: Mapping[str, Values]) -> dict[str, float | None]:
        """Compute the columns of an episode."""
        return {**super().measured(infos), "rms_off_axis_deg": rms(infos["bearing_deg"])}
