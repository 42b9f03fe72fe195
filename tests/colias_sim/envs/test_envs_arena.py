"""Envs in an arena of one's own: nobody starts in an obstacle, it is felt, noticed and a part of the state."""

import math

import numpy as np
import pytest

from colias_sim.envs.geometry import HULL_RADIUS, gap_to_arena
from colias_sim.obstacles import Obstacle, outline
from colias_sim.pose import Pose
from tests.helpers.arenas import pillar, written
from tests.helpers.envs import bare, every_env


def with_pillars(folder, places, radius=0.02):
    body = "".join(pillar(x, y, radius).replace('name="pillar" ', "") for x, y in places)
    return written(folder, body, room="plain")


RING = [(0.3 * math.cos(a), 0.3 * math.sin(a)) for a in np.arange(12) * math.pi / 6]


@every_env
def test_no_robot_starts_in_an_obstacle(tmp_path, name):
    env = bare(name, arena=with_pillars(tmp_path, RING), observation="state")
    for seed in range(12):
        env.reset(seed=seed)
        for robot, pose in env.poses.items():
            gap = min(math.hypot(pose.x - x, pose.y - y) for x, y in RING) - 0.02 - HULL_RADIUS
            assert gap > -1e-4, robot


def test_touching_an_obstacle_ends_the_episode(tmp_path):
    env = bare("colias_sim/Avoidance-v0", arena=with_pillars(tmp_path, [(0.09, 0.0)]), robots=1, moving=0,
               observation="state")  # fmt: skip
    env.reset(seed=0, options={"poses": {"observer": (0.0, 0.0, 0.0), "parked1": (-30.0, 0.0, 0.0)}})
    ended = any(env.step(np.array([0.3, 0.3], np.float32))[2] for _ in range(60))
    x_cm = 100 * env.poses["observer"].x
    assert ended and x_cm == pytest.approx(5.0, abs=0.4), "hull at 7 cm, where the pillar begins"


def test_the_gap_is_that_to_the_nearer_of_wall_and_obstacle():
    box = Obstacle("box", outline(np.array([[0.1, -0.1, 0], [0.12, -0.1, 0], [0.12, 0.1, 0], [0.1, 0.1, 0]])), 0.1)
    here = Pose(0.0, 0.0, math.pi / 2)
    assert gap_to_arena(here, [box]) == pytest.approx((0.1 - HULL_RADIUS, -math.pi / 2), abs=1e-6)
    far = Pose(-0.4, 0.0, 0.0)
    assert gap_to_arena(far, [box]) == (pytest.approx(0.03), pytest.approx(math.pi))
