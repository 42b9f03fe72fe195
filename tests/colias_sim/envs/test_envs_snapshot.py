"""States of envs: what was saved goes on to the bit, what is damaged or foreign is refused, nothing is forgotten."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from colias_sim.envs.fixation import Fixation
from colias_sim.snapshot import PARTS, SETTINGS
from dsnn import MODELS, Response
from tests.helpers.envs import FIXATION, bare, every_env
from tests.helpers.states import STEPS, drawn, play, unlisted

CASES = (18, 43, 44, 48, 69, 94)
ROOT = Path(__file__).parents[3]


def test_six_drawn_envs_go_on_to_the_bit(tmp_path):
    """From a random step, after other episodes, in another env, in a copy, and in another process."""
    expected = {}
    for seed in CASES:
        name, options, cut = drawn(seed)
        env = bare(name, **options)
        env.reset(seed=seed)
        play(env, seed, 0, cut)
        state, twin = env.get_state(), env.copy()
        (tmp_path / f"{seed}.state").write_bytes(state)
        expected[str(seed)] = play(env, seed, cut, STEPS)
        assert play(twin, seed, cut, STEPS) == expected[str(seed)], (seed, "copy")
        twin.close()
        env.reset(seed=seed + 1)
        play(env, seed + 1, 0, 20)
        env.set_state(state)
        assert play(env, seed, cut, STEPS) == expected[str(seed)], (seed, "after other episodes")
        env.close()
    command = [sys.executable, "-m", "tests.helpers.states", str(tmp_path)]
    told = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert json.loads(told.stdout) == expected


REST = {
    "Simulation": "model data scene camera_config obstacles everyone _queuing frame_interval _steps _command_steps"
    " command_interval _lamps _wall_quat eye_of _kind _robot _variants event_camera",
    "Robot": "name config _data _radius _track _forces _qpos _qvel _left _right",
    "ParkedRobot": "name _pos _quat",
    "Motors": "_config _step",
    "MotorBoard": "_slot _serial",
    "Camera": "_made_with _steps _eye _lamps offscreen _renders_of _falloff _tone _noise _kernel",
    "Rays": "_model _data _eye _own _steps _focal _step_ms shape _places _middle _axial _directions _robots _geoms"
    " _robot_of _body_of",
    "Sensor": "_eye _offscreen _grey _strips",
    "Wander": "_obstacles _robot _speed _unheeded",
    "Orbit": "_robot _centre _distance _rates",
    "ColiasEnv": SETTINGS,
    "Optomotor": "_rate _left",
}
"""Class -> attributes that are no state, or follow from it; of an env also what only a subclass has, which is state."""


@every_env
def test_every_attribute_is_in_a_list(name):
    """What a class of ours keeps, and no list has, would be forgotten."""
    env = bare(
        name, observation="both", camera="ov7670", robot={"command_slot_ms": 100.0, "power_step_cm_s": 0.06}, truth=True
    )
    env.reset(seed=0)
    env.step(env.action_space.sample())
    assert set(unlisted([env, env._sim], PARTS, REST)) == set()


def test_what_is_no_state_of_this_env_is_refused_and_changes_nothing():
    """Damaged anywhere, also within the parts' own states; of other arguments, another env or another model."""
    env = bare(FIXATION, observation="neural", model="lgmd1")
    env.reset(seed=0)
    state = env.get_state()
    others = [bare(FIXATION, observation="neural", **options) for options in ({"model": "emd"}, {"noise": 0.0})]
    wrong = [other.get_state() for other in (*others, bare("colias_sim/Pursuit-v0")) if other.reset(seed=0)]
    wrong += [state[: len(state) // 2], state + b"x"]
    wrong += [
        state[:at] + bytes([state[at] ^ 4]) + state[at + 1 :] for at in np.linspace(0, len(state) - 1, 40, dtype=int)
    ]
    for other in wrong:
        with pytest.raises(ValueError, match="must be"):
            env.set_state(other)
        assert env.get_state() == state


class Counting:
    """A user's model, which counts frames, without the two methods."""

    def __init__(self, shape):
        self.seen = 0

    def step(self, frame):
        self.seen += 1
        return Response(hs=1.0 / self.seen)

    def reset(self):
        self.seen = 0


class Saved(Counting):
    """The same with the two methods."""

    def get_state(self):
        return bytes([self.seen])

    def set_state(self, state):
        (self.seen,) = state


def test_a_users_model_brings_the_two_methods_or_can_only_be_copied():
    env = bare(FIXATION, observation="neural", model=Counting)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"Counting .*get_state"):
        env.get_state()
    twin = env.copy()
    assert env.step([0.1, 0.1])[0].tolist() == twin.step([0.1, 0.1])[0].tolist()
    env = bare(FIXATION, observation="neural", model=Saved)
    env.reset(seed=0)
    state = env.get_state()
    ahead = [env.step([0.1, 0.1])[0].tolist() for _ in range(3)]
    env.set_state(state)
    assert [env.step([0.1, 0.1])[0].tolist() for _ in range(3)] == ahead


class Hungry(Fixation):
    """A user's env, which keeps a number and a generator, and drives the target by a driver of its own."""

    def _begin(self, rng):
        places, drivers = super()._begin(rng)
        self.hunger, self.appetite = 0.0, np.random.default_rng(5)
        self.pace = float(rng.uniform())
        return places, {name: Slow(driver, self.pace) for name, driver in drivers.items()}

    def _reward(self):
        self.hunger += float(self.appetite.random())
        return {"hunger": self.hunger}


class Slow:
    """A driver with a drawn setting. What it keeps, its two methods save."""

    def __init__(self, driver, pace):
        self.driver, self.pace, self.calls = driver, pace, 0

    def wheels(self, dt, poses):
        self.calls += 1
        left, right = self.driver.wheels(dt, poses)
        return self.pace * left * (self.calls % 2), self.pace * right

    def get_state(self):
        return json.dumps(
            [self.calls, *(getattr(self.driver, name) for name in ("_left", "_speed", "_wanted"))]
        ).encode()

    def set_state(self, state):
        self.calls, self.driver._left, self.driver._speed, self.driver._wanted = json.loads(state)


def test_what_a_users_env_keeps_is_saved_or_named():
    """Numbers and generators are state; drivers are drawn again with their settings; anything else is named."""
    env, other = Hungry(observation="state"), Hungry(observation="state")
    try:
        env.reset(seed=1)
        for _ in range(20):
            env.step([0.3, -0.2])
        state, twin = env.get_state(), env.copy()
        ahead = [env.step([0.3, -0.2])[:2] for _ in range(90)]
        other.set_state(state)
        for restored in (other, twin):
            for (seen, reward), (expected, wanted) in zip(
                [restored.step([0.3, -0.2])[:2] for _ in range(90)], ahead, strict=True
            ):
                assert (seen.tolist(), reward) == (expected.tolist(), wanted)
        env.hunger = object()
        with pytest.raises(ValueError, match=r"^Hungry\.hunger "):
            env.get_state()
    finally:
        env.close()
        other.close()


def test_a_copy_has_its_own_texture_in_the_shared_context():
    """The twin's wall has another contrast: each sees its own, in turns, also after one of them is closed."""
    env = bare(FIXATION, noise=0.0, render_mode="rgb_array")
    env.reset(seed=0)
    twin = env.copy()
    expected, picture = env.step([0.0, 0.0])[0], env.render()
    assert (twin.step([0.0, 0.0])[0] == expected).all()
    assert (twin.render() == picture).all()
    state = env.get_state()
    twin.reset(seed=0, options={"wall": 0.2})
    assert (twin.step([0.0, 0.0])[0] != expected).any()
    assert (env.render() == picture).all()
    after = env.step([0.0, 0.0])[0]
    twin.set_state(state)
    env.close()
    assert (twin.step([0.0, 0.0])[0] == after).all()
    assert (twin.render() != picture).any()
    twin.close()


def test_a_state_beside_the_own_eye_is_small():
    env = bare(FIXATION, observation="neural", model=MODELS["dsnn"])
    env.reset(seed=0)
    assert len(env.get_state()) <= 1_200_000
