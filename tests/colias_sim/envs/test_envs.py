"""The envs against Gymnasium's contract, whatever is registered: spaces, seeds, ends, rewards."""

import math
import subprocess
import sys
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import error
from gymnasium.utils.env_checker import check_env

import dsnn
from colias_sim import Pose
from colias_sim.envs import ENVS, NEURAL
from colias_sim.envs.base import TOUCH_COST, ColiasEnv
from colias_sim.envs.senses import MANOEUVRES
from scenes import ARENAS
from tests.helpers.envs import AHEAD, FIXATION, NAMES, SENSES, bare, episode, every_env, fingerprint, robots_at_ends


def touches_on_purpose(env: ColiasEnv[Any]) -> None:
    """Reset, and drive straight at the wall, whatever is between."""
    env.reset(seed=3)
    env._sim.reset(spread(env) | {"observer": Pose(0.36, 0.0, 0.0)}, np.random.default_rng(0))


def spread(env: ColiasEnv[Any]) -> dict[str, Pose]:
    """Everybody but the observer on a grid far from where it drives."""
    others = [name for name in env.poses if name != "observer"]
    return {name: Pose(-0.12 - 0.07 * (i // 5), -0.16 + 0.08 * (i % 5), 0.0) for i, name in enumerate(others)}


# Registered, and as documented.


@every_env
@pytest.mark.parametrize(("observation", "actions"), [("both", "wheels"), ("state", "manoeuvres")])
def test_gymnasium_s_own_checks(name, observation, actions):
    env = gym.make(name, observation=observation, actions=actions, render_mode="rgb_array", render_width=64)
    # It warns, and so fails, of what is not as it should be; pictures do not depend on what is observed.
    check_env(env.unwrapped, skip_render_check=observation != "both")
    env.close()


@every_env
def test_spaces_are_those_of_the_docstring(name):
    low, _ = robots_at_ends(name)
    robots = max(low, 2)
    box = gym.spaces.Box
    spaces = {}
    for observation in SENSES:
        env = bare(name, observation=observation, robots=robots)
        spaces[observation] = env.observation_space
        assert env.action_space == box(-1.0, 1.0, (2,), np.float32)
        env.close()
    assert spaces["pixels"] == box(0, 255, (72, 99, 1), np.uint8)
    assert spaces["state"] == box(-1.0, 1.0, (7 + 5 * robots,), np.float32)
    nerves = spaces["neural"]
    assert nerves.shape == (len(NEURAL),) == (7,)
    np.testing.assert_array_equal(nerves.low, [-1, -1, -10, -10, 0, 0, -1])
    np.testing.assert_array_equal(nerves.high, [1, 1, 10, 10, 1, 10, 1])
    assert spaces["both"] == gym.spaces.Dict({"pixels": spaces["pixels"], "neural": nerves})
    env = bare(name, actions="manoeuvres", observation="state")
    assert env.action_space == gym.spaces.Discrete(len(MANOEUVRES)) == gym.spaces.Discrete(7)
    env.close()


class Shouter:
    """A user's model: answers beyond every range."""

    hs, vs, hs_spikes, vs_spikes, looming, looming_spikes, azimuth = 9.0, -9.0, 99, -99, 9.0, 99, -9.0

    def __init__(self, shape: tuple[int, int]) -> None:
        assert shape == (72, 99)

    def step(self, frame: np.ndarray) -> "Shouter":
        assert frame.shape == (72, 99) and frame.dtype == np.uint8
        return self

    def reset(self) -> None:
        pass


MODELS = ("dsnn", "lgmd1", "flow", Shouter, "hybrid")
VARIANTS: list[dict[str, Any]] = [
    *({"observation": "neural", "model": MODELS[i % 5], "arena": arena} for i, arena in enumerate(ARENAS)),
    {"observation": "both", "frame_skip": 3, "noise": 0.0},
    {"observation": "both", "frame_skip": 30, "noise": 10.0, "randomise": 1.0},
]


@every_env
@pytest.mark.parametrize("options", VARIANTS, ids=str)
def test_observations_stay_in_the_space_whatever_is_set(name, options):
    env = bare(name, **options)
    for observation, *_ in episode(env, seed=1, steps=3):
        assert env.observation_space.contains(observation)
    env.close()


@every_env
def test_from_the_fewest_robots_to_the_most(name):
    for robots in robots_at_ends(name):
        env = bare(name, robots=robots, observation="state")
        assert len(env.poses) == robots + 1
        for observation, *_ in episode(env, seed=1, steps=6):
            assert env.observation_space.contains(observation)
        env.close()


# Seeds.


@every_env
def test_a_seed_decides_everything(name):
    env, other = (bare(name, observation="both", randomise=1.0, actions="manoeuvres") for _ in range(2))
    first = fingerprint(episode(env, seed=5, steps=8))
    assert fingerprint(episode(env, seed=6, steps=8)) != first
    env.reset()
    env.step(env.action_space.sample())  # in mid-episode
    assert fingerprint(episode(env, seed=5, steps=8)) == first == fingerprint(episode(other, seed=5, steps=8))
    # The episodes that follow a seed are decided too, and differ.
    second = fingerprint([other.reset()])
    assert second == fingerprint([env.reset()]) != fingerprint([env.reset()])
    env.close()
    other.close()


def test_a_seed_decides_everything_in_another_process_too():
    """One that makes the envs by their module, and to which nothing gives a warning."""
    code = (
        "import gymnasium; gymnasium.make('colias_sim:colias_sim/Fixation-v0').close()\n"
        "from tests.helpers.envs import *\n"
        "for name in NAMES: print(fingerprint(episode(bare(name, observation='both'), seed=5, steps=5)))"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=True)
    assert not done.stderr
    for name, there in zip(NAMES, done.stdout.split("\n"), strict=False):
        env = bare(name, observation="both")
        episode(env, seed=4, steps=2)
        assert there == fingerprint(episode(env, seed=5, steps=5)), name
        env.close()


@every_env
def test_what_happens_does_not_depend_on_what_is_observed_or_shown(name):
    """Poses and rewards to the last bit: baselines that see and those that know are compared in pairs."""
    told = []
    for options in (
        {"observation": "state"},
        {"observation": "pixels", "noise": 0.0},
        {"observation": "neural", "model": "flow", "noise": 2.0},
        {"observation": "state", "render_mode": "rgb_array", "render_width": 32, "render_height": 24},
    ):
        env = bare(name, **options)
        told.append([(info, rest[:2]) for _, *rest, info in episode(env, seed=2, steps=10)])
        env.close()
    assert len(told[0]) > 5
    for other in told[1:]:
        assert fingerprint(other) == fingerprint(told[0])


@every_env
def test_observations_are_the_agent_s_to_keep(name):
    env = bare(name, observation="both")
    first, _ = env.reset(seed=1)
    kept = fingerprint([first])
    for _ in range(3):
        env.step([1.0, -1.0])
    assert fingerprint([first]) == kept
    env.close()


# Ends.


@every_env
def test_a_touch_terminates_at_its_price(name):
    env = bare(name, observation="state", **({"follow": True} if name == FIXATION else {}))
    touches_on_purpose(env)
    for _ in range(60):
        _, reward, terminated, truncated, info = env.step(AHEAD)
        assert info["touched"] == terminated == (info["reward_touch"] != 0.0) and not truncated
        if terminated:
            break
    assert terminated and info["reward_touch"] == -TOUCH_COST and reward < -TOUCH_COST / 2
    assert math.hypot(info["x_cm"], info["y_cm"]) == pytest.approx(43.0, abs=0.6)  # hull against panel
    with pytest.raises(error.ResetNeeded):
        env.step(AHEAD)
    _, info = env.reset(seed=1)
    assert not info["touched"]
    env.step(AHEAD)
    env.close()


@every_env
def test_the_time_limit_truncates(name):
    limit = ENVS[name].max_episode_steps
    env = gym.make(name, observation="state", actions="manoeuvres")
    assert env.spec is not None and env.spec.max_episode_steps == limit
    env = gym.make(name, observation="state", actions="manoeuvres", max_episode_steps=4)
    env.reset(seed=0)
    ends = [env.step(0)[2:4] for _ in range(4)]
    assert ends == [(False, False)] * 3 + [(False, True)]
    env.close()


@every_env
def test_out_of_turn_is_told_clearly(name):
    env = bare(name, observation="state", render_mode="rgb_array")
    with pytest.raises(error.ResetNeeded):
        env.step(AHEAD)
    with pytest.raises(error.ResetNeeded):
        env.render()
    with pytest.raises(ValueError, match="level"):
        env.reset(options={"level": 3})
    env.reset(seed=0, options={})
    env.close()
    env.close()
    for late in (env.reset, env.render, lambda: env.step(AHEAD)):
        with pytest.raises(error.ClosedEnvironmentError):
            late()


# Rewards.


@every_env
@pytest.mark.parametrize("frame_skip", [1, 4])
def test_the_reward_is_the_sum_of_its_terms(name, frame_skip):
    env = bare(name, observation="state", frame_skip=frame_skip)
    for _, reward, terminated, _, info in episode(env, seed=8)[1:]:
        terms = {key: value for key, value in info.items() if key.startswith("reward_")}
        assert set(terms) > {"reward_touch"}
        assert reward == pytest.approx(sum(terms.values()), abs=1e-12)
        assert -2.0 <= reward - info["reward_touch"] <= 2.0
        assert info["reward_touch"] == (-TOUCH_COST if terminated else 0.0)
    env.close()


@every_env
def test_a_skipped_frame_is_as_a_step_of_its_own(name):
    """Four frames in one step: the world of four steps, and the means of their terms."""
    once, fours = bare(name, observation="state"), bare(name, observation="state", frame_skip=4)
    once.reset(seed=9)
    fours.reset(seed=9)
    for action in ([0.2, 0.1], [0.0, 0.3]):
        infos = [once.step(action)[-1] for _ in range(4)]
        _, _, terminated, _, info = fours.step(action)
        assert not terminated and once.poses == fours.poses
        for term in (key for key in info if key.startswith("reward_")):
            assert info[term] == pytest.approx(np.mean([one[term] for one in infos]), abs=1e-12)
        assert info["driven_cm"] == pytest.approx(sum(one["driven_cm"] for one in infos), abs=1e-12)
    once.close()
    fours.close()


def test_neural_spikes_of_skipped_frames_are_summed():
    class Clock:
        """Counts the frames that it was shown."""

        def __init__(self, shape: tuple[int, int]) -> None:
            self.count = 0

        def step(self, frame: np.ndarray) -> dsnn.Response:
            self.count += 1
            return dsnn.Response(hs=self.count / 100, vs=0.0, hs_spikes=1, vs_spikes=-1)

        def reset(self) -> None:
            self.count = 0

    env = bare(NAMES[0], observation="neural", model=Clock, frame_skip=3)
    for _ in range(2):
        first, _ = env.reset(seed=0)
        assert first[:4].tolist() == pytest.approx([0.01, 0.0, 1, -1])
        then, *_ = env.step([0.0, 0.0])
        assert then[:4].tolist() == pytest.approx([0.04, 0.0, 3, -3])
    env.close()
