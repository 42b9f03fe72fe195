"""Drivers of both robots over a trial: by the stimulus's pose, or open loop by time."""

from __future__ import annotations

import numpy as np

from colias_sim import PathFollower, Simulation, WheelSpeeds
from colias_sim.path import OpenLoop, SpeedProfile
from experiments.bench.robot.experiment import Condition
from experiments.bench.robot.trajectory import Course

AT_REST_M_S = 0.002


class Drive:
    """Commands both robots over a trial, and says when it is over."""

    def __init__(self, sim: Simulation, route: Course, condition: Condition) -> None:
        self._sim, self._route = sim, route
        self._stimulus, observer = sim.robots["stimulus"], sim.robots["observer"]
        profile = SpeedProfile(route.line.length, route.speed, route.acceleration, route.stop, route.wait)
        self._by_time = OpenLoop(self._stimulus, profile) if self._stimulus.config.open_loop else None
        self._ends = self._stimulus.begins() + self._by_time.seconds + route.rest if self._by_time else 0.0
        self._follower = PathFollower(
            self._stimulus, route.line, route.speed, acceleration=route.acceleration, stop=route.stop
        )
        speed, turn = condition.observer_speed_cm_s / 100, np.radians(condition.observer_turn_deg_s)
        if speed or turn:
            observer.drive(observer.wheels_for(speed, float(turn)))
        self._arrived: float | None = None
        self.over = False

    def __call__(self, dt: float) -> None:
        """Command the wheels for the next ``dt`` seconds."""
        if self._by_time is not None:
            self._by_time.drive(dt)
            return
        still = self._sim.data.time < self._route.wait - 1e-9
        self._stimulus.drive(WheelSpeeds(0.0, 0.0) if still else self._follower.wheels(dt))

    def look(self) -> None:
        """Once a frame: has the stimulus passed the end, or stopped there and rested? Is its time over?"""
        along, now = self._route.line.along(self._stimulus.pose), self._sim.data.time
        if self._by_time is not None:
            self.over = now >= self._ends - 1e-9
        elif not self._route.stop:
            self.over = along >= self._route.leave
        elif self._arrived is None:
            at_rest = float(np.hypot(*self._stimulus.velocity)) < AT_REST_M_S
            self._arrived = now if at_rest and along > self._route.leave else None
        else:
            self.over = now >= self._arrived + self._route.rest - 1e-9
