"""What many robots do and how it is measured."""

import math
from dataclasses import replace

import numpy as np
import pytest

from colias_sim.envs.crowd import Pedestrian, breaks, by_chance, chain, spread_cm
from colias_sim.envs.swarm import Body


def test_chance_is_that_of_discs_that_meet_in_a_gas():
    """Against straight ways of random discs without turning, counted on a torus of the same area."""
    rng, number, speed, diameter = np.random.default_rng(0), 12, 8.0, 4.0
    side = math.sqrt(math.pi * 43.0**2)
    place, way = rng.uniform(0, side, (number, 2)), rng.uniform(0, 2 * np.pi, number)
    velocity, met, before, step = speed * np.stack([np.cos(way), np.sin(way)], 1), 0, None, 0.02
    steps = 30_000
    for _ in range(steps):
        place = (place + velocity * step) % side
        apart = np.abs(place[:, None] - place[None])
        near = np.hypot(*np.minimum(apart, side - apart).transpose(2, 0, 1)) < diameter
        met += 0 if before is None else int((near & ~before).sum())
        before = near
    assert met / number / (steps * step / 60) == pytest.approx(by_chance(number, speed), rel=0.25)


def test_a_pedestrian_turns_away_from_the_wall_backs_off_and_heeds_its_alarm():
    rng = np.random.default_rng(0)
    far = Body(number=0, time_s=0.0, touched=False, wall_m=0.2, wall_bearing=0.0)
    walk = Pedestrian(lambda seen: seen, 0.2, rng)
    assert walk(0.0, far) == (0.2, 0.2)
    left, right = walk(1.0, far)
    assert left > 0 > right, "a turn to the right, as the alarm says"
    for _ in range(Pedestrian.FRAMES - 1):
        assert walk(-1.0, far) == (left, right), "it does not look while it turns"
    assert walk(-1.0, far) == (0.2, 0.2)
    near = replace(far, wall_m=0.01, wall_bearing=0.3)
    left, right = Pedestrian(lambda seen: 0.0, 0.2, rng)(0.0, near)
    assert left < 0 < right, "to the left of a wall on the right"
    assert Pedestrian(lambda seen: 0.0, 0.2, rng)(None, replace(far, touched=True)) == (-0.2, -0.2)


def test_links_of_a_chain():
    """Robots that drive on as they stand break no link; one that turns round, and one that falls behind, do."""
    start = np.array([(pose.x, pose.y, pose.heading) for pose in chain(np.random.default_rng(0), 4)])
    still = np.repeat(start[None], 40, axis=0)
    assert spread_cm(still) == 0.0 == breaks(still)
    turned, behind = still.copy(), still.copy()
    turned[:, 2, 2] += math.pi
    behind[20:, 3, :2] *= 3
    assert breaks(turned) == pytest.approx(1 / 3) == breaks(behind)
    assert spread_cm(behind) > 5
