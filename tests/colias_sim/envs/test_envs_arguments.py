"""Arguments and actions of the envs: what is out of range is refused, and speeds are clipped."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import error

from tests.helpers.envs import FIXATION, bare

BAD: list[tuple[str, dict[str, Any]]] = [
    ("Fixation", {"robots": 0}), ("Fixation", {"arena": "brihgt"}), ("Fixation", {"noise": math.nan}),
    ("Fixation", {"robtos": 3}), ("Fixation", {"model": "dsn"}), ("Fixation", {"model": 3}),
    ("Fixation", {"camera": {"blur_px": 9.0}}), ("Fixation", {"robot": "colias5"}),
    ("Optomotor", {"slowest_deg_s": 50.0, "fastest_deg_s": 20.0}), ("Avoidance", {"moving": 21}),
]  # fmt: skip


@pytest.mark.parametrize(("name", "options"), BAD, ids=str)
def test_a_bad_argument_is_named(name, options, contexts):
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


@pytest.mark.parametrize("beyond", [[3.0, -1.5], [np.inf, -np.inf]], ids=str)
def test_speeds_beyond_the_space_are_clipped(beyond):
    """The episode, its rewards too, is that of the clipped action."""
    env = bare("colias_sim/Optomotor-v0", observation="state")
    taken = []
    for action in (beyond, [1.0, -1.0]):
        env.reset(seed=0)
        taken.append([env.step(action)[1:] for _ in range(3)])
    assert taken[0] == taken[1] and env.wheels.tolist() == [1.0, -1.0]
