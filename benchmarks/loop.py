"""The closed loop against its floor and where its time goes."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from rich.table import Table

from benchmarks.timing import interleaved, ratio
from colias_sim import CameraConfig, Frame, PathFollower, Pose, Route, Simulation
from dsnn import DSNN, DSNNParams

FRAMES = 60


def loop_table() -> Table:
    """A crossing at 6 cm/s: physics and render, the floor; with the network, the closed loop; a trial has noise too."""
    quiet = CameraConfig(shot_noise=0.0, read_noise=0.0)
    with (
        Simulation(camera=quiet) as without, Simulation() as noisy, Simulation(seeing=False) as blind,
        Simulation(camera=quiet, truth=True) as truthful,
    ):  # fmt: skip
        model, rng = DSNN((72, 99), DSNNParams.robot()), np.random.default_rng(0)

        def crossing(sim: Simulation, do: Callable[[Frame], object]) -> int:
            robot, line = sim.robots["stimulus"], Route.line(Pose(0.1, 0.06, -math.pi / 2), 0.2, 0.06)
            follower = PathFollower(robot, line)
            sim.reset({"stimulus": line.start}, rng)
            for _ in range(FRAMES):
                if sim is blind:
                    sim.advance(lambda dt: robot.drive(follower.wheels(dt)))
                else:
                    do(sim.step(rng, lambda dt: robot.drive(follower.wheels(dt))))
            return FRAMES

        def step(frame: Frame) -> object:
            return model.step(frame.luma)

        times = interleaved(
            {
                "physics": lambda: crossing(blind, step),
                "floor": lambda: crossing(without, lambda frame: None),
                "loop": lambda: crossing(without, step),
                "noise": lambda: crossing(noisy, lambda frame: None),
                "trial": lambda: crossing(noisy, step),
                "truth": lambda: crossing(truthful, lambda frame: truthful.truth()),
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
        us = times[name].min()
        table.add_row(label, f"{us:.0f}", f"{ratio(times[name], times['floor']):.2f}", f"{1e6 / 30 / us:.1f}")
    for name, us in {
        "physics": times["physics"].min(),
        "render": times["floor"].min() - times["physics"].min(),
        "network": times["loop"].min() - times["floor"].min(),
        "camera noise": times["noise"].min() - times["floor"].min(),
        "truth (flow, depth, surface)": times["truth"].min() - times["floor"].min(),
    }.items():
        table.add_row(f"  {name}", f"{us:.0f}", f"{us / times['floor'].min():.2f}", "")
    return table
