"""A script: copy everything public in threads and processes, while the original is used; write to troubles.json."""

from __future__ import annotations

import copy
import dataclasses
import functools
import gc
import json
import multiprocessing
import os
import pickle
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from multiprocessing import resource_tracker
from pathlib import Path
from typing import Any

import cloudpickle
import gymnasium as gym
import numpy as np
import pyarrow as pa

import colias_sim
import dsnn
import dsnn.forms
import experiments
from colias_sim.envs import ENVS
from dsnn.stimuli import stimulus
from experiments.bench.registry import find

WAYS: dict[str, Callable[[Any], Any]] = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda thing: pickle.loads(pickle.dumps(thing)),
    "cloudpickle": lambda thing: pickle.loads(cloudpickle.dumps(thing)),
}
THREADS, ROUNDS, ANSWERS = 3, 4, 3


@dataclasses.dataclass
class Subject:
    """Something public: how it is made, what it answers, whether a copy has to be refused, and whether processes are
    given it, which takes a second."""

    name: str
    make: Callable[[], Any]
    answer: Callable[[Any], Any]
    refused: bool = True
    processes: bool = True


def bits(value: Any) -> Any:
    """A value to the last bit, as something that compares."""
    if isinstance(value, np.ndarray):
        return value.shape, str(value.dtype), value.tobytes()
    if isinstance(value, pa.Table):
        return repr(value.to_pylist())
    if isinstance(value, functools.partial):
        return bits((value.func, value.args, value.keywords))
    if isinstance(value, Mapping):
        return [(key, bits(content)) for key, content in value.items()]
    if isinstance(value, frozenset | set):
        return sorted(map(repr, value))
    if isinstance(value, tuple | list):
        return [bits(element) for element in value]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return type(value).__name__, [bits(getattr(value, field.name)) for field in dataclasses.fields(value)]
    if callable(value):
        return getattr(value, "__qualname__", type(value).__qualname__)
    return repr(value)


# What is used.

CLIP = [frame.luma for frame in stimulus("looming", l_over_v_s=0.02)][:6]
PLACES = {"stimulus": colias_sim.Pose(0.12, 0.02, 1.0), "post": colias_sim.Pose(0.1, -0.1, 0.0)}
ROBOTS = {"observer": "colias", "stimulus": "colias_black", "post": "colias_parked"}


def play(env: Any) -> Any:
    """An episode of a single env or a vector env."""
    action = np.full(env.action_space.shape, 0.1, np.float32)
    return bits([env.reset(seed=3), *(env.step(action) for _ in range(3))])


def trial(simulation: colias_sim.Simulation) -> Any:
    """Frames of a trial, and where everybody ends."""
    rng = np.random.default_rng(1)
    simulation.reset(PLACES, rng)
    robot = simulation.robots["stimulus"]
    robot.drive(robot.wheels_for(0.1, 0.0))
    frames = [simulation.step(rng) for _ in range(3)]
    return bits([frames, [body.pose for body in simulation.everyone.values()]])


def run_folder() -> Any:
    """A small run, or the one that is there."""
    settings = {"experiment.speeds_cm_s": [20], "experiment.distances_cm": [8]}
    return experiments.load("run") if Path("run").exists() else experiments.run(
        "speed", repeats=1, models=["emd"], settings=settings, out="run", quiet=True, recordings=False
    )  # fmt: skip


def read(run: Any) -> Any:
    """All tables of a run, each of which is read when it is first asked for."""
    return bits([run.trials, run.frames, run.summary, run.claims, run.failures, run.verdicts])


def first_frames(clip: Any) -> Any:
    """The first frames of a clip; some clips draw at random when the first is asked for."""
    return bits([clip[index].luma for index in range(3)])


def models() -> Iterator[Subject]:
    """Every model in either form."""
    for form in dsnn.forms.FORMS:
        for name, entry in dsnn.MODELS.items():

            def make(entry: Any = entry, form: str = form) -> Any:
                os.environ[dsnn.forms.VARIABLE] = form
                return entry.build(CLIP[0].shape, entry.robot)

            yield Subject(f"{name} ({form})", make, lambda model: bits(model.run(CLIP)), processes=form == "native")


def worlds() -> Iterator[Subject]:
    """Every env, alone and in a vector env, and a simulation."""
    for number, name in enumerate(ENVS):
        sense = ("state", "pixels", "neural", "both")[number % 4]
        bare = functools.partial(gym.make, name, observation=sense)
        yield Subject(f"{name} ({sense})", lambda bare=bare: bare().unwrapped, play)
        for workers in (0, 2):
            many = functools.partial(gym.make_vec, name, num_envs=2, workers=workers, observation=sense)
            yield Subject(f"{name} ({sense}, {workers} workers)", many, play)
    yield Subject("Simulation", lambda: colias_sim.Simulation(robots=ROBOTS), trial)


def values() -> Iterator[Subject]:
    """What has no state, or one that a copy can have too."""
    declared = [find(name) for name in (*experiments.NAMES, *experiments.OFFLINE)]
    with colias_sim.Simulation(robots=ROBOTS) as simulation:
        simulation.reset(PLACES, np.random.default_rng(0))
        frame = simulation.step(np.random.default_rng(0))
    series = dsnn.DSNN(CLIP[0].shape).run(CLIP)
    things = [
        *declared, *dsnn.MODELS.values(), *(entry.robot for entry in dsnn.MODELS.values()), frame, series,
        dsnn.DSNN(CLIP[0].shape).step(CLIP[0], maps=True), colias_sim.CameraConfig(), colias_sim.RobotConfig(),
        colias_sim.SceneConfig(), PLACES, colias_sim.WheelSpeeds(0.1, 0.2), colias_sim.Stretch(0.1),
        colias_sim.Route.line(PLACES["post"], 1.0, 0.1), experiments.Path([experiments.Leg(5, 6)]),
        *ENVS.values(), experiments.Check("x", 1.0, 0.0),
        experiments.Outcome("holds", "x"), experiments.Score(1.0, 0.5, 1.5, 3), experiments.UsageError("a line"),
        colias_sim.GLUnavailable("a line"), dsnn.FrameError("a line"), dsnn.AnswerError("a line"),
        experiments.score("straight", episodes=1, quiet=True), run_folder().trials, experiments.runs("."),
        *(getattr(package, name) for package in (colias_sim, dsnn, experiments) for name in package.__all__
          if name != "MODELS"),
    ]  # fmt: skip
    for thing in things:
        name = f"{type(thing).__name__} {str(thing)[:40]}"
        yield Subject(name, lambda thing=thing: thing, bits, refused=False, processes=False)
    yield Subject("all values", lambda: things, bits, refused=False)
    yield Subject("a run", run_folder, read, refused=False)
    yield Subject("a comparison", lambda: experiments.compare("run", "run"), bits, refused=False)
    for name in ("looming", "cluttered", "street"):
        yield Subject(name, lambda name=name: stimulus(name, rows=40, columns=60), first_frames, refused=False)


# The attack.


def trouble(subject: Subject, thing: Any, expected: Any) -> Iterator[str]:
    """Copy ``thing`` in every way, and use what came of it."""
    for way, copied in WAYS.items():
        try:
            other = copied(thing)
        except Exception as error:
            message = str(error)
            if "\n" in message or not message or (subject.refused and "make another" not in message):
                yield f"{subject.name}: {way}: {type(error).__name__}: {message}"
            elif not subject.refused:
                yield f"{subject.name}: {way}: has no copy: {message}"
            continue
        if subject.refused:
            yield f"{subject.name}: {way}: there is a copy"
        elif subject.answer(other) != expected:
            yield f"{subject.name}: {way}: the copy answers otherwise"
        del other
        gc.collect(0)


def in_process(subject: Subject, thing: Any, expected: Any) -> Iterator[str]:
    """Hand ``thing`` to a process that is spawned, and to a fork that copies and closes what it was given."""
    spawned = multiprocessing.get_context("spawn").Process(target=id, args=(thing,))
    try:
        spawned.start()
        spawned.join(60)
        if subject.refused or spawned.exitcode != 0:
            yield f"{subject.name}: spawned with it: exit status {spawned.exitcode}"
    except Exception as error:
        if not subject.refused or "make another" not in str(error):
            yield f"{subject.name}: spawned with it: {type(error).__name__}: {error}"

    def child() -> None:
        faults = list(trouble(subject, thing, expected))
        if subject.refused and hasattr(thing, "close"):
            thing.close()
        sys.exit(1 if faults else 0)

    forked = multiprocessing.get_context("fork").Process(target=child)
    forked.start()
    forked.join(60)
    if forked.exitcode != 0:
        yield f"{subject.name}: forked with it: exit status {forked.exitcode}"


def attack(subject: Subject) -> list[str]:
    """Copy a subject in threads while it is used, then in processes; what it answers stays the same."""
    faults: list[str] = []
    thing = subject.make()
    try:
        expected = subject.answer(subject.make() if not subject.refused else thing)

        def beside() -> None:
            for _ in range(ROUNDS):
                faults.extend(trouble(subject, thing, expected))

        threads = [threading.Thread(target=beside) for _ in range(THREADS)]
        before = files()
        for thread in threads:
            thread.start()
        answers = [subject.answer(thing) for _ in range(ANSWERS)]
        for thread in threads:
            thread.join()
        if subject.processes:
            faults.extend(in_process(subject, thing, expected))
        answers.append(subject.answer(thing))
        if any(answer != expected for answer in answers):
            faults.append(f"{subject.name}: the original answers otherwise")
        gc.collect()
        if subject.refused and files() > before:
            faults.append(f"{subject.name}: {files() - before} files more are open")
    finally:
        if subject.refused and hasattr(thing, "close"):
            thing.close()
    return faults


def files() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


if __name__ == "__main__":
    group = {function.__name__: function for function in (models, worlds, values)}[sys.argv[1]]
    resource_tracker.ensure_running()  # spawning a process opens its file, for good
    troubles: list[str] = []
    for subject in group():
        troubles += attack(subject)
    Path("troubles.json").write_text(json.dumps(sorted(set(troubles))))
