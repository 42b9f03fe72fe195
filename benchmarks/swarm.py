"""Cost of a robot that sees and responds, in swarms of 2 to 30."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from rich.table import Table

from benchmarks.timing import interleaved
from colias_sim.envs.geometry import random_poses
from colias_sim.envs.swarm import Swarm, SwarmOptions

FRAMES, ROUNDS = 20, 5
COUNTS = 2, 10, 20, 30
EYES = "default", "ov7670"
ELSEWHERE = "gym-pybullet-drones: five eyes at a fifth of real time on a CPU, by its authors; not measured here"


def swarm(count: int, eye: str) -> Swarm:
    """Robots with shells, each with its eye and the DSNN."""
    made = Swarm(SwarmOptions(robots=count, camera=eye, observation="neural", model="dsnn"))  # type: ignore[arg-type]
    rng = np.random.default_rng(0)
    made.reset(dict(zip(made.agents, random_poses(rng, count), strict=True)), rng, 0)
    return made


def played(made: Swarm) -> Callable[[], int]:
    """Play some frames, in which all robots drive in arcs."""

    def play() -> int:
        for _ in range(FRAMES):
            made.play({name: lambda seen, body: (0.1, 0.08) for name in made.agents})
        return FRAMES

    return play


def table() -> Table:
    """Milliseconds a frame and a robot, and times real time on this core."""
    swarms = {(count, eye): swarm(count, eye) for eye in EYES for count in COUNTS}
    times = interleaved({f"{count} {eye}": played(made) for (count, eye), made in swarms.items()}, ROUNDS)
    result = Table(title=f"Robots with shells, camera and DSNN ({ELSEWHERE})")
    for name in ("robots, camera", "ms a frame", "ms a robot", "times real time", "times the default camera"):
        result.add_column(name, justify="right")
    for count, eye in swarms:
        us = float(times[f"{count} {eye}"].min())
        usual = float(times[f"{count} default"].min())
        cost = f"{us / 1e3:.1f}", f"{us / 1e3 / count:.2f}", f"{1e6 / 30 / us:.2f}", f"{us / usual:.2f}"
        result.add_row(f"{count}, {eye}", *cost)
        swarms[count, eye].sim.close()
    return result
