"""Memory and files left behind by making, using and closing an env over and over; ``python -m benchmarks.leaks`` runs
it alone.
"""

from __future__ import annotations

import gc
import os
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import gymnasium as gym
from rich.console import Console
from rich.table import Table

ENV = "colias_sim:colias_sim/Fixation-v0"
MAKERS: Mapping[str, tuple[Callable[[], Any], tuple[int, int, int]]] = {
    "one env": (lambda: gym.make(ENV, observation="both"), (100, 500, 1000)),
    "two, in this process": (lambda: gym.make_vec(ENV, num_envs=2, workers=0), (20, 100, 200)),
    "two, in processes": (lambda: gym.make_vec(ENV, num_envs=2), (10, 20, 40)),
}
"""Commands that make an env, and numbers of cycles after which to look."""


def table() -> Table:
    """MB of resident memory, open files and threads after so many cycles of make, reset, step, close; flat is right."""
    result = Table(title="After cycles of make, reset, step and close: resident MB, open files, threads")
    for name in ("env", "cycles", "first", "middle", "last", "MB from first to last"):
        result.add_column(name, justify="left" if name in ("env", "cycles") else "right")
    for name, (make, marks) in MAKERS.items():
        seen = [state for cycle in range(1, marks[-1] + 1) if (state := _cycle(make, look=cycle in marks))]
        states = [f"{mb:.1f}, {files}, {threads}" for mb, files, threads in seen]
        result.add_row(name, ", ".join(map(str, marks)), *states, f"{seen[-1][0] - seen[0][0]:+.1f}")
    return result


def _cycle(make: Callable[[], Any], look: bool) -> tuple[float, int, int] | None:
    env = make()
    env.reset(seed=0)
    env.step(env.action_space.sample())
    env.close()
    if not look:
        return None
    gc.collect()
    resident = int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
    return resident, len(list(Path("/proc/self/fd").iterdir())), threading.active_count()


if __name__ == "__main__":
    Console().print(table())
