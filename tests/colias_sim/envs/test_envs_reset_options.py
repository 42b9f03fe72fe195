"""The options of a reset: for one episode, checked, and no draw of another kind changes."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from colias_sim import CameraConfig
from colias_sim.envs.randomise import FACTORS
from tests.helpers.envs import bare, every_env, fingerprint

FIXATION, AVOIDANCE = "colias_sim/Fixation-v0", "colias_sim/Avoidance-v0"
GIVEN: dict[str, Any] = {
    "light": 0.6, "noise": 2.0, "ae_target": 90.0, "row_time_us": 300.0, "blur_px": 1.0, "tilt": (4.0, -3.0),
    "wall": 0.5, "shell": 0.4, "start": (2.0, -1.0), "mass_g": 40.0, "motor_gain": 0.5, "wheel_gain": (0.8, 1.2),
    "latency_ms": 50.0,
}  # fmt: skip


def played(env: gym.Env[Any, Any], seed: int = 3, steps: int = 4, **options: Any) -> list[Any]:
    """An episode of steady driving, without the names of what was drawn or given."""
    told = [env.reset(seed=seed, options=options or None)]
    told[0][1].pop("randomised", None)
    return told + [env.step(np.array([0.2, 0.3], np.float32)) for _ in range(steps)]


def test_every_factor_can_be_given():
    assert set(GIVEN) == set(FACTORS)


@pytest.mark.parametrize("factor", FACTORS)
def test_a_given_value_is_that_of_a_range_with_equal_ends(factor):
    """A law between two ways to ask for one thing; and the next reset has forgotten it."""
    ends = {factor: GIVEN[factor]} if np.ndim(GIVEN[factor]) == 0 else None
    env = bare(FIXATION, camera="ov7670")
    plain = fingerprint(played(env))
    given = fingerprint(played(env, **{factor: GIVEN[factor]}))
    assert given != plain
    assert fingerprint(played(env)) == plain, "an option holds for one episode"
    assert fingerprint(played(env, **{factor: GIVEN[factor]})) == given, "equal seed and options, equal episode"
    env.close()
    if ends is not None:
        drawn = bare(FIXATION, camera="ov7670", randomise={factor: (GIVEN[factor],) * 2})
        assert fingerprint(played(drawn)) == given
        drawn.close()


@pytest.mark.parametrize("camera", [{"auto_exposure": True}, {"gain": 1.5}, {"auto_exposure": True, "gain": 1.5}])
def test_an_eye_with_a_loop_or_a_gain_alone_takes_options(camera):
    env = bare(FIXATION, camera=CameraConfig(**camera))
    noisy, still = (env.reset(seed=0, options={"noise": noise})[0] for noise in (1.0, 0.0))
    assert not np.array_equal(noisy, still)
    env.close()


def test_a_given_value_changes_no_other_draw():
    ranges = {"light": (0.7, 1.3), "noise": (0.5, 2.0), "mass_g": (20.0, 40.0)}
    env = bare(AVOIDANCE, observation="state", randomise=ranges)
    drawn = env.reset(seed=4)[1]["randomised"]
    given = env.reset(seed=4, options={"light": 0.5})[1]["randomised"]
    assert given == {**drawn, "light": 0.5}
    assert env.reset(seed=4)[1]["randomised"] == drawn
    env.close()
    env = bare(AVOIDANCE, observation="state", randomise=0.5)
    drawn = env.reset(seed=4)[1]["randomised"]
    given = env.reset(seed=4, options={"tilt": (1.0, 2.0)})[1]["randomised"]
    assert given == {**drawn, "pitch_deg": 1.0, "yaw_deg": 2.0}
    env.close()


def test_a_wrong_first_reset_leaves_an_env_that_works():
    """Gymnasium's checker of a first reset, which would fail at every later step, is not in the way."""
    env = gym.make(FIXATION, observation="state")
    with pytest.raises(ValueError, match="light"):
        env.reset(options={"ligth": 0.5})
    env.reset(seed=0, options={"light": 0.5})
    env.step(np.zeros(2, np.float32))
    env.close()


def test_a_latency_is_that_of_the_nearest_control_interval():
    env = bare(FIXATION, observation="state")
    interval_ms = 1000 / 60  # two commands in a frame of 1/30 s
    episodes = {share: fingerprint(played(env, latency_ms=share * interval_ms)) for share in (0, 0.4, 0.6, 1, 1.4, 1.6)}
    assert episodes[0] == episodes[0.4] != episodes[1]
    assert episodes[0.6] == episodes[1] == episodes[1.4] != episodes[1.6]
    env.close()


# Start poses.


@every_env
def test_a_robot_starts_where_it_is_put(name):
    env = bare(name, observation="state")
    env.reset(seed=1)
    before = env.poses
    info = env.reset(seed=1, options={"poses": {"observer": (-30.0, 12.0, 90.0)}})[1]
    assert (info["x_cm"], info["y_cm"], info["heading_deg"]) == pytest.approx((-30.0, 12.0, 90.0), abs=0.02)
    after = env.poses
    for robot, pose in before.items():
        if robot != "observer" and math.hypot(pose.x + 0.3, pose.y - 0.12) > 0.051:
            assert after[robot] == pose, "others start where the seed puts them"
    assert not info["touched"]
    env.close()


def test_robots_in_the_way_are_drawn_anew():
    env = bare(AVOIDANCE, observation="state", robots=20)
    env.reset(seed=2)
    there = env.poses["parked3"]
    place = 100 * there.x, 100 * there.y, 0.0
    poses = [env.reset(seed=2, options={"poses": {"observer": place}}) and env.poses for _ in range(2)]
    assert poses[0] == poses[1]
    for name, pose in poses[0].items():
        gaps = [math.hypot(pose.x - o.x, pose.y - o.y) for other, o in poses[0].items() if other != name]
        assert min(gaps) > 0.0495
    env.close()


# Vector envs.


def test_vector_envs_pass_options_on():
    options: dict[str, Any] = {"light": 0.5, "poses": {"observer": (5.0, 0.0, 0.0)}}
    many = gym.make_vec(FIXATION, num_envs=2, max_episode_steps=2)
    batch, infos = many.reset(seed=7, options=options)
    with pytest.raises(ValueError, match="light"):
        many.reset(options={"light": 9})
    one = bare(FIXATION)
    for k in range(2):
        np.testing.assert_array_equal(batch[k], one.reset(seed=7 + k, options=options)[0])
    assert infos["x_cm"] == pytest.approx([5.0, 5.0], abs=0.02)
    for _ in range(3):  # two steps, and the autoreset
        *_, infos = many.step(np.zeros((2, 2), np.float32))
    assert infos["x_cm"] == pytest.approx([0.0, 0.0], abs=0.02), "a later episode has no options"
    mask = np.array([False, True])
    _, infos = many.reset(options={"reset_mask": mask, "light": 0.5})
    assert infos["_randomised"].tolist() == [False, True]
    many.close()
    one.close()


# Refusals.


BAD: list[dict[str, Any]] = [
    {"ligth": 0.5}, {"light": 3.0}, {"light": math.nan}, {"light": "dim"}, {"light": (0.5, 0.6)},
    {"tilt": 3.0}, {"ae_target": 90.0}, {"row_time_us": 300.0}, {"poses": {"target": (0, 0, 0), "observer": (0, 0, 0)}},
    {"poses": {"targt": (0, 0, 0)}}, {"poses": {"target": (43, 0, 0)}},
    {"poses": {"target": (0, 0, 0), "observer": (4, 0, 0)}}, {"poses": {"observer": (0, 0, math.nan)}},
]  # fmt: skip


def test_a_bad_option_is_named_and_changes_nothing():
    env = bare(FIXATION, observation="state")
    env.reset(seed=0)
    expected = fingerprint([env.reset()])
    env.reset(seed=0)
    for options in BAD:
        with pytest.raises(ValueError, match=next(iter(options))):
            env.reset(seed=5, options=options)
    assert fingerprint([env.reset()]) == expected, "a refused reset draws nothing"
    env.close()
