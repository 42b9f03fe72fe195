"""Arguments and actions of the envs: spelled out, checked, and refused in one line that says what is legal."""

import inspect
import math
import re
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import error

from colias_sim.envs.options import options_of
from tests.helpers.envs import NAMES, bare, env_class, every_env, options_type

# Arguments are spelled out.


@every_env
def test_the_constructor_spells_out_every_argument(name):
    parameters = inspect.signature(env_class(name)).parameters
    options = options_of(options_type(name))
    assert list(parameters) == list(options)
    for key, parameter in parameters.items():
        assert parameter.kind is inspect.Parameter.KEYWORD_ONLY
        assert (parameter.default, parameter.annotation) == (options[key].default, options[key].annotation)
        assert not isinstance(parameter.annotation, str)


# Actions.

WRONG: list[Any] = [
    np.array([np.nan, 0.0]), [0.0, np.inf], [1.1, 0.0], [0.0, -1.5], [1e300, 0.0], [0.0, 0.0, 0.0], np.zeros((2, 1)),
    None, [None, None], "ab", ["0.1", "0.2"], [1j, 0.0], [[0.0], [0.0, 1.0]], {}, 7, -1, 2.5, 10**30,
    np.full((90, 90), np.nan), True, [True, False], [True, 0.5], {0: 0, 1: 1}, {0, 1}, np.array([-128, 0], np.int8),
    [10**5000, 0],
]  # fmt: skip


@pytest.mark.parametrize("actions", ["wheels", "manoeuvres"])
@pytest.mark.parametrize("wrong", WRONG, ids=range(len(WRONG)))
def test_an_illegal_action_is_told_and_nothing_happens(wrong, actions):
    env = bare(NAMES[0], observation="state", actions=actions)
    env.reset(seed=0)
    before = env.poses
    with pytest.raises(error.InvalidAction, match="expected") as told:
        env.step(wrong)
    assert "\n" not in str(told.value) and len(str(told.value)) < 160
    assert env.poses == before
    observation, *_ = env.step(env.action_space.sample())
    assert env.observation_space.contains(observation)
    env.close()


@pytest.mark.parametrize("legal", [[0.1, -0.1], (1, -1), np.array([0.5, 0.5]), np.array([-1, 1])], ids=str)
def test_two_numbers_however_written(legal):
    env = bare(NAMES[0], observation="state")
    env.reset(seed=0)
    env.step(legal)
    assert env.wheels.dtype == np.float32
    env.close()


# Arguments are checked.

BAD = [
    ({"robots": 99}, "^robots must be"),
    ({"robots": -1}, "^robots must be"),
    ({"arena": "brihgt"}, "arena.*nearest: bright"),
    ({"noise": -1}, "^noise must be"),
    ({"noise": math.nan}, "^noise must be"),
    ({"observation": "pixel"}, "^observation must be"),
    ({"robtos": 3}, "'robtos'.*nearest: robots"),
    ({"model": "dsn"}, "'dsn'.*nearest: dsnn"),
    ({"model": 3}, "model=3.*name.*factory"),
    ({"model": lambda shape: None}, "made None.*step.*reset"),
    ({"frame_skip": 0}, "^frame_skip must be"),
    ({"frame_skip": 1.5}, "^frame_skip must be"),
    ({"randomise": 2.0, "actions": "legs"}, "^actions must be.*; randomise"),
    ({"render_view": "side", "render_mode": "rgb_array"}, "^render_view must be"),
]


@every_env
@pytest.mark.parametrize(("options", "message"), BAD, ids=lambda value: str(value)[:24])
def test_a_bad_argument_is_named_with_what_is_legal(name, options, message, contexts):
    with pytest.raises(ValueError, match=message) as told:
        gym.make(name, **options)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("Fixation", {"robots": 0}, "^robots must be"),
        ("Fixation", {"slowest_deg_s": 50.0, "fastest_deg_s": 20.0}, "slowest_deg_s=50.*fastest_deg_s, 20"),
        ("Optomotor", {"slowest_deg_s": 50.0, "fastest_deg_s": 20.0}, "slowest_deg_s=50.*fastest_deg_s=20"),
        ("Optomotor", {"slowest_deg_s": 0.0, "fastest_deg_s": 0.0}, "fastest_deg_s=0.*above 0"),
        ("Optomotor", {"disturbance": "push", "fastest_deg_s": 200.0}, "fastest_deg_s=200.*180"),
        ("Pursuit", {"distance_cm": 1.0}, "^distance_cm must be"),
        ("Avoidance", {"moving": 21}, "^moving must be"),
    ],
)
def test_a_bad_argument_of_one_env(name, options, message, contexts):
    with pytest.raises(ValueError, match=message) as told:
        gym.make(f"colias_sim/{name}-v0", **options)
    assert "\n" not in str(told.value)


# A truth value is no number, though Python counts True as 1.

FLAGS = [True, False, np.True_, np.False_]


@every_env
@pytest.mark.parametrize("flag", FLAGS, ids=repr)
def test_no_argument_takes_a_truth_value_for_a_number(name, flag):
    """Of all arguments that are numbers, so of those of an env to come; nothing is made for any of them."""
    numbers = [key for key, option in options_of(options_type(name)).items() if option.annotation in (int, float)]
    assert {"robots", "frame_skip", "noise"} <= set(numbers)
    for key in numbers:
        with pytest.raises(ValueError, match=f"^{key} must be a number.*, got {re.escape(repr(flag))}$"):
            gym.make(name, **{key: flag})


@pytest.mark.parametrize("flag", FLAGS, ids=repr)
@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("randomise", lambda flag: flag),
        ("randomise", lambda flag: {"light": (flag, 1.0)}),
        ("camera", lambda flag: {"gain": flag}),
        ("camera", lambda flag: {"width": flag}),
        ("robot", lambda flag: {"dead_band": flag}),
    ],
    ids=["randomise", "range", "camera", "camera's width", "robot"],
)
def test_nor_do_ranges_and_settings_by_name(key, value, flag):
    with pytest.raises(ValueError, match=rf"^{key}\b.*number") as told:
        gym.make(NAMES[0], **{key: value(flag)})
    assert "\n" not in str(told.value)


def test_a_truth_value_is_legal_where_one_is_meant():
    env = gym.make("colias_sim/Fixation-v0", observation="state", follow=True, camera={"still_background": True})
    assert env.unwrapped.options.follow is True and env.unwrapped.options.camera.still_background is True
    env.close()
