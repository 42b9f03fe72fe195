"""Envs' steps a second, one and many, beside Gymnasium's own Reacher rendered at the same size.

``python -m benchmarks.envs`` runs these alone.
"""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from multiprocessing.connection import Connection
from typing import Any

import cv2
import gymnasium as gym
import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.table import Table
from threadpoolctl import threadpool_limits

import colias_sim  # noqa: F401 - chooses the OpenGL backend, for Reacher too
from benchmarks.timing import interleaved, ratio

ENV, COUNT, ROUNDS, STEPS = "colias_sim/Fixation-v0", 8, 12, 40
OBSERVED = ("pixels", "neural", "state")
YARDSTICK = "Reacher-v5"
REACHER_GOAL, NEURAL_GOAL = 3.0, 2.7


def single() -> Table:
    """One env with each observation against `Reacher-v5`, whose picture of 99x72 is drawn after every step.

    Each in a process of its own: Gymnasium's renderer draws into whatever context is current, its neighbours' too.
    """
    settings: dict[str, dict[str, Any]] = {name: {"id": ENV, "observation": name} for name in OBSERVED}
    settings[YARDSTICK] = {"id": YARDSTICK, "render_mode": "rgb_array", "width": 99, "height": 72}
    with ExitStack() as open_ones:
        players = {name: open_ones.enter_context(_player(arguments)) for name, arguments in settings.items()}
        times = interleaved(players, ROUNDS)
    goals = f"{REACHER_GOAL:g} times Reacher-v5 rendered at 99x72, neural {NEURAL_GOAL:g}"
    table = Table(title=f"One env, steps a second (goal: {goals})")
    for name in ("env", "steps a second", "times Reacher"):
        table.add_column(name, justify="left" if name == "env" else "right")
    for name in settings:
        table.add_row(name, f"{1e6 / times[name].min():.0f}", f"{ratio(times[YARDSTICK], times[name]):.2f}")
    return table


def vector() -> Table:
    """Eight envs in Gymnasium's sync vector env, and in its async one with shared memory."""
    table = Table(title=f"{COUNT} envs on {len(os.sched_getaffinity(0))} cores, steps of an env a second (times sync)")
    for name in ("observation", "sync", "async"):
        table.add_column(name, justify="left" if name == "observation" else "right")
    for observation in OBSERVED[:2]:
        times = _vectors(observation)
        gain = ratio(times["sync"], times["async"])
        table.add_row(observation, f"{1e6 / times['sync'].min():.0f}", f"{1e6 / times['async'].min():.0f} ({gain:.2f})")
    return table


@contextmanager
def _player(arguments: dict[str, Any]) -> Iterator[Callable[[], int]]:
    """Yield a function that takes a hundred steps of an env in another process."""
    spawn = multiprocessing.get_context("spawn")
    ours, theirs = spawn.Pipe()
    process = spawn.Process(target=_play, args=(theirs, arguments), daemon=True)
    process.start()

    def steps() -> int:
        ours.send(100)
        return int(ours.recv())

    steps()
    yield steps
    ours.send(0)
    process.join()


def _play(pipe: Connection, arguments: dict[str, Any]) -> None:
    """Steps that turn on the spot a little, begun anew where an episode ends."""
    cv2.setNumThreads(1)
    env, action = gym.make(**arguments), np.array([0.02, -0.02], np.float32)
    env.reset(seed=0)
    while steps := pipe.recv():
        for _ in range(steps):
            _, _, terminated, truncated, _ = env.step(action)
            if env.render_mode:
                env.render()
            if terminated or truncated:
                env.reset()
        pipe.send(steps)
    env.close()


def _vectors(observation: str) -> dict[str, npt.NDArray[np.float64]]:
    vectors = {
        "sync": gym.make_vec(ENV, COUNT, "sync", observation=observation),
        "async": gym.make_vec(ENV, COUNT, "async", vector_kwargs={"context": "spawn"}, observation=observation),
    }
    actions = np.tile(np.array([0.02, -0.02], np.float32), (COUNT, 1))

    def stepping(env: gym.vector.VectorEnv[Any, Any, Any]) -> Callable[[], int]:
        env.reset(seed=0)
        return lambda: COUNT * len([env.step(actions) for _ in range(STEPS)])

    try:
        return interleaved({name: stepping(env) for name, env in vectors.items()}, ROUNDS)
    finally:
        for env in vectors.values():
            env.close()


if __name__ == "__main__":  # workers started by spawn read this file too
    cv2.setNumThreads(1)
    with threadpool_limits(1):
        for part in (single, vector):
            Console().print(part())
