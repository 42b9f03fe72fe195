"""Drivers of a trial's robots: each by its own pose, or open loop by time."""

from __future__ import annotations

import math

from colias_sim import OpenLoop, PathFollower, Robot, Simulation
from experiments.bench.sources.course import Course, Script

ASTRAY_M = 0.01
"""Distance from its path at which a robot that is steered along it has met an obstacle."""


class AstrayError(RuntimeError):
    """A robot that is steered along a path is nowhere near it."""


class Drive:
    """Commands all robots over a trial, and says when it is over."""

    def __init__(self, sim: Simulation, route: Course) -> None:
        self._sim = sim
        stimulus = sim.robots["stimulus"]
        self._stimulus = _driver(stimulus, route.stimulus)
        self._others = {
            name: (sim.robots[name], _driver(sim.robots[name], script))
            for name, script in route.others.items()
            if any(stretch.moves or stretch.rate for stretch in script.route.stretches)
        }
        by_time = self._stimulus if isinstance(self._stimulus, OpenLoop) else None
        self._ends = stimulus.begins() + by_time.seconds if by_time else None
        self.over = False

    def __call__(self, dt: float) -> None:
        """Command the wheels for the next ``dt`` seconds."""
        _command(self._sim.robots["stimulus"], self._stimulus, dt)
        for robot, driver in self._others.values():
            _command(robot, driver, dt)

    def look(self) -> None:
        """Note once a frame whether the trial is over: the stimulus passed the end or rested there, or its time is up.

        Raises `AstrayError` where another robot is far off its path.
        """
        if isinstance(self._stimulus, PathFollower):
            self._stimulus.look()
            self.over = self._stimulus.over
        elif self._ends is not None:
            self.over = float(self._sim.data.time) >= self._ends - 1e-9
        for name, (_, driver) in self._others.items():
            if isinstance(driver, PathFollower):
                driver.look()
                if abs(driver.offset) > ASTRAY_M:
                    raise AstrayError(f"{name} is {100 * abs(driver.offset):.1f} cm off its path: it met another robot")


def _driver(robot: Robot, script: Script) -> PathFollower | OpenLoop:
    if robot.config.open_loop or math.isinf(script.acceleration):
        return OpenLoop(robot, script.schedule())
    return PathFollower(robot, script.route, acceleration=script.acceleration)


def _command(robot: Robot, driver: PathFollower | OpenLoop, dt: float) -> None:
    if isinstance(driver, OpenLoop):
        driver.drive(dt)
    else:
        robot.drive(driver.wheels(dt))
