"""Methods and attributes of the envs of a vector env: as Gymnasium's own vector envs have them."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import error
from gymnasium.utils import seeding

import colias_sim  # noqa: F401 - registers the envs
from tests.helpers.vector import FIXATION, assert_same

COUNT = 3
OPTIONS = {"observation": "state", "render_mode": "rgb_array", "render_width": 32, "render_height": 24}


@pytest.fixture(params=[0, 1, 2], ids="workers={}".format, scope="module")
def made(request: pytest.FixtureRequest) -> Iterator[gym.vector.VectorEnv]:
    envs = gym.make_vec(FIXATION, COUNT, workers=request.param, **OPTIONS)
    yield envs
    envs.close()


@pytest.fixture
def env(made: gym.vector.VectorEnv) -> gym.vector.VectorEnv:
    made.reset(seed=3)
    return made


@pytest.fixture(scope="module")
def theirs() -> Iterator[gym.vector.VectorEnv]:
    envs = gym.make_vec(FIXATION, COUNT, "sync", **OPTIONS)
    envs.reset(seed=3)
    yield envs
    envs.close()


def test_what_the_envs_have_and_give(env: Any, theirs: Any) -> None:
    for name in ("poses", "state", "wheels", "np_random_seed", "metadata", "render_mode", "action_space"):
        ours = env.get_attr(name)
        assert isinstance(ours, tuple) and len(ours) == COUNT
        assert [repr(attribute) for attribute in ours] == [repr(attribute) for attribute in theirs.get_attr(name)]
        assert [repr(attribute) for attribute in env.call(name)] == [repr(attribute) for attribute in ours]
    assert_same(env.call("render"), theirs.call("render"))
    assert_same(env.call("has_wrapper_attr", "luma"), theirs.call("has_wrapper_attr", "luma"))
    assert env.np_random_seed == theirs.np_random_seed == (3, 4, 5)
    assert [generator.bit_generator.state for generator in env.np_random] == [
        generator.bit_generator.state for generator in theirs.np_random
    ]


def test_what_they_are_set_to(env: Any) -> None:
    for values, expected in [
        ([1, "two", None], (1, "two", None)),
        ((1, 2, 3), (1, 2, 3)),
        ("abc", ("abc",) * COUNT),
        (np.arange(3), (np.arange(3),) * COUNT),
    ]:
        assert env.set_attr("mark", values) is None
        assert_same(env.get_attr("mark"), expected)
    env.set_attr("mark", lambda *args, **kwargs: (args, kwargs))
    assert env.call("mark", 1, a=2) == (((1,), {"a": 2}),) * COUNT
    assert env.get_attr("mark") == (((), {}),) * COUNT
    env.set_attr("np_random", [seeding.np_random(seed)[0] for seed in (8, 8, 9)])
    places = [repr(step) for step in env.reset()[0]]
    assert places[0] == places[1] != places[2]


@pytest.mark.parametrize(
    ("request_", "kind", "message"),
    [
        (lambda env: env.get_attr("no_such"), AttributeError, "no_such"),
        (lambda env: env.call("render", 1, 2), TypeError, "render"),
        (lambda env: env.set_attr("luma", 1), AttributeError, "luma"),
        (lambda env: env.set_attr("mark", [1, 2]), ValueError, "Values must be .* Got `2` values for 3 environments"),
        (lambda env: env.set_attr("mark", []), ValueError, "Got `0` values"),
    ],
)
def test_errors_are_gymnasiums_and_leave_everything_open(
    request_: Any, kind: type[Exception], message: str, env: Any, theirs: Any
) -> None:
    with pytest.raises(kind, match=message):
        request_(theirs)
    with pytest.raises(kind, match=message):
        request_(env)
    assert_same(env.get_attr("np_random_seed"), (3, 4, 5))
    env.step(np.zeros((COUNT, 2)))


def test_one_env_that_fails_is_told_of_and_all_stay_in_step(env: Any) -> None:
    def failing(raises: bool) -> int:
        if raises:
            raise ConnectionError("lost")  # what a worker may get of its own pipe, too
        return 1

    env.set_attr("work", failing)
    env.set_attr("mark", [0, 1, 2])
    with pytest.raises(ConnectionError, match="lost"):
        env.call("work", True)
    assert env.call("work", False) == (1,) * COUNT
    assert env.get_attr("mark") == (0, 1, 2)


@pytest.mark.parametrize("name", ["reset", "step", "close"])
def test_what_is_for_all_at_once_is_refused(name: str, env: Any) -> None:
    for ask in (env.call, env.get_attr):
        with pytest.raises(ValueError, match=f"Trying to call function `{name}` with `call`, use `{name}` directly"):
            ask(name)
    env.step(np.zeros((COUNT, 2)))


@pytest.mark.parametrize("made", [2], indirect=True)
def test_what_does_not_pickle_is_one_line_and_leaves_everything_open(env: Any) -> None:
    for ask in (
        lambda: env.set_attr("mark", threading.Lock()),
        lambda: env.call("render", threading.Lock()),
        lambda: env.get_attr("unwrapped"),
    ):
        with pytest.raises(ValueError, match="does not pickle, which another process needs") as caught:
            ask()
        assert "\n" not in str(caught.value)
        env.step(np.zeros((COUNT, 2)))


@pytest.mark.parametrize("made", [1], indirect=True)
def test_what_only_a_worker_can_read_is_one_line(env: Any, tmp_path: Any) -> None:
    """A module that a worker found by itself is not known here."""
    (tmp_path / "only_there.py").write_text("class Thing:\n    pass\n")

    def thing(folder: str) -> Any:
        import importlib
        import sys

        sys.path.insert(0, folder)
        return importlib.import_module("only_there").Thing()

    env.set_attr("thing", thing)
    with pytest.raises(ValueError, match=r"envs 0\.\.2 gave cannot be read here .*only_there"):
        env.call("thing", str(tmp_path))
    env.step(np.zeros((COUNT, 2)))


def test_a_closed_one_answers_nothing() -> None:
    env = gym.make_vec(FIXATION, COUNT, workers=0, **OPTIONS)
    env.close()
    for ask in (lambda: env.call("render"), lambda: env.get_attr("poses"), lambda: env.set_attr("mark", 1)):
        with pytest.raises(error.ClosedEnvironmentError):
            ask()
