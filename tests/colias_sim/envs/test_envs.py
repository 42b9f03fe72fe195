"""The envs against Gymnasium's contract, whatever is registered: spaces, seeds, ends, rewards."""

import dataclasses

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import dsnn
from colias_sim.envs import NEURAL
from colias_sim.envs.senses import MANOEUVRES
from tests.helpers.envs import FIXATION, SENSES, bare, episode, every_env, fingerprint

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
    robots, box, spaces = 2, gym.spaces.Box, {}
    for observation in SENSES:
        env = bare(name, observation=observation, robots=robots)
        spaces[observation] = env.observation_space
        assert env.action_space == box(-1.0, 1.0, (2,), np.float32)
    assert spaces["pixels"] == box(0, 255, (72, 99, 1), np.uint8)
    assert spaces["state"] == box(-1.0, 1.0, (7 + 5 * robots,), np.float32)
    nerves = spaces["neural"]
    assert nerves.shape == (len(NEURAL),) == (7,)
    np.testing.assert_array_equal(nerves.low, [-1, -1, -10, -10, 0, 0, -1])
    np.testing.assert_array_equal(nerves.high, [1, 1, 10, 10, 1, 10, 1])
    assert spaces["both"] == gym.spaces.Dict({"pixels": spaces["pixels"], "neural": nerves})
    env = bare(name, actions="manoeuvres", observation="state")
    assert env.action_space == gym.spaces.Discrete(len(MANOEUVRES)) == gym.spaces.Discrete(7)


class Stated:
    """A user's model that gives a stated response, one more of HS at each frame."""

    def __init__(self, response: dsnn.Response) -> None:
        self.response, self.frames = response, 0

    def step(self, frame: np.ndarray) -> dsnn.Response:
        assert frame.shape == (72, 99) and frame.dtype == np.uint8
        self.frames += 1
        return dataclasses.replace(self.response, hs=self.response.hs * self.frames)

    def reset(self) -> None:
        self.frames = 0


def test_neural_observations_stay_in_the_space_and_spikes_of_skipped_frames_are_summed():
    beyond = dsnn.Response(9.0, -9.0, 99, -99, looming=9.0, looming_spikes=99, azimuth=-9.0)
    env = bare(FIXATION, observation="neural", model=lambda shape: Stated(beyond), noise=10.0, frame_skip=30)
    for observation, *_ in episode(env, seed=1, steps=3):
        assert env.observation_space.contains(observation)
    few = dsnn.Response(hs=0.01, hs_spikes=1, vs_spikes=-1, looming=0.25, looming_spikes=1, azimuth=-0.5)
    env = bare(FIXATION, observation="neural", model=lambda shape: Stated(few), frame_skip=3)
    for _ in range(2):
        first, _ = env.reset(seed=0)
        assert first.tolist() == pytest.approx([0.01, 0.0, 1, -1, 0.25, 1, -0.5])
        then, *_ = env.step([0.0, 0.0])
        assert then.tolist() == pytest.approx([0.04, 0.0, 3, -3, 0.25, 3, -0.5])


# Seeds.


@every_env
def test_a_seed_decides_everything(name):
    env, other = (
        bare(name, observation="both", camera="ov7670", randomise="domain", actions="manoeuvres") for _ in range(2)
    )
    first = fingerprint(episode(env, seed=5, steps=8))
    assert fingerprint(episode(env, seed=6, steps=8)) != first
    env.reset()
    env.step(env.action_space.sample())  # in mid-episode
    assert fingerprint(episode(env, seed=5, steps=8)) == first == fingerprint(episode(other, seed=5, steps=8))
    # The episodes that follow a seed are decided too, and differ.
    second = fingerprint([other.reset()])
    assert second == fingerprint([env.reset()]) != fingerprint([env.reset()])


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
    assert len(told[0]) > 5
    for other in told[1:]:
        assert fingerprint(other) == fingerprint(told[0])


# Rewards.


@every_env
def test_a_skipped_frame_is_as_a_step_of_its_own(name):
    """Four frames in one step: the world of four steps, and the means of their terms."""
    once, fours = bare(name, observation="state"), bare(name, observation="state", frame_skip=4)
    once.reset(seed=9)
    fours.reset(seed=9)
    for action in ([0.2, 0.1], [0.0, 0.3]):
        infos = [once.step(action)[-1] for _ in range(4)]
        _, reward, terminated, _, info = fours.step(action)
        assert not terminated and once.poses == fours.poses
        terms = [key for key in info if key.startswith("reward_")]
        assert len(terms) > 1 and reward == pytest.approx(sum(info[term] for term in terms))
        for term in terms:
            assert info[term] == pytest.approx(np.mean([one[term] for one in infos]), abs=1e-12)
        assert info["driven_cm"] == pytest.approx(sum(one["driven_cm"] for one in infos), abs=1e-12)


class Watcher(Stated):
    """A model that keeps the frames that it saw."""

    def __init__(self) -> None:
        super().__init__(dsnn.Response())
        self.seen: list[np.ndarray] = []

    def step(self, frame: np.ndarray) -> dsnn.Response:
        self.seen.append(frame.copy())
        return super().step(frame)


def test_a_slow_processor_takes_the_last_of_every_few_frames_and_the_camera_goes_on():
    """Exposure, noise, lost frames and the robots' way are those of an env whose model sees every frame."""
    camera = {"preset": "ov7670", "drop_probability": 0.3}
    seen = []
    for options in ({"frame_skip": 4}, {"frame_skip": 4, "processor": {"every": 2}}, {"processor": {"every": 4}}):
        watcher = Watcher()
        env = bare(FIXATION, observation="neural", model=lambda _, own=watcher: own, camera=camera, **options)
        episode(env, seed=3, steps=3)
        assert env.options.frames_per_step == 4
        seen.append(np.array(watcher.seen))
    every, second, fourth = seen  # the first frame is that of the reset
    np.testing.assert_array_equal(second, every[[0, 2, 4, 6, 8, 10, 12]])
    np.testing.assert_array_equal(fourth, every[[0, 4, 8, 12]])
    with pytest.raises(ValueError, match=r"frame_skip must be a multiple of processor\.every=2, got 3"):
        bare(FIXATION, processor={"every": 2}, frame_skip=3)
