"""Arguments and actions of the envs: what is out of range is refused, and speeds are clipped."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import error

from tests.helpers.envs import FIXATION, bare, every_env

BAD: list[dict[str, Any]] = [
    {"robots": 99}, {"robots": -1}, {"arena": "brihgt"}, {"noise": -1}, {"noise": math.nan}, {"observation": "pixel"},
    {"robtos": 3}, {"model": "dsn"}, {"model": 3}, {"model": lambda shape: None}, {"frame_skip": 1.5},
    {"render_view": "side"}, {"camera": "ov767"}, {"camera": 7}, {"camera": {"blurr_px": 1.0}},
    {"camera": {"blur_px": 9.0}}, {"camera": {"fps": 25.0}}, {"camera": {"shot_noise": 60.0}, "noise": 2.0},
    {"robot": {"mass_g": 5.0}}, {"robot": "colias5"},
]  # fmt: skip


@every_env
def test_a_bad_argument_is_named(name, contexts):
    for options in BAD:
        with pytest.raises(ValueError, match=list(options)[-1]):
            gym.make(name, observation="state", **options) if "observation" not in options else gym.make(
                name, **options
            )


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("Fixation", {"robots": 0}),
        ("Fixation", {"slowest_deg_s": 50.0, "fastest_deg_s": 20.0}),
        ("Optomotor", {"slowest_deg_s": 50.0, "fastest_deg_s": 20.0}),
        ("Optomotor", {"slowest_deg_s": 0.0, "fastest_deg_s": 0.0}),
        ("Optomotor", {"disturbance": "push", "fastest_deg_s": 200.0}),
        ("Pursuit", {"distance_cm": 1.0}),
        ("Avoidance", {"moving": 21}),
    ],
)
def test_a_bad_argument_of_one_env(name, options, contexts):
    with pytest.raises(ValueError, match=list(options)[-1]):
        gym.make(f"colias_sim/{name}-v0", observation="state", **options)


WRONG: list[Any] = [[np.nan, 0.0], [0.0, 0.0, 0.0], np.zeros((2, 1)), 0.5]


@pytest.mark.parametrize("wrong", WRONG, ids=str)
def test_nan_and_other_shapes_raise_and_nothing_happens(wrong):
    env = bare(FIXATION, observation="state")
    env.reset(seed=0)
    before = env.poses
    with pytest.raises(error.InvalidAction):
        env.step(wrong)
    assert env.poses == before
    env.close()


def test_there_is_no_eighth_manoeuvre():
    env = bare(FIXATION, observation="state", actions="manoeuvres")
    env.reset(seed=0)
    for wrong in (7, -1, 0.5, None):
        with pytest.raises(error.InvalidAction):
            env.step(wrong)
    env.close()


@pytest.mark.parametrize("beyond", [[3.0, -1.5], [np.inf, -np.inf], [1e30, -2], np.array([9, -9], np.int8)], ids=str)
def test_speeds_beyond_the_space_are_clipped(beyond):
    """The episode, its rewards too, is that of the clipped action."""
    env = bare("colias_sim/Optomotor-v0", observation="state")
    taken = []
    for action in (beyond, [1.0, -1.0]):
        env.reset(seed=0)
        taken.append([env.step(action)[1:] for _ in range(3)])
    assert taken[0] == taken[1] and env.wheels.tolist() == [1.0, -1.0]
    env.close()


@pytest.mark.parametrize("legal", [[0.1, -0.1], (1, -1), np.array([0.5, 0.5]), np.array([-1, 1])], ids=str)
def test_two_numbers_however_written(legal):
    env = bare(FIXATION, observation="state")
    env.reset(seed=0)
    env.step(legal)
    assert env.wheels.dtype == np.float32
    env.close()
