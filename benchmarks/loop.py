"""The closed loop against its floor, where its time goes, and what a recording adds."""

from __future__ import annotations

import math
import tempfile
import time
from pathlib import Path

import numpy as np
from rich.table import Table

from benchmarks.timing import interleaved
from colias_sim import PathFollower, Pose, Simulation
from colias_sim.path import Line
from dsnn import DSNN, DSNNParams
from experiments.bench import catalogue
from experiments.bench.results import RunFolder
from experiments.bench.runner import Plan, run
from experiments.bench.settings import configure

FRAMES = 60


def loop_table() -> Table:
    """Physics, render and network of a crossing at 6 cm/s, with the defaults of a trial."""
    with Simulation() as sim:
        model, rng = DSNN((72, 99), DSNNParams.robot()), np.random.default_rng(0)
        robot, line = sim.robots["stimulus"], Line(Pose(0.1, 0.06, -math.pi / 2), 0.2)
        follower = PathFollower(robot, line, 0.06)
        spent = {"physics": 0.0, "render": 0.0}
        parts = _split(sim, spent)

        def control(dt: float) -> None:
            robot.drive(follower.wheels(dt))

        def start() -> None:
            sim.reset({"stimulus": line.start}, rng)

        def bare() -> int:
            start()
            for _ in range(FRAMES):
                sim.advance(control)
                sim.camera.discard()
            return FRAMES

        def floor() -> int:
            start()
            for _ in range(FRAMES):
                sim.step(rng, control)
            return FRAMES

        def loop() -> int:
            start()
            for _ in range(FRAMES):
                model.step(sim.step(rng, control).luma)
            return FRAMES

        times = interleaved({"bare": bare, "floor": floor, "loop": loop})
        with parts:
            bare()
    table = Table(title="Closed loop at 99x72, microseconds a frame (best of 15 rounds)")
    for name in ("part", "us", "times the floor", "times real time"):
        table.add_column(name, justify="left" if name == "part" else "right")
    for name, label in (
        ("bare", "physics + render, no noise"),
        ("floor", "floor: physics + camera"),
        ("loop", "+ network: the closed loop"),
    ):
        us = times.us(name)
        table.add_row(label, f"{us:.0f}", f"{times.ratio(name, 'floor'):.2f}", f"{1e6 / 30 / us:.1f}")
    rest = {"camera noise": times.us("floor") - times.us("bare"), "network": times.us("loop") - times.us("floor")}
    for name, us in {**{part: seconds / FRAMES * 1e6 for part, seconds in spent.items()}, **rest}.items():
        table.add_row(f"  {name}", f"{us:.0f}", "", "")
    return table


class _split:
    """While entered, adds what `Camera.expose` takes to ``spent['render']`` and the rest of `advance` to physics."""

    def __init__(self, sim: Simulation, spent: dict[str, float]) -> None:
        self._sim, self._spent = sim, spent
        self._expose, self._advance = sim.camera.expose, sim.advance

    def __enter__(self) -> None:
        self._sim.camera.expose = self._timed(self._expose, "render")  # type: ignore[method-assign]
        self._sim.advance = self._timed(self._advance, "physics")  # type: ignore[method-assign]

    def __exit__(self, *error: object) -> None:
        self._sim.camera.expose, self._sim.advance = self._expose, self._advance  # type: ignore[method-assign]
        self._spent["physics"] -= self._spent["render"]

    def _timed(self, call, part: str):  # type: ignore[no-untyped-def]
        def timed(*arguments):  # type: ignore[no-untyped-def]
            began = time.perf_counter()
            call(*arguments)
            self._spent[part] += time.perf_counter() - began

        return timed


def recording_table() -> Table:
    """What recording adds to `colias run speed --repeats 1`: to its wall time, and to the work of both cores."""
    experiment, settings = configure(catalogue.load("speed"), "dsnn", ())
    plan = Plan(experiment, settings, repeats=1, seed=0)
    wall: dict[bool, list[float]] = {False: [], True: []}
    work: dict[bool, list[float]] = {False: [], True: []}
    frames = size = 0
    for _ in range(4):
        for recordings in (False, True):
            with tempfile.TemporaryDirectory() as name:
                folder = RunFolder(Path(name) / "run")
                folder.create()
                began, worked = time.perf_counter(), time.process_time()
                run(plan, folder, lambda result: None, recordings=recordings)
                wall[recordings].append(time.perf_counter() - began)
                work[recordings].append(time.process_time() - worked)
                frames = folder.frames().num_rows
                size = sum(file.stat().st_size for file in folder.recordings.iterdir())
    table = Table(title="Recording, a frame")
    for heading in ("added wall time, ms", "added work, ms", "KB"):
        table.add_column(heading, justify="right")
    added = [(min(spent[True]) - min(spent[False])) / frames * 1e3 for spent in (wall, work)]
    table.add_row(*(f"{ms:.2f}" for ms in added), f"{size / frames / 1e3:.1f}")
    return table
