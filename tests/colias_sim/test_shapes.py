"""Solids that viewers draw for a robot: those of its MJCF, of the robot's own size, facing ahead."""

from __future__ import annotations

import numpy as np
import pytest

from colias_sim import SceneConfig
from colias_sim.shapes import robot_shapes


def extent(shapes) -> np.ndarray:
    """Highest and lowest corner of upright solids, (2, 3)."""
    low = [np.subtract(shape.centre, shape.half_size) for shape in shapes]
    high = [np.add(shape.centre, shape.half_size) for shape in shapes]
    return np.array([np.min(low, axis=0), np.max(high, axis=0)])


@pytest.mark.parametrize("variant", ["colias", "colias_black"])
def test_a_colias_is_4_cm_across_and_3_cm_tall(variant):
    """The Colias papers' size."""
    upright = [shape for shape in robot_shapes(variant, SceneConfig()) if abs(shape.turn[0]) < 0.1]
    low, high = extent(upright)
    assert (high - low)[:2] == pytest.approx([0.04, 0.04], abs=0.001)
    assert high[2] == pytest.approx(0.03, abs=0.001) and low[2] >= 0.0


def test_the_shell_is_the_one_that_the_scene_asks_for():
    grey = SceneConfig(shell_grey=0.5)
    (shell,) = robot_shapes("colias_black", grey)
    assert shell.kind == "cylinder" and shell.colour == (128, 128, 128)
    card = SceneConfig(shell_shape="card", shell_width_cm=6.0, shell_height_cm=5.0)
    (shell,) = robot_shapes("colias_black", card)
    assert shell.kind == "box" and shell.half_size[1:] == pytest.approx((0.03, 0.025))
    (shell,) = robot_shapes("colias_black", SceneConfig(shell_shape="sphere", shell_width_cm=6.0))
    assert shell.kind == "ellipsoid" and shell.half_size == pytest.approx((0.03,) * 3)
    assert robot_shapes("colias", grey) == robot_shapes("colias", SceneConfig()), "it has no shell"
