"""The closed loop against its floor and where its time goes."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from rich.table import Table

from benchmarks.timing import interleaved
from colias_sim import CameraConfig, Frame, PathFollower, Pose, Route, Simulation
from dsnn import DSNN, DSNNParams

FRAMES = 60


def loop_table() -> Table:
    """A crossing at 6 cm/s: physics and render, the floor; with the network, the closed loop; a trial has noise too."""
    quiet = CameraConfig(shot_noise=0.0, read_noise=0.0)
    with Simulation(camera=quiet) as without, Simulation() as noisy:
        model, rng = DSNN((72, 99), DSNNParams.robot()), np.random.default_rng(0)

        def crossing(sim: Simulation, do: Callable[[Frame], object]) -> int:
            robot, line = sim.robots["stimulus"], Route.line(Pose(0.1, 0.06, -math.pi / 2), 0.2, 0.06)
            follower = PathFollower(robot, line)
            sim.reset({"stimulus": line.start}, rng)
            for _ in range(FRAMES):
                do(sim.step(rng, lambda dt: robot.drive(follower.wheels(dt))))
            return FRAMES

        def step(frame: Frame) -> object:
            return model.step(frame.luma)

        split = _Split(without)
        times = interleaved(
            {
                "floor": lambda: crossing(without, lambda frame: None),
                "split": lambda: split.of(lambda: crossing(without, lambda frame: None)),
                "loop": lambda: crossing(without, step),
                "noise": lambda: crossing(noisy, lambda frame: None),
                "trial": lambda: crossing(noisy, step),
            }
        )
    table = Table(title="Closed loop at 99x72, microseconds a frame (best of 15 rounds; ratios: median of rounds)")
    for name in ("part", "us", "times the floor", "times real time"):
        table.add_column(name, justify="left" if name == "part" else "right")
    for name, label in (
        ("floor", "floor: physics + render"),
        ("loop", "closed loop: floor + network"),
        ("trial", "a trial's: + camera noise"),
    ):
        us = times.us(name)
        table.add_row(label, f"{us:.0f}", f"{times.ratio(name, 'floor'):.2f}", f"{1e6 / 30 / us:.1f}")
    render = split.share * times.us("floor")
    for name, us in {
        "physics": times.us("floor") - render,
        "render": render,
        "network": times.us("loop") - times.us("floor"),
        "camera noise": times.us("noise") - times.us("floor"),
    }.items():
        table.add_row(f"  {name}", f"{us:.0f}", f"{us / times.us('floor'):.2f}", "")
    return table


class _Split:
    """Share of a crossing that its renders take, in the best of the rounds it is asked ``of``."""

    def __init__(self, sim: Simulation) -> None:
        self._sim, self._rounds = sim, list[tuple[float, float]]()

    @property
    def share(self) -> float:
        """The renders' share of the shortest round."""
        whole, renders = min(self._rounds)
        return renders / whole

    def of(self, work: Callable[[], int]) -> int:
        """Do ``work`` with a clock on every render, develop and read-back included."""
        camera, spent = self._sim.camera, 0.0
        plain = camera.expose, camera.develop

        def clocked(call: Callable[..., Any]) -> Callable[..., Any]:
            def timed(*arguments: Any) -> Any:
                nonlocal spent
                began = time.perf_counter()
                result = call(*arguments)
                spent += time.perf_counter() - began
                return result

            return timed

        camera.expose, camera.develop = map(clocked, plain)  # type: ignore[method-assign]
        began = time.perf_counter()
        try:
            return work()
        finally:
            self._rounds.append((time.perf_counter() - began, spent))
            camera.expose, camera.develop = plain  # type: ignore[method-assign]
