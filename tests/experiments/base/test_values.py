"""Values by their keys: what ``--set`` is typed as."""

import pytest

from experiments.base.errors import UsageError
from experiments.base.values import key_values


def test_of_two_values_for_one_key_the_last_counts_and_a_value_may_have_an_equals_sign():
    assert key_values(["dsnn.n_con=4", "scene.wall=a=b.png", "dsnn.n_con=6"]) == {
        "dsnn.n_con": "6", "scene.wall": "a=b.png",
    }  # fmt: skip
    assert key_values(None) == {}


def test_a_key_without_a_value_is_refused():
    with pytest.raises(UsageError, match="--set robots"):
        key_values(["robots"])
