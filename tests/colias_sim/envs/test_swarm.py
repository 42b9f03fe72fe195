"""Swarms as agents: PettingZoo's laws, a robot of a swarm is that of a single env, and rows of one array."""

import warnings
from contextlib import ExitStack, closing

import numpy as np
import pytest
from gymnasium.error import ResetNeeded

import colias_sim
from colias_sim.envs.avoidance import Avoidance
from colias_sim.envs.geometry import random_poses
from colias_sim.envs.options import checked
from colias_sim.envs.swarm import Swarm, SwarmOptions
from colias_sim.streams import film

FACING = {"robot0": (-6.0, 0.0, 0.0), "robot1": (6.0, 0.0, 180.0)}
AHEAD = np.full(2, 0.5, np.float32)


@pytest.fixture
def made():
    pytest.importorskip("pettingzoo")
    with ExitStack() as envs:
        yield lambda **arguments: envs.enter_context(closing(colias_sim.swarm_env(**arguments)))


SKIPS = {"observation": "both", "frame_skip": 2}
STOPS = {"observation": "state", "actions": "manoeuvres", "crash": "stop"}
UNLIKE = {"observation": "pixels", "eyes": {"robot1": {"width": 50}}, "steps": 20}


@pytest.mark.parametrize("arguments", [SKIPS, STOPS, UNLIKE])
def test_the_laws_of_pettingzoo(made, arguments):
    from pettingzoo.test import parallel_api_test, parallel_seed_test

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(made(robots=3, **arguments), 60)
        parallel_seed_test(lambda: made(robots=3, **arguments), 20)


def test_a_step_needs_a_reset(made):
    with pytest.raises(ResetNeeded):
        made(robots=2, observation="state").step({})


class Alone(Avoidance):
    """The single env without another robot."""

    def _others(self):
        return {}

    def _begin(self, rng):
        return {"observer": random_poses(rng, 1)[0]}, {}


@pytest.mark.parametrize("observation", ["both", "events"])
def test_one_robot_of_a_swarm_is_that_of_a_single_env_to_the_bit(made, observation):
    """World, light, noise and responses, from the seed alone."""
    setting = {"observation": observation, "arena": "bright", "camera": "ov7670", "events": {"supersample_columns": 1}}
    one, single = made(robots=1, body="colias", **setting), Alone(**setting)
    seen, expected = one.reset(seed=5)[0], single.reset(seed=5)[0]
    for i in range(8):
        np.testing.assert_equal(seen["robot0"], expected)
        wheels = np.array([0.1, 0.02 * i], np.float32)
        seen, rewards, _, _, infos = one.step({"robot0": wheels})
        expected, reward, _, _, info = single.step(wheels)
        assert rewards["robot0"] == pytest.approx(reward) and infos["robot0"]["x_cm"] == info["x_cm"]
    single.close()


def test_the_noise_of_a_robot_is_its_own_whatever_the_number():
    draws = [film(3, robot).random(4).tolist() for robot in (0, 1, 2)]
    assert len({tuple(draw) for draw in draws}) == 3 and draws[0] == np.random.default_rng(3).random(4).tolist()


@pytest.mark.parametrize("crash", ["leave", "stop"])
def test_robots_that_crash_are_absent_and_stand_or_are_out_of_the_way(made, crash):
    """The third robot drives where the two have met."""
    env = made(robots=3, observation="state", crash=crash, steps=70)
    env.reset(seed=0, options={"poses": {**FACING, "robot2": (0.0, -25.0, 90.0)}})
    met = {}
    while env.agents:
        actions = {name: 0.6 * AHEAD if name == "robot2" else AHEAD for name in env.agents}
        _, rewards, terminated, truncated, _ = env.step(actions)
        for name in [name for name in rewards if terminated[name]]:
            met[name] = env._steps
            assert rewards[name] < -9 and name not in env.agents
    assert met["robot0"] == met["robot1"] < 25
    # Where they stand, it meets them; where they left, it drives to the end.
    assert ("robot2" in met) == (crash == "stop") and truncated.get("robot2", False) == (crash == "leave")


def test_rows_of_those_that_left_are_empty_until_the_world_ends(made):
    env = made(robots=3, observation="neural", steps=30)
    rows = env.rows()
    rows.reset(seed=0, options={"poses": {**FACING, "robot2": (0.0, -30.0, 0.0)}})
    actions, crashed = np.stack([AHEAD, AHEAD, 0 * AHEAD]), 30
    for step in range(1, 31):
        seen, rewards, terminated, truncated, info = rows.step(actions)
        assert seen.shape == (3, 7) and seen in rows.observation_space
        if terminated.any():
            crashed = step
            assert terminated.tolist() == [True, True, False] and not truncated.any()
            assert info["final_obs"][0].any() and info["final_obs"][2] is None
            assert info["final_info"]["reward_touch"][:2].tolist() == [-10.0, -10.0]
        elif crashed < step < 30:
            assert info["absent"].tolist() == [True, True, False] and not truncated.any()
            assert not seen[:2].any() and not rewards[:2].any()
    assert crashed < 25 and truncated.all() and not terminated.any()
    assert env.agents == env.possible_agents, "the next episode has begun"


def test_sb3_takes_the_rows_as_they_are(made):
    ppo = pytest.importorskip("stable_baselines3").PPO
    rows = made(robots=3, observation="neural", steps=12).rows().for_sb3()
    policy = ppo("MlpPolicy", rows, n_steps=16, batch_size=16, n_epochs=1, seed=0, device="cpu").learn(48)
    assert policy.num_timesteps == 48 and policy.predict(rows.reset())[0].shape == (3, 2)


def test_random_steps_of_thirty_robots_stay_in_the_arena():
    """No NaN, none through the wall, into another's hull or off the floor, and some touch."""
    swarm, rng = Swarm(checked(SwarmOptions, {"robots": 30, "observation": "state"})), np.random.default_rng(0)
    swarm.reset(dict(zip(swarm.agents, random_poses(rng, 30), strict=True)), rng, 0)
    for step in range(200):
        for agent in swarm.agents.values() if step % 10 == 0 else ():
            agent.command(rng.uniform(-0.2, 1.0, 2))
        swarm.advance(())
        places = np.array([(pose.x, pose.y, pose.heading) for pose in swarm.sim.poses.values()])
        assert np.isfinite(places).all() and np.hypot(*places[:, :2].T).max() < 0.45
        apart = np.hypot(*(places[:, None, :2] - places[None, :, :2]).transpose(2, 0, 1))
        assert apart[~np.eye(30, dtype=bool)].min() > 0.03  # contacts give way by some mm
        assert all(robot.height < 0.01 for robot in swarm.sim.robots.values())
    assert any(agent._touched for agent in swarm.agents.values())
    swarm.sim.close()
