"""The state of the world as an observation."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from colias_sim.envs import Other, State
from colias_sim.envs.state import LENGTH, SPEED, TURN

angles = st.floats(-math.pi, math.pi)
lengths, speeds, turns = st.floats(0, LENGTH), st.floats(-SPEED, SPEED), st.floats(-TURN, TURN)
others = st.lists(st.builds(Other, lengths, angles, speeds, speeds), max_size=4).map(tuple)


@given(st.builds(State, speeds, turns, turns, turns, lengths, angles, others))
def test_a_state_is_read_back_from_its_vector(state):
    vector = state.vector()
    assert vector.shape == (7 + 5 * len(state.others),) and vector.dtype == np.float32
    assert np.abs(vector).max() <= 1.0
    back = State.read(vector)
    for one, two in [(state, back), *zip(state.others, back.others, strict=True)]:
        for field in (name for name in one.__slots__ if name != "others"):
            off = getattr(one, field) - getattr(two, field)
            assert math.remainder(off, 2 * math.pi) == pytest.approx(0.0, abs=1e-5)
