"""The envs against physics and geometry: drive, walls, drum, push, other robots, and what the camera shows of them."""

import itertools
import math
from typing import Any

import numpy as np
import pytest

from colias_sim import CameraConfig
from tests.helpers.envs import NAMES, bare

FOCAL = CameraConfig().focal_px
HULL, RADIUS = 2.0, 45.0  # cm


@pytest.mark.parametrize("name", NAMES)
def test_no_action_throws_the_robot_over_or_through_anything(name):
    """Wheels flung from end to end: everybody stays upright, on the floor, in the arena, outside of the others."""
    follow = {"follow": True} if name == "colias_sim/Fixation-v0" else {}
    env = bare(name, observation="state", robots=4, **follow)
    fling = np.random.default_rng(0)
    for seed in range(3):
        env.reset(seed=seed)
        for _ in range(150):
            terminated = env.step(fling.choice([-1.0, 1.0], 2))[2]
            poses = env.poses
            for here, there in itertools.combinations(poses.values(), 2):
                assert math.hypot(here.x - there.x, here.y - there.y) > 0.038
            assert max(math.hypot(pose.x, pose.y) for pose in poses.values()) < (RADIUS - HULL + 0.5) / 100
            for robot in env._sim.robots.values():
                assert abs(robot.height) < 0.002
                _, qx, qy, _ = robot._qpos[3:]
                assert math.degrees(math.acos(1 - 2 * (qx**2 + qy**2))) < 8.0
            if terminated:
                break
    assert env._sim.data.warning.number.sum() == 0


def test_a_graze_that_begins_and_ends_within_a_frame_terminates():
    """A parked robot half a millimetre too near to the path: before and after that frame nothing touches."""
    env = bare("colias_sim/Avoidance-v0", observation="state", robots=1, moving=0)
    within = 0
    for start in (-8.0, -8.4, -8.8):
        env.reset(seed=0, options={"poses": {"observer": (start, 0.0, 0.0), "parked1": (0.0, 2 * HULL - 0.05, 0.0)}})
        apart, terminated = [], False
        while not terminated and len(apart) < 25:
            *_, terminated, _, info = env.step([1.0, 1.0])
            apart.append(math.hypot(info["x_cm"], info["y_cm"] - 2 * HULL + 0.05))
        assert terminated and info["touched"]
        within += min(apart[-2:]) > 2 * HULL
    assert within, "one of them at least touches neither at the frame's beginning nor at its end"


# The drum and the push.


def drum(rate_deg_s: float, **options: Any) -> Any:
    rates = {"slowest_deg_s": rate_deg_s, "fastest_deg_s": rate_deg_s}
    return bare("colias_sim/Optomotor-v0", **rates, noise=0.0, **options)


ROBOTS = [{}, {"motor_gain": 1e-4}, {"motor_gain": 4e-4}, {"wheel_radius_cm": 1.2}, {"track_cm": 2.6}, {"mass_g": 40.0}]


@pytest.mark.parametrize(("rate", "robot"), [(20.0, {}), (180.0, {}), *((90.0, robot) for robot in ROBOTS)])
def test_a_push_turns_any_robot_that_does_nothing_as_it_says(rate, robot):
    """Its servos, wheels, track and mass are its own; a gain that an episode draws counts too."""
    env = drum(rate, disturbance="push", observation="state", robot=robot)
    for seed, options in ((0, {}), (1, {}), (0, {"motor_gain": 1.2})):
        env.reset(seed=seed, options=options)
        *_, (*_, info) = (env.step([0.0, 0.0]) for _ in range(13))
        assert info["turn_deg_s"] == pytest.approx(info["drift_deg_s"], rel=0.1)
        assert info["slip_deg_s"] == info["turn_deg_s"], "the wall stands"


# The others.


@pytest.mark.parametrize("orbit_cm", [8.0, 35.0])
def test_the_target_stays_on_its_circle_and_reverses(orbit_cm):
    env = bare("colias_sim/Fixation-v0", observation="state", orbit_cm=orbit_cm, robots=6)
    env.reset(seed=1)
    angles = []
    for _ in range(600):
        terminated = env.step([0.0, 0.0])[2]
        target = env.poses["target"]
        assert not terminated
        assert 100 * math.hypot(target.x, target.y) == pytest.approx(orbit_cm, abs=1.0)
        angles.append(math.atan2(target.y, target.x))
    rates = np.degrees(np.diff(np.unwrap(angles))) * 30
    assert rates.min() < -8 and rates.max() > 8 and np.abs(rates).max() < 36.5


@pytest.mark.parametrize(
    ("name", "options"),
    [("Pursuit", {"target_speed_cm_s": 20.0}), ("Avoidance", {"robots": 12, "moving": 12, "speed_cm_s": 20.0})],
    ids=str,
)
def test_those_that_drive_about_touch_nothing_and_get_about(name, options):
    """Hull to hull and hull to wall; the observer, put away behind the rest, stands still."""
    env = bare(f"colias_sim/{name}-v0", observation="state", **options)
    movers = [mover for mover in env._sim.robots if mover != "observer"]
    driven, frames = 0.0, 0
    for seed in range(2):
        env.reset(seed=seed)
        for _ in range(200):
            before = env.poses
            terminated = env.step([0.0, 0.0])[2]
            if terminated:  # Pursuit's target does not heed the observer
                assert name == "Pursuit"
                break
            poses = env.poses
            for mover in movers:
                here = poses[mover]
                assert math.hypot(here.x, here.y) < (RADIUS - HULL - 0.4) / 100, "the panels are 0.4 cm nearer"
                for other, there in poses.items():
                    assert other in (mover, "observer") or math.hypot(here.x - there.x, here.y - there.y) > 0.0401
                frames += 1
                driven += math.hypot(here.x - before[mover].x, here.y - before[mover].y)
    speed = env.options.target_speed_cm_s if name == "Pursuit" else env.options.speed_cm_s
    assert frames > 100 and 100 * driven > 0.3 * speed * frames / 30


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("robots", [1, 20])
def test_nobody_stands_in_another_at_the_start(name, robots):
    env = bare(name, observation="state", robots=robots)
    starts = set()
    for seed in range(11):
        _, info = env.reset(seed=seed)
        poses = list(env.poses.values())
        starts.update((round(pose.x, 3), round(pose.heading, 3)) for pose in poses)
        assert not info["touched"] and len(poses) == robots + 1
        for here, there in itertools.combinations(poses, 2):
            assert math.hypot(here.x - there.x, here.y - there.y) > 2 * HULL / 100 + 0.005
        assert max(math.hypot(pose.x, pose.y) for pose in poses) < (RADIUS - HULL - 1.0) / 100
    assert len(starts) > 10, "each episode another"


def test_the_state_tells_where_the_others_are():
    """Geometry by hand: a robot 9 cm to the left of where the observer looks, others behind and ahead."""
    env = bare("colias_sim/Avoidance-v0", observation="state", robots=3, moving=0)
    poses = {"observer": (30.0, 0.0, 90.0), "parked1": (21.0, 0.0, 57.0), "parked2": (30.0, 20.0, 0.0),
             "parked3": (30.0, -10.0, 0.0)}  # fmt: skip
    env.reset(seed=0, options={"poses": poses})
    state = env.state
    beside, near, far = state.others
    assert (beside.distance, beside.bearing) == pytest.approx((0.05, -math.pi / 2), abs=1e-3)
    assert (near.distance, abs(near.bearing)) == pytest.approx((0.06, math.pi), abs=1e-3)
    assert (far.distance, far.bearing) == pytest.approx((0.16, 0.0), abs=1e-3)
    assert (state.wall_distance, state.wall_bearing) == pytest.approx((0.13, math.pi / 2), abs=1e-3)
    for _ in range(8):
        env.step([0.1, 0.1])
    assert env.state.speed == pytest.approx(0.035, rel=0.03)
    still = env.state.others[1]
    assert (still.ahead, still.left) == pytest.approx((-0.035, 0.0), abs=2e-3), "the parked goes back at our speed"


def test_the_state_tells_how_a_target_moves_as_its_poses_do():
    """Its velocity less ours, ahead and to the left of where we look, by differences of poses."""
    env = bare("colias_sim/Pursuit-v0", observation="state")
    env.reset(seed=2)
    for _ in range(12):
        env.step([0.12, 0.1])
    aside = []
    for _ in range(30):
        before, here = env.poses, env.poses["observer"]
        env.step([0.12, 0.1])
        after, other = env.poses, env.state.others[0]
        moved = {name: (after[name].x - before[name].x, after[name].y - before[name].y) for name in after}
        x, y = (30 * (there - ours) for there, ours in zip(moved["target"], moved["observer"], strict=True))
        cos, sin = math.cos(here.heading), math.sin(here.heading)
        assert (other.ahead, other.left) == pytest.approx((x * cos + y * sin, y * cos - x * sin), abs=0.01)
        aside.append(other.left)
    assert max(map(abs, aside)) > 0.015


def test_the_target_is_the_first_in_the_state_even_where_another_is_nearer():
    env = bare("colias_sim/Pursuit-v0", observation="state", robots=2)
    poses = {"observer": (0.0, 0.0, 0.0), "parked1": (0.0, 8.0, 0.0), "target": (20.0, 0.0, 0.0)}
    env.reset(seed=0, options={"poses": poses})
    assert [other.distance for other in env.state.others] == pytest.approx([0.16, 0.04], abs=5e-3), "it has begun to go"
