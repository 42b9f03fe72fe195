"""A factory of a vision model is called as the envs' documentation says."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import pytest

import colias_sim  # noqa: F401 - registers the envs
from dsnn import Response
from tests.helpers.envs import FIXATION

SAID = "one argument, the tuple (rows, columns)"


class Still:
    def step(self, frame: Any) -> Response:
        return Response()

    def reset(self) -> None: ...


def test_a_factory_is_given_the_shape() -> None:
    given: list[tuple[Any, ...]] = []

    def factory(*arguments: Any) -> Still:
        given.append(arguments)
        return Still()

    gym.make(FIXATION, observation="neural", model=factory).close()
    assert given == [((72, 99),)]


def test_what_is_no_factory_is_told_so() -> None:
    with pytest.raises(ValueError) as caught:
        gym.make(FIXATION, observation="neural", model=3)
    assert f"a factory that takes {SAID}" in str(caught.value)
