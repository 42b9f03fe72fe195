"""A wrong use is told in one line: what was given, and what is legal. Called in this process, as `colias` calls it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, Simulation
from dsnn import DSNN, MODELS, model_entry
from dsnn.stimuli import stimulus
from experiments import UsageError
from experiments.bench.cli import main as cli_main

BIG, HUGE = str(10**12), str(10**30)


def refusal(*arguments: str) -> str:
    """The one line in which a command line is refused."""
    with pytest.raises(UsageError) as refused:
        cli_main.command([*arguments])
    assert "\n" not in str(refused.value)
    return str(refused.value)


# --- numbers that no machine can plan --------------------------------------------------------------------------------


def test_replicates_are_counted_with_the_points_of_the_grid():
    """Each number is legal by itself; their product is not."""
    axis = ",".join(str(value / 100) for value in range(100))
    asked = ("sweep", "general", "--over", f"camera.read_noise={axis}", "--claims", "C14", "--replicates", "9999")
    message = refusal(*asked)
    assert message.startswith("--replicates must be between 1 and ")


SEEDED = (
    "run speed", "run clean", "sweep speed --over dsnn.n_con=4,5", "leaderboard",
    "sweep clean --over dsnn.n_con=4,5", "tune", "reproduce", "behave fixation", "train",
)  # fmt: skip


@pytest.mark.parametrize("command", SEEDED)
def test_a_seed_that_no_table_holds_is_refused_at_once(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for seed in (HUGE, "-1"):
        message = refusal(*command.split(), "--seed", seed)
        assert message.startswith("--seed must be between 0 and ")
    assert list(tmp_path.iterdir()) == []


# --- values of another kind, in Python -------------------------------------------------------------------------------

ODD = (3, "x", [1], {"a": 1}, np.array(2.0))
FRAME = np.zeros((72, 99), np.uint8)
PLACED = {"observer": Pose(0.0, 0.0, 0.0), "stimulus": Pose(0.15, 0.0, 0.0)}


@pytest.fixture(scope="module")
def blind():
    with Simulation(seeing=False) as simulation:
        yield simulation


@pytest.mark.parametrize("value", ODD, ids=str)
@pytest.mark.parametrize("model", MODELS)
def test_a_model_names_the_kind_of_parameters_that_it_takes(model, value):
    with pytest.raises(ValueError, match=rf"^params is .*: expected {type(MODELS[model].robot).__name__}\("):
        MODELS[model].build((72, 99), value)


CALLS = {
    "a model's name": (lambda odd: model_entry([odd]), "known are dsnn"),
    "a stimulus's name": (lambda odd: stimulus([odd]), "known are plain"),
    "a stimulus's seed": (lambda odd: stimulus("plain", [odd]), "seed=.*: legal is a whole number"),
    "frames": (lambda odd: DSNN((72, 99)).run(np.array(2.0)), "frames is a .*: expected an array"),
    "no frames": (lambda odd: DSNN((72, 99)).run(3), "frames is a int: expected an array"),
    "the order of colours": (lambda odd: DSNN((72, 99)).step(FRAME, channels=[odd]), "channels is .*: expected 'grey'"),
    "a preset": (lambda odd: CameraConfig.preset([odd]), "no camera preset .*: there are default"),
    "a robot's settings": (lambda odd: Simulation(robot=odd, seeing=False), "robot is a .*: expected a RobotConfig"),
    "a camera's settings": (lambda odd: Simulation(camera=odd, seeing=False), "camera is a .* a CameraConfig"),
    "a scene's settings": (lambda odd: Simulation(scene=odd, seeing=False), "scene is a .*: expected a SceneConfig"),
    "robots": (lambda odd: Simulation(robots=[odd], seeing=False), "robots is a list: expected a mapping"),
    "a robot's variant": (lambda odd: Simulation(robots={"observer": [odd]}, seeing=False), "variants are colias"),
    "whose eye": (lambda odd: Simulation(eye_of=[odd], seeing=False), "camera of "),
}


@pytest.mark.parametrize("value", ODD, ids=str)
@pytest.mark.parametrize("call", CALLS)
def test_a_value_of_another_kind_is_refused_in_a_line(call, value):
    make, message = CALLS[call]
    with pytest.raises(ValueError, match=message) as refused:
        make(value)
    assert "\n" not in str(refused.value)


RESETS = {
    "placements": (lambda odd: {"placements": [odd]}, "placements is a list: expected a mapping"),
    "a pose": (lambda odd: {"placements": {"observer": odd}}, "observer is placed at .*: expected a Pose"),
    "a place": (lambda odd: {"placements": {"observer": Pose([odd], 0.0, 0.0)}}, "expected finite numbers"),
    "a generator": (lambda odd: {"rng": odd}, "rng is a .*: expected a numpy.random.Generator"),
    "light": (lambda odd: {"light": [odd]}, "light is .*: expected a number"),
    "no light": (lambda odd: {"light": float("nan")}, "light is nan: expected a number"),
}


@pytest.mark.parametrize("value", ODD, ids=str)
@pytest.mark.parametrize("argument", RESETS)
def test_a_refused_reset_changes_nothing(argument, value, blind):
    blind.reset(PLACED, np.random.default_rng(1))
    before = blind.data.qpos.copy(), blind.model.light_diffuse.copy()
    make, message = RESETS[argument]
    with pytest.raises(ValueError, match=message):
        blind.reset(**{"placements": PLACED, "rng": np.random.default_rng(0), **make(value)})
    assert np.array_equal(before[0], blind.data.qpos) and np.array_equal(before[1], blind.model.light_diffuse)


# --- users' words in figures -----------------------------------------------------------------------------------------


# --- the terminal ----------------------------------------------------------------------------------------------------


def commands(group: Any) -> Iterator[Any]:
    """Every command of a group and of the groups in it."""
    for command in group.commands.values():
        yield from commands(command) if hasattr(command, "commands") else (command,)
