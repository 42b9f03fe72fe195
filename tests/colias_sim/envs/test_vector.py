"""Vector envs: the same worlds as single envs in any number of processes, and Gymnasium's contract."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import error
from gymnasium.vector import AutoresetMode

from tests.helpers.vector import COUNT, FIXATION, LIMIT, actions, assert_same, make


def story(env: gym.vector.VectorEnv, steps: int = 10) -> Iterator[Any]:
    yield env.reset(seed=7)
    for action in actions(steps):
        yield env.step(action)
    yield env.reset(seed=[None, 4, 9], options={"reset_mask": np.array([False, True, False])})
    yield env.step(actions(1)[0])


@pytest.mark.parametrize("mode", [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP], ids=lambda mode: mode.value)
def test_is_gymnasiums_sync_env_in_any_number_of_processes(mode: AutoresetMode) -> None:
    options: dict[str, Any] = {"observation": "both", "max_episode_steps": LIMIT}
    sync = gym.make_vec(FIXATION, COUNT, "sync", vector_kwargs={"autoreset_mode": mode}, **options)
    told = list(story(sync))
    sync.close()
    for number in (0, 1, 2):
        env = make(workers=number, autoreset_mode=mode, **options)
        assert env.metadata["autoreset_mode"] is mode
        assert env.single_observation_space == sync.single_observation_space
        assert env.action_space == sync.action_space
        for ours, theirs in zip(story(env), told, strict=True):
            assert_same(ours, theirs)
        env.close()


def test_is_single_envs() -> None:
    env = make(workers=0, actions="manoeuvres")
    (frames, _), taken = env.reset(seed=[5, 6, 5]), np.array([1, 4, 1])
    singles = [gym.make(FIXATION, actions="manoeuvres") for _ in range(COUNT)]
    firsts = [single.reset(seed=seed)[0] for single, seed in zip(singles, [5, 6, 5], strict=True)]
    assert_same(frames, np.stack(firsts))
    for _ in range(5):
        seconds = [single.step(action)[0] for single, action in zip(singles, taken, strict=True)]
        assert_same(env.step(taken)[0], np.stack(seconds))
    for open_env in (env, *singles):
        open_env.close()


def test_gymnasiums_own_vector_envs_work_too() -> None:
    env = gym.make_vec(FIXATION, 2, "async", vector_kwargs={"context": "spawn"}, observation="neural")
    try:
        frames, _ = env.reset(seed=1)
        assert env.observation_space.contains(frames)
    finally:
        env.close()


def test_arrays_are_the_callers_own() -> None:
    env = make(2, workers=0)
    first, _ = env.reset(seed=0)
    kept = first.copy()
    second, rewards, *_ = env.step(actions(1, 2)[0])
    rewards[:] = 99.0
    assert_same(first, kept)
    assert not np.array_equal(first, second)
    assert (env.step(actions(1, 2)[0])[1] < 99.0).all()
    env.close()


def test_truncation_and_pictures() -> None:
    env = make(2, workers=1, render_mode="rgb_array", render_width=64, render_height=48, max_episode_steps=2)
    env.reset(seed=0)
    ends = [env.step(np.zeros((2, 2), np.float32))[3].tolist() for _ in range(6)]
    assert ends == [[False] * 2, [True] * 2, [False] * 2] * 2  # the third begins anew
    pictures = env.render()
    assert pictures is not None and [picture.shape for picture in pictures] == [(48, 64, 3)] * 2
    assert not np.array_equal(*pictures)
    env.close()


def test_disabled_autoreset_wants_a_reset_of_what_ended() -> None:
    env = make(2, workers=0, autoreset_mode="Disabled", max_episode_steps=1)
    with pytest.raises(error.ResetNeeded, match="without a reset_mask"):
        env.reset(options={"reset_mask": np.array([True, False])})
    env.reset(seed=0)
    env.step(np.zeros((2, 2)))
    with pytest.raises(error.ResetNeeded, match=r"envs \[0, 1\]"):
        env.step(np.zeros((2, 2)))
    env.reset(options={"reset_mask": np.array([True, True])})
    env.step(np.zeros((2, 2)))
    env.close()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (np.array([[0, 0], [np.nan, 0]]), "env 1: action .*nan"),
        (np.array([[1.5, 0], [0, 0]]), "env 0: action .*1.5"),
        ([[0, 0], [0, 0, 0]], r"env 1: action \[0, 0, 0\]"),
        ([[0, 0], "ab"], "env 1: action 'ab'"),
        (np.zeros((3, 2)), "expected 2, one for each env"),
        (None, "expected 2, one for each env"),
        ([["0.1", "0.2"], [0, 0]], r"env 0: action \['0.1', '0.2'\]"),
        ([[0, 0], [True, False]], r"env 1: action \[True, False\]"),
        (np.zeros((2, 2), bool), "env 0: action array.*False"),
        (np.zeros((2, 2), object), "env 0: action array.*object"),
        (np.array([[0, 0], [-128, 0]], np.int8), "env 1: action array.*-128"),
        ({(0.0, 0.0), (0.1, 0.1)}, "expected 2, one for each env"),
        ({(0.0, 0.0): 0, (0.1, 0.1): 1}, "expected 2, one for each env"),
    ],
)
def test_a_bad_action_names_its_env_and_moves_nobody(wrong: Any, message: str) -> None:
    env = make(2, workers=0, observation="state")
    env.reset(seed=0)
    with pytest.raises(error.InvalidAction, match=message):
        env.step(wrong)
    after = env.step(np.zeros((2, 2)))
    env.reset(seed=0)
    assert_same(env.step(np.zeros((2, 2))), after)
    env.close()


def test_a_bad_manoeuvre_names_its_env() -> None:
    env = make(2, workers=0, observation="state", actions="manoeuvres")
    env.reset(seed=0)
    for wrong in ([1, 7], [1, 0.5], [3, None], [0, True], [0, "1"], np.array([1, 9])):
        with pytest.raises(error.InvalidAction, match=r"env 1: action .* from 0 to 6"):
            env.step(wrong)
    for wrong in ({0: 1, 1: 2}, {0, 1}, b"\0\1", "01"):  # each has two entries
        with pytest.raises(error.InvalidAction, match="expected 2, one for each env"):
            env.step(wrong)
    env.close()


def test_order_of_calls() -> None:
    env = make(2, observation="state", workers=1)
    with pytest.raises(error.ResetNeeded):
        env.step(np.zeros((2, 2)))
    env.close()
    env.close()
    for call in (env.reset, env.render, lambda: env.step(np.zeros((2, 2)))):
        with pytest.raises(error.ClosedEnvironmentError):
            call()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"count": 0}, "num_envs=0: expected a whole number, 1 or more"),
        ({"count": 2.5}, "num_envs=2.5: expected a whole number"),
        ({"workers": "a"}, "workers='a': expected 0"),
        ({"max_episode_steps": "x"}, "max_episode_steps='x': expected a whole number"),
        ({"autoreset_mode": "Same"}, "autoreset_mode='Same': legal is .*SameStep"),
        ({"workers": 4}, r"workers=4: expected 0 .* num_envs=3"),
        ({"workers": -1}, "workers=-1"),
        ({"robots": 99}, "robots=99"),
        ({"max_episode_steps": 0}, "max_episode_steps=0"),
        ({"slowest_deg_s": 90.0, "workers": 1}, "slowest_deg_s=90.0: expected at most"),
        ({"observation": "neural", "model": "no such", "workers": 1}, "no such"),
        ({"observation": "neural", "model": threading.Lock(), "workers": 1}, "model=.* does not pickle"),
    ],
)
def test_a_bad_argument_is_one_clear_error(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message) as caught:
        make(**options)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "wrong",
    [
        {"seed": -1},
        {"seed": [1, 2]},
        {"seed": 0.5},
        {"options": {"wind": 1}},
        {"options": {"reset_mask": np.zeros(3, bool)}},
        {"options": {"reset_mask": [1, 1]}},
        {"options": "light"},
        {"options": [1]},
        {"options": []},
        {"options": {"reset_mask": [[True], [True, False]]}},
        {"seed": b"abc"},
        {"seed": {1, 2, 3}},
    ],
)
def test_a_bad_reset_leaves_the_env_open(wrong: dict[str, Any]) -> None:
    env = make(observation="state", workers=0)
    with pytest.raises(ValueError, match=r"seed=|wind|reset_mask|options="):
        env.reset(**wrong)
    env.reset(seed=0)
    env.close()
