"""Solids that viewers draw for a robot: those of its MJCF, of the robot's own size, facing ahead."""

import dataclasses
import math

import numpy as np
import pytest

from colias_sim import SceneConfig
from colias_sim.shapes import robot_shapes


@pytest.mark.parametrize("variant", ["colias", "colias_black"])
def test_a_colias_is_4_cm_across_and_3_cm_tall(variant):
    """The Colias papers' size."""
    solids = np.concatenate(list(robot_shapes(variant, SceneConfig()).values()))
    upright = solids[np.abs(solids["turn"][:, 0]) < 0.1]
    low = (upright["centre"] - upright["half_size"]).min(axis=0)
    high = (upright["centre"] + upright["half_size"]).max(axis=0)
    assert (high - low)[:2] == pytest.approx([0.04, 0.04], abs=0.001)
    assert high[2] == pytest.approx(0.03, abs=0.001) and low[2] >= 0.0


def test_the_shell_is_the_one_that_the_scene_asks_for():
    grey = SceneConfig(shell_grey=0.5, shell_width_cm=6.0, shell_height_cm=4.5)
    ((kind, shell),) = robot_shapes("colias_black", grey).items()
    assert kind == "cylinder" and shell["colour"].tolist() == [[128, 128, 128]]
    assert shell["half_size"][0] == pytest.approx([0.03, 0.03, 0.0225])
    card = SceneConfig(shell_shape="card", shell_width_cm=6.0, shell_height_cm=5.0)
    ((kind, shell),) = robot_shapes("colias_black", card).items()
    assert kind == "box" and shell["half_size"][0, 1:] == pytest.approx([0.03, 0.025])
    (turned,) = robot_shapes("colias_black", dataclasses.replace(card, shell_turn_deg=90.0)).values()
    assert shell["turn"][0].tolist() == [0.0, 0.0, 0.0, 1.0]
    assert turned["turn"][0] == pytest.approx([0.0, 0.0, *[math.sqrt(0.5)] * 2])
    ((kind, shell),) = robot_shapes("colias_black", SceneConfig(shell_shape="sphere", shell_width_cm=6.0)).items()
    assert kind == "ellipsoid" and shell["half_size"][0] == pytest.approx([0.03] * 3)
    own, usual = robot_shapes("colias", grey), robot_shapes("colias", SceneConfig())
    assert own.keys() == usual.keys() and all((own[kind] == usual[kind]).all() for kind in own), "it has no shell"
