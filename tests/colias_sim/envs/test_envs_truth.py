"""What truly moved, in the info of the envs."""

from __future__ import annotations

import math

import numpy as np
import pytest

from colias_sim.truth import COLUMNS
from tests.helpers.envs import bare


def test_truth_changes_no_observation_and_is_that_of_the_target():
    """The target moves to the right in the picture where its bearing grows, as the robot turns to the left."""
    poses = {"poses": {"observer": (0.0, 0.0, 0.0), "target": (12.0, 0.0, 90.0)}}
    plain, told = bare("colias_sim/Fixation-v0"), bare("colias_sim/Fixation-v0", truth=True)
    (one, before), (other, info) = (env.reset(seed=3, options=poses) for env in (plain, told))
    assert set(info) - set(before) == set(COLUMNS) and np.array_equal(one, other)
    assert math.isnan(info["true_flow_x"]) and info["true_share"] > 0.05
    for _ in range(5):
        (one, *_), (other, *_, now) = (env.step([-0.04, 0.04]) for env in (plain, told))
        assert np.array_equal(one, other)
        moved, info = now["bearing_deg"] - info["bearing_deg"], now
    assert now["true_flow_x"] == pytest.approx(70.7 * math.radians(moved), rel=0.2) and moved > 0.5
    assert told.truth().mask(["target"]).mean() == now["true_share"]


def test_the_wall_is_what_moves_where_no_robot_drives_whatever_the_tilt():
    """A standing robot in a turning drum sees the wall's rate; a tilted camera too, in its own frame.

    Over the view the flow is 1 + tan^2 of the angle times that on the axis, 1.163 in the mean, and the lens is ahead.
    """
    rate = {"slowest_deg_s": 50.0, "fastest_deg_s": 50.0}
    env = bare("colias_sim/Optomotor-v0", truth=True, randomise={"tilt": (-3.0, 3.0)}, **rate)
    env.reset(seed=1)
    for _ in range(4):
        *_, info = env.step([0.0, 0.0])
    assert info["true_flow_x"] == pytest.approx(
        70.7 * 1.163 * 0.45 / 0.43 * math.radians(info["slip_deg_s"]) / 30, rel=0.05
    )
    assert abs(info["slip_deg_s"]) == pytest.approx(abs(info["drift_deg_s"]), abs=0.1) == pytest.approx(50.0, abs=0.1)
    assert np.nanmax(np.abs(env.truth().flow[env.truth().mask(["floor"])])) < 0.01


def test_a_policy_of_the_state_has_no_picture():
    with pytest.raises(ValueError, match="observation must be pixels"):
        bare("colias_sim/Fixation-v0", truth=True, observation="state")
