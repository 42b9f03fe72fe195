"""Copies and pickles of what holds a state: refused in one line, and the original is as it was."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable, Iterator
from contextlib import closing
from multiprocessing.reduction import ForkingPickler
from pathlib import Path
from typing import Any

import cloudpickle
import gymnasium as gym
import numpy as np
import pytest

import colias_sim
import experiments
from colias_sim import CameraConfig, Pose, Simulation
from dsnn import MODELS
from dsnn.stimuli import stimulus
from experiments.bench.store.kinds import TRIALS
from tests.helpers.envs import fingerprint

FIXATION = "colias_sim/Fixation-v0"
SMALL = CameraConfig(width=24, height=16)
WAYS: dict[str, Callable[[Any], Any]] = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": pickle.dumps,
    "cloudpickle": cloudpickle.dumps,
    "as an argument of a spawned process": ForkingPickler.dumps,
}


def refused(thing: Any, *advice: str, ways: tuple[str, ...] = tuple(WAYS)) -> None:
    """Every way to copy ``thing`` ends in a line with the advice."""
    for way in ways:
        with pytest.raises(TypeError, match="cannot be copied or pickled") as caught:
            WAYS[way](thing)
        message = str(caught.value)
        assert "\n" not in message and all(word in message for word in ("make another", *advice)), (way, message)


def open_files() -> int:
    return len(list(Path("/proc/self/fd").iterdir()))


@pytest.mark.parametrize("name", MODELS)
def test_a_model_that_cannot_be_copied_says_so_and_answers_as_before(name: str, form: str) -> None:
    """A copy would share the original's buffers, or lose that they are views of one another."""
    entry = MODELS[name]
    frames = [frame.luma for frame in stimulus("looming", l_over_v_s=0.02)][:8]
    model, twin = (entry.build(frames[0].shape, entry.robot) for _ in range(2))
    answers = []
    for frame in frames:
        refused(model, "shape", "params")
        answers.append(model.step(frame))
    assert answers == [twin.step(frame) for frame in frames]


def test_an_answer_can_be_copied() -> None:
    entry = MODELS["dsnn"]
    answer = entry.build((20, 30), entry.robot).step(np.full((20, 30), 7, np.uint8), maps=True)
    for other in (copy.deepcopy(answer), pickle.loads(pickle.dumps(answer))):
        np.testing.assert_equal([getattr(other.maps, name) for name in other.maps.__slots__],
                                [getattr(answer.maps, name) for name in answer.maps.__slots__])  # fmt: skip


@pytest.mark.parametrize("observation", ["state", "pixels", "neural"])
def test_an_env_that_cannot_be_copied_says_so_and_goes_on_as_before(observation: str) -> None:
    action = np.array([0.2, -0.1], np.float32)
    with closing(gym.make(FIXATION, observation=observation)) as env:
        expected = fingerprint([env.reset(seed=4), *(env.step(action) for _ in range(3))])
        told, before = [env.reset(seed=4)], open_files()
        for _ in range(3):
            refused(env.unwrapped, "same seed and actions")
            refused(env, "same seed and actions", ways=tuple(way for way in WAYS if way != "copy"))
            told.append(env.step(action))
        assert fingerprint(told) == expected
        assert open_files() == before


@pytest.mark.parametrize("workers", [0, 1])
def test_a_vector_env_that_cannot_be_copied_says_so_and_goes_on_as_before(workers: int) -> None:
    actions = np.full((2, 2), 0.1)
    with closing(gym.make_vec(FIXATION, 2, workers=workers, observation="state")) as envs:
        expected = fingerprint([envs.reset(seed=4), *(envs.step(actions) for _ in range(3))])
        told, before = [envs.reset(seed=4)], open_files()
        for _ in range(3):
            refused(envs, "same seeds and actions")
            told.append(envs.step(actions))
        assert fingerprint(told) == expected
        assert open_files() == before


@pytest.fixture
def simulation() -> Iterator[Simulation]:
    robots = {"observer": "colias", "stimulus": "colias_black", "post": "colias_parked"}
    with Simulation(camera=SMALL, robots=robots) as sim:
        yield sim


def test_a_simulation_and_its_parts_cannot_be_copied(simulation: Simulation) -> None:
    places = {"stimulus": Pose(0.12, 0.02, 1.0), "post": Pose(0.1, -0.1, 0.0)}

    def trial() -> Iterator[bytes]:
        rng = np.random.default_rng(2)
        simulation.reset(places, rng)
        robot = simulation.robots["stimulus"]
        robot.drive(robot.wheels_for(0.1, 0.0))
        for _ in range(3):
            yield simulation.step(rng).luma.tobytes()

    expected, seen = list(trial()), []
    for luma in trial():
        seen.append(luma)
        refused(simulation, "same settings")
        refused(simulation.camera)
        for robot in simulation.everyone.values():
            refused(robot, "Simulation")
    assert seen == expected


def test_a_frame_can_be_copied(simulation: Simulation) -> None:
    """What a camera gives is a value: a copy has the same pixels, and the original stays read-only."""
    simulation.reset({"stimulus": Pose(0.12, 0.02, 1.0), "post": Pose(0.1, -0.1, 0.0)}, np.random.default_rng(2))
    frame = simulation.step(np.random.default_rng(3))
    for other in (copy.copy(frame), copy.deepcopy(frame), pickle.loads(pickle.dumps(frame))):
        assert isinstance(other, colias_sim.Frame) and other.time == frame.time
        np.testing.assert_array_equal(other.luma, frame.luma)
    assert not frame.luma.flags.writeable


class Reading:
    """Reads something while it is copied, as another thread may."""

    def __init__(self, read: Callable[[], Any]) -> None:
        self.read = read

    def __deepcopy__(self, memo: Any) -> str:
        self.read()
        return "read"

    def __reduce__(self) -> tuple[Any, ...]:
        self.read()
        return str, ("read",)


@pytest.mark.parametrize("way", [copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))])
def test_what_is_read_for_the_first_time_meanwhile_does_not_disturb_a_copy(way: Any, tmp_path: Path) -> None:
    """A run's tables and a clip's background are made when they are first asked for."""
    described: dict[str, Any] = {"experiment": "x", "seed": 0}
    run = experiments.Run(tmp_path, described, TRIALS)
    described["meanwhile"] = Reading(lambda: (run.claims, run.failures))
    assert way(run).folder == tmp_path
    clip = stimulus("cluttered", rows=20, columns=30)
    clip.meanwhile = Reading(lambda: clip[0])
    assert len(way(clip)) == len(clip)
    np.testing.assert_array_equal(way(clip)[3].luma, clip[3].luma)
