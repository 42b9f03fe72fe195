"""``randomise`` by factor: one seed, one episode; each factor changes what it says, as if compiled so, and no more."""

import dataclasses
import functools
import math
from typing import Any

import gymnasium as gym
import mujoco
import numpy as np
import pytest

from colias_sim import CameraConfig, RobotConfig, SceneConfig
from colias_sim.envs.geometry import CLEARANCE, gap_to_robot, gap_to_wall
from colias_sim.envs.randomise import FACTORS, PRESETS
from colias_sim.scene import compile_model
from tests.helpers.envs import bare, episode, fingerprint

OPTOMOTOR, FIXATION, AVOIDANCE = (f"colias_sim/{name}-v0" for name in ("Optomotor", "Fixation", "Avoidance"))
EYE = "ov7670"
WIDE: dict[str, tuple[float, float]] = {
    "light": (0.5, 1.5), "noise": (0.0, 3.0), "ae_target": (60.0, 150.0), "row_time_us": (100.0, 450.0),
    "blur_px": (0.0, 3.0), "tilt": (-10.0, 10.0), "wall": (0.2, 0.9), "shell": (0.0, 0.9), "start": (-4.0, 4.0),
    "mass_g": (15.0, 60.0), "motor_gain": (0.3, 2.0), "wheel_gain": (0.7, 1.3), "latency_ms": (0.0, 200.0),
}  # fmt: skip
SEEN = {"light", "noise", "ae_target", "row_time_us", "blur_px", "tilt", "wall", "shell"}
"""Factors of what is seen; the others are of what happens."""
every_factor = pytest.mark.parametrize("factor", FACTORS)


def told(name: str = FIXATION, steps: int = 8, seed: int = 3, **options: Any) -> list[Any]:
    """An episode of an env with the robot's eye, without the names of what was drawn."""
    env = bare(name, **{"camera": EYE, "robots": 2, **options})
    transitions = episode(env, seed=seed, steps=steps)
    env.close()
    return [
        (transitions[0][0], {key: value for key, value in transitions[0][1].items() if key != "randomised"}),
        *transitions[1:],
    ]


@functools.cache
def plainly() -> list[Any]:
    return told()


def happened(transitions: list[Any]) -> str:
    return fingerprint([rest for _, *rest in transitions])


def test_every_factor_is_tested():
    assert set(WIDE) == set(FACTORS)


# Seeds.


def test_one_seed_one_episode_whatever_was_played_before():
    one, other = (bare(FIXATION, camera=EYE, randomise=WIDE, robots=3) for _ in range(2))
    first = fingerprint(episode(one, seed=5, steps=6))
    assert fingerprint(episode(one, seed=6, steps=6)) != first
    assert fingerprint(episode(one, seed=5, steps=6)) == first
    assert fingerprint(episode(other, seed=5, steps=6)) == first
    assert one.reset()[1]["randomised"] == other.reset()[1]["randomised"] != one.reset()[1]["randomised"]
    one.close()
    other.close()


@every_factor
def test_a_factor_s_draws_are_its_own(factor):
    """The same alone as among all others, within its ends, and each part a draw of its own."""

    def drawn(ranges: dict[str, tuple[float, float]]) -> dict[str, float]:
        env = bare(AVOIDANCE, camera=EYE, observation="state", randomise=ranges)
        info = env.reset(seed=8)[1]
        env.close()
        return info["randomised"]

    every = drawn(WIDE)
    alone = drawn({factor: WIDE[factor]})
    assert tuple(alone) == FACTORS[factor].parts
    assert alone == {part: every[part] for part in alone}
    assert all(WIDE[factor][0] <= value <= WIDE[factor][1] for value in alone.values())
    assert len(set(alone.values())) == len(alone)
    assert drawn({factor: (WIDE[factor][1],) * 2}) == dict.fromkeys(alone, WIDE[factor][1])


def test_a_number_draws_as_it_did_before_there_were_factors():
    """Six draws of the world, after those of the starts and before those of light and phase."""
    env = bare(OPTOMOTOR, observation="pixels", randomise=0.5)
    info = env.reset(seed=4)[1]
    world = gym.utils.seeding.np_random(4)[0]
    world.integers(2**63)
    world.uniform(-math.pi, math.pi)  # the heading
    light, shell, left, right, pitch, yaw = world.uniform(-1.0, 1.0, 6)
    assert info["randomised"] == pytest.approx({
        "light": 1 + 0.15 * light, "shell": 0.02 + 0.1 * (shell + 1), "left_wheel_gain": 1 + 0.025 * left,
        "right_wheel_gain": 1 + 0.025 * right, "pitch_deg": 1.5 * pitch, "yaw_deg": 1.5 * yaw,
    }, rel=1e-12)  # fmt: skip
    lamps = np.array([0.15 * light + 1, 0.03 * world.standard_normal() + 1]).prod()
    base = compile_model(SceneConfig(arena="drum"), RobotConfig(), CameraConfig(), {"observer": "colias"}, "observer")
    assert env._sim.model.light_ambient == pytest.approx(base.light_ambient * lamps, rel=1e-6)
    env.close()


def test_what_happens_does_not_depend_on_what_is_observed():
    seen, blind = (told(observation=observation, randomise=WIDE) for observation in ("neural", "state"))
    assert happened(seen) == happened(blind)


def test_a_vector_env_plays_the_episodes_of_single_ones():
    """Several worlds in one process, each with a wall of its own."""
    many = gym.make_vec(FIXATION, num_envs=3, camera=EYE, robot="colias4", randomise=WIDE)
    batch, infos = many.reset(seed=20)
    steps = [many.step(np.full((3, 2), 0.2, np.float32))[0] for _ in range(3)]
    many.close()
    for k in range(3):
        env = bare(FIXATION, camera=EYE, robot="colias4", randomise=WIDE)
        observation, info = env.reset(seed=20 + k)
        assert {key: float(infos["randomised"][key][k]) for key in info["randomised"]} == info["randomised"]
        np.testing.assert_array_equal(batch[k], observation)
        for step in steps:
            np.testing.assert_array_equal(step[k], env.step(np.array([0.2, 0.2], np.float32))[0])
        env.close()


# What a factor changes.


@every_factor
def test_a_factor_changes_what_it_says_and_nothing_else(factor):
    """Of what is seen: the pictures, not the poses. Of what happens: the poses."""
    plain = plainly()
    changed = told(randomise={factor: (WIDE[factor][1],) * 2})
    assert fingerprint([o for o, *_ in changed]) != fingerprint([o for o, *_ in plain])
    assert (happened(changed) == happened(plain)) == (factor in SEEN)


SAME: list[tuple[str, float, dict[str, Any]]] = [
    ("noise", 2.0, {"noise": 2.0}),
    ("ae_target", 80.0, {"camera": {"preset": EYE, "ae_target": 80.0}}),
    ("row_time_us", 300.0, {"camera": {"preset": EYE, "row_time_us": 300.0}}),
    ("row_time_us", 0.0, {"camera": {"preset": EYE, "row_time_us": 0.0}}),
    ("blur_px", 1.5, {"camera": {"preset": EYE, "blur_px": 1.5}}),
    ("mass_g", 60.0, {"robot": {"mass_g": 60.0}}),
    ("motor_gain", 2.0, {"robot": RobotConfig(motor_gain=4e-4)}),
]


@pytest.mark.parametrize(("factor", "value", "options"), SAME, ids=str)
def test_an_end_is_as_the_setting_of_that_name(factor, value, options):
    """The episode of an env that was compiled with the value, to the bit; after one with another value."""
    env = bare(OPTOMOTOR, camera=EYE, randomise={factor: (value, value)})
    episode(env, seed=2, steps=2)
    env.options = dataclasses.replace(env.options, randomise={factor: (value * 0.9,) * 2})
    episode(env, seed=2, steps=3)
    env.options = dataclasses.replace(env.options, randomise={factor: (value, value)})
    transitions = episode(env, seed=3, steps=8)
    env.close()
    transitions[0][1].pop("randomised")
    expected = told(OPTOMOTOR, robots=0, **options)
    assert fingerprint(transitions) == fingerprint(expected)


def test_mass_and_motor_gain_leave_the_model_as_if_compiled_so():
    env = bare(OPTOMOTOR, observation="state")
    before = env._sim.model.body_mass.sum()
    env.options = dataclasses.replace(env.options, randomise={"mass_g": (20.0, 20.0)})
    env.reset(seed=0)  # and so another mass before, and a wall that has turned
    env.options = dataclasses.replace(env.options, randomise={"mass_g": (50.0, 50.0), "motor_gain": (2.0, 2.0)})
    env.reset(seed=0)
    robot = RobotConfig(mass_g=50.0, motor_gain=4e-4)
    other = compile_model(SceneConfig(arena="drum"), robot, CameraConfig(), {"observer": "colias"}, "observer",
                          fence=True)  # fmt: skip
    model = env._sim.model
    assert model.body_mass.sum() - before == pytest.approx(0.022, abs=1e-12)
    derived = ("body_", "dof_", "actuator_", "jnt_", "geom_", "cam_")
    for name in (name for name in dir(other) if name.startswith(derived)):
        if isinstance(getattr(other, name), np.ndarray) and name != "body_quat":  # the wall's phase
            np.testing.assert_array_equal(getattr(model, name), getattr(other, name), err_msg=name)
    assert (model.stat.extent, model.stat.meaninertia) == (other.stat.extent, other.stat.meaninertia)
    env.close()


def test_a_wall_s_contrast_is_that_of_a_scene_made_so_to_every_eye():
    """Pictures of the agent and of people; the mean of the texture stays."""
    options = {"randomise": {"wall": (0.4, 0.4)}, "noise": 0.0, "camera": "ideal"}
    env = bare(OPTOMOTOR, render_mode="rgb_array", render_view="observer", render_width=99, render_height=72, **options)
    env.reset(seed=1)
    plain = bare(OPTOMOTOR, camera="ideal", noise=0.0)
    plain.reset(seed=1)
    model = compile_model(SceneConfig(arena="drum", wall_contrast=0.4), RobotConfig(), CameraConfig(),
                          {"observer": "colias"}, "observer")  # fmt: skip
    np.testing.assert_array_equal(env._sim.model.tex_data, model.tex_data)
    band = slice(20, 36)  # the wall alone
    faint, full = (drum_env.luma[band].astype(float) for drum_env in (env, plain))
    assert np.ptp(faint) == pytest.approx(0.4 * np.ptp(full), rel=0.1)
    assert np.ptp(env.render()[band].astype(float)) == pytest.approx(np.ptp(faint), rel=0.1)
    env.close()
    plain.close()


@pytest.mark.parametrize("latency_ms", [0.0, 50.0, 100.0])
def test_latency_delays_what_the_wheels_are_told(latency_ms):
    env = bare(OPTOMOTOR, observation="state", randomise={"latency_ms": (latency_ms,) * 2})
    env.reset(seed=0)
    turning = [abs(env.step([-0.3, 0.3])[-1]["turn_deg_s"]) > 20.0 for _ in range(8)]
    frames = latency_ms * 30 / 1000
    # It turns within the frame in which the command comes.
    assert turning.index(True) == math.floor(frames)
    env.close()


def test_a_moved_start_keeps_clear():
    env = bare(AVOIDANCE, observation="state", robots=20, randomise={"start": (-20.0, 20.0)})
    plain = bare(AVOIDANCE, observation="state", robots=20)
    ways = []
    for seed in range(15):
        info, was = env.reset(seed=seed)[1], plain.reset(seed=seed)[1]
        here, others = env.poses.pop("observer"), [pose for name, pose in env.poses.items() if name != "observer"]
        assert min(gap_to_robot(here, pose)[0] for pose in others) > 0.9 * CLEARANCE
        assert gap_to_wall(here)[0] > 0.9 * CLEARANCE and not info["touched"]
        wanted = math.hypot(info["randomised"]["ahead_cm"], info["randomised"]["left_cm"])
        ways.append(math.hypot(info["x_cm"] - was["x_cm"], info["y_cm"] - was["y_cm"]) / wanted)
        assert 0.0 <= ways[-1] < 1.001
    assert max(ways) == pytest.approx(1.0, abs=1e-3), "nobody was moved all the way"
    env.close()
    plain.close()


# Eyes and wheels.


def test_presets_by_name_by_settings_and_as_configurations_are_one():
    same = [told(camera=camera, robot=robot, steps=4) for camera, robot in (
        ("ov7670", "colias4"),
        ({"preset": "ov7670"}, {"preset": "colias4"}),
        (CameraConfig.preset("ov7670"), RobotConfig.preset("colias4")),
        (dataclasses.asdict(CameraConfig.preset("ov7670")), dataclasses.asdict(RobotConfig.preset("colias4"))),
    )]  # fmt: skip
    assert len({fingerprint(transitions) for transitions in same}) == 1
    assert fingerprint(told(camera="default", steps=4)) != fingerprint(same[0])


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_is_short_for_its_ranges(name):
    known = dict(PRESETS[name])
    short, long = (told(randomise=randomise, steps=2) for randomise in (name, known))
    more = told(randomise={"preset": name, "light": (0.1, 0.2)}, steps=2)
    assert fingerprint(short) == fingerprint(long) != fingerprint(more)


# Refusals.

BAD: list[Any] = [
    {"ligth": (0.7, 1.3)}, {"light": (1.3, 0.7)}, {"light": (0.7, 9.0)}, {"mass_g": (math.nan, 30)}, {"light": "ab"},
    {"light": 1.0}, {"light": (1, 1, 1)}, "domian", {"preset": "domian"}, {"preset": ["domain"]}, None, 2.0,
    {"ae_target": (80, 120)}, {"row_time_us": (300, 600)},
]  # fmt: skip


@pytest.mark.parametrize("randomise", BAD, ids=str)
def test_a_bad_range_is_refused(randomise, contexts):
    with pytest.raises(ValueError, match=next(iter(randomise)) if isinstance(randomise, dict) else "randomise"):
        gym.make(OPTOMOTOR, observation="state", randomise=randomise)


def test_a_camera_refuses_what_it_was_not_made_for():
    env = bare(OPTOMOTOR)
    camera, config = env._sim.camera, env._sim.camera.config
    for change in ({"row_time_us": 400.0}, {"gain": 2.0}, {"width": 50}):
        with pytest.raises(ValueError, match=next(iter(change))):
            camera.tune(dataclasses.replace(config, **change))
    assert camera.config == config and isinstance(env._sim.model, mujoco.MjModel)
    env.close()


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_s_ranges_are_wide_and_what_is_a_factor_goes_both_ways(preset):
    for name, (low, high) in PRESETS[preset].items():
        factor = FACTORS[name]
        assert factor.low <= low < high <= factor.high, name
        if name in ("light", "noise", "motor_gain", "wheel_gain"):
            assert low < 1.0 < high, name
