"""Cost of a robot that sees and responds, in swarms of 2 to 30."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from rich.table import Table

from benchmarks.timing import interleaved
from colias_sim.envs.geometry import random_poses
from colias_sim.envs.options import checked
from colias_sim.envs.swarm import Swarm, SwarmOptions

FRAMES, ROUNDS = 20, 5
COUNTS, EYES = (2, 10, 20, 30), ("default", "ov7670")
ELSEWHERE = "gym-pybullet-drones: five eyes at a fifth of real time on a CPU, by its authors; not measured here"


def swarm(count: int, eye: str) -> Callable[[], int]:
    """Return what plays some frames of robots with shells, each with its eye and the DSNN, that all drive in arcs."""
    options = {"robots": count, "camera": eye, "observation": "neural", "model": "dsnn"}
    made, rng = Swarm(checked(SwarmOptions, options)), np.random.default_rng(0)
    made.reset(dict(zip(made.agents, random_poses(rng, count), strict=True)), rng, 0)

    def play() -> int:
        for _ in range(FRAMES):
            for agent in made.agents.values():
                agent.command((0.1, 0.08))
            made.advance(made.agents)
        return FRAMES

    return play


def table() -> Table:
    """Milliseconds a frame and a robot, and times real time on this core."""
    times = interleaved({f"{count}, {eye}": swarm(count, eye) for eye in EYES for count in COUNTS}, ROUNDS)
    result = Table(title=f"Robots with shells, camera and DSNN ({ELSEWHERE})")
    for name in ("robots, camera", "ms a frame", "ms a robot", "times real time", "times the default camera"):
        result.add_column(name, justify="right")
    for name, samples in times.items():
        count = name.partition(",")[0]
        us, usual = float(samples.min()), float(times[f"{count}, {EYES[0]}"].min())
        result.add_row(
            name, f"{us / 1e3:.1f}", f"{us / 1e3 / int(count):.2f}", f"{1e6 / 30 / us:.2f}", f"{us / usual:.2f}"
        )
    return result
