"""Factors, drawn by ``randomise`` or given at a reset: each changes what it says, as if compiled so, and no more."""

import cmath
import dataclasses
import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from colias_sim import CameraConfig, RobotConfig, SceneConfig
from colias_sim.envs.geometry import CLEARANCE, gap_to_arena, gap_to_robot
from colias_sim.envs.options import EnvOptions, checked
from colias_sim.envs.randomise import FACTORS
from colias_sim.scene import compile_model
from tests.helpers.envs import FIXATION, bare, every_env, fingerprint
from tests.helpers.flow import moved

OPTOMOTOR, AVOIDANCE = "colias_sim/Optomotor-v0", "colias_sim/Avoidance-v0"
EYE = "ov7670"
WIDE: dict[str, tuple[float, float]] = {
    "light": (0.5, 1.5), "noise": (0.0, 3.0), "ae_target": (60.0, 150.0), "row_time_us": (100.0, 450.0),
    "blur_px": (0.0, 3.0), "tilt": (-10.0, 10.0), "wall": (0.2, 0.9), "shell": (0.0, 0.9), "start": (-4.0, 4.0),
    "mass_g": (15.0, 60.0), "motor_gain": (0.3, 2.0), "wheel_gain": (0.7, 1.3), "latency_ms": (0.0, 200.0),
}  # fmt: skip
SEEN = {"light", "noise", "ae_target", "row_time_us", "blur_px", "tilt", "wall", "shell"}
"""Factors of what is seen; the others are of what happens."""


def randomise(env: Any, value: Any) -> None:
    """Draw by other ranges from the next reset on."""
    env.options = dataclasses.replace(env.options, randomise=value)


def played(env: Any, steps: int = 4, **options: Any) -> list[Any]:
    """An episode, without the names of what was drawn or given."""
    told = [env.reset(seed=3, options=options or None)]
    told[0][1].pop("randomised", None)
    return told + [env.step(np.array([0.2, 0.3], np.float32)) for _ in range(steps)]


def happened(transitions: list[Any]) -> str:
    return fingerprint([rest for _, *rest in transitions])


def test_a_factor_changes_what_it_says_drawn_or_given_and_a_reset_forgets_it():
    """Of what is seen: the pictures, not the poses. Of what happens: the poses."""
    assert set(WIDE) == set(FACTORS)
    env = bare(FIXATION, camera=EYE, robots=2)
    plain = played(env)
    for name, factor in FACTORS.items():
        value = WIDE[name][1]
        given = played(env, **{name: (value,) * len(factor.parts) if factor.parts[1:] else value})
        assert fingerprint(played(env)) == fingerprint(plain), name
        assert fingerprint([o for o, *_ in given]) != fingerprint([o for o, *_ in plain]), name
        assert (happened(given) == happened(plain)) == (name in SEEN), name
        randomise(env, {name: (value, value)})
        assert fingerprint(played(env)) == fingerprint(given), name
        randomise(env, 0.0)


def test_a_factor_s_draws_are_its_own():
    """The same alone as among all others and beside a value that is given, within its ends, each part by itself."""
    env = bare(AVOIDANCE, camera=EYE, observation="state", randomise=WIDE)
    every = env.reset(seed=8)[1]["randomised"]
    assert env.reset(seed=8, options={"light": 0.7})[1]["randomised"] == {**every, "light": 0.7}
    for name, factor in FACTORS.items():
        randomise(env, {name: WIDE[name]})
        alone = env.reset(seed=8)[1]["randomised"]
        assert tuple(alone) == factor.parts and alone == {part: every[part] for part in alone}
        assert all(WIDE[name][0] <= value <= WIDE[name][1] for value in alone.values())
        assert len(set(alone.values())) == len(alone)


def test_a_number_draws_as_it_did_before_there_were_factors():
    """Six draws of the world, after those of the starts and before those of light and phase."""
    env = bare(OPTOMOTOR, observation="pixels", randomise=0.5)
    info = env.reset(seed=4)[1]
    given = env.reset(seed=4, options={"tilt": (1.0, 2.0)})[1]["randomised"]
    assert given == {**info["randomised"], "pitch_deg": 1.0, "yaw_deg": 2.0}
    world = gym.utils.seeding.np_random(4)[0]
    world.integers(2**63)
    world.uniform(-math.pi, math.pi)  # the heading
    light, shell, left, right, pitch, yaw = world.uniform(-1.0, 1.0, 6)
    assert info["randomised"] == pytest.approx({
        "light": 1 + 0.15 * light, "shell": 0.02 + 0.1 * (shell + 1), "left_wheel_gain": 1 + 0.025 * left,
        "right_wheel_gain": 1 + 0.025 * right, "pitch_deg": 1.5 * pitch, "yaw_deg": 1.5 * yaw,
    }, rel=1e-12)  # fmt: skip


USUAL = CameraConfig.preset(EYE)
SAME: list[tuple[str, float, dict[str, Any]]] = [
    ("noise", 2.0, {"noise": 2.0}),
    ("noise", 2.0, {"camera": {"preset": EYE, "shot_noise": 2 * USUAL.shot_noise, "read_noise": 2 * USUAL.read_noise}}),
    ("ae_target", 80.0, {"camera": {"preset": EYE, "ae_target": 80.0}}),
    ("row_time_us", 300.0, {"camera": {"preset": EYE, "row_time_us": 300.0}}),
    ("row_time_us", 0.0, {"camera": {"preset": EYE, "row_time_us": 0.0}}),
    ("blur_px", 1.5, {"camera": {"preset": EYE, "blur_px": 1.5}}),
    ("mass_g", 60.0, {"robot": {"mass_g": 60.0}}),
    ("motor_gain", 2.0, {"robot": RobotConfig(motor_gain=4e-4)}),
]


@pytest.mark.parametrize(("factor", "value", "options"), SAME, ids=str)
def test_a_value_is_as_the_setting_of_that_name(factor, value, options):
    """The episode of an env that was compiled with the value, to the bit; after one with another value."""
    env = bare(OPTOMOTOR, camera=EYE)
    played(env, 2, **{factor: value * 0.9})
    transitions = played(env, **{factor: value})
    compiled = bare(OPTOMOTOR, **{"camera": EYE, **options})
    assert fingerprint(transitions) == fingerprint(played(compiled))


def test_a_wall_s_contrast_is_that_of_a_scene_made_so_to_every_eye():
    """Pictures of the agent and of people; the mean of the texture stays."""
    env = bare(OPTOMOTOR, camera="ideal", noise=0.0, render_mode="rgb_array", render_view="observer", render_width=99,
               render_height=72)  # fmt: skip
    bands = []
    for wall in (1.0, 0.4):
        env.reset(seed=1, options={"wall": wall})
        bands.append(np.ptp(env.luma[20:36].astype(float)))  # the wall alone
    model = compile_model(SceneConfig(arena="drum", wall_contrast=0.4), RobotConfig(), CameraConfig(),
                          {"observer": "colias"})  # fmt: skip
    np.testing.assert_array_equal(env._sim.model.tex_data, model.tex_data)
    assert bands[1] == pytest.approx(0.4 * bands[0], rel=0.1)
    assert np.ptp(env.render()[20:36].astype(float)) == pytest.approx(bands[1], rel=0.1)


def test_gains_and_tilts_and_shells_are_of_the_sides_and_robots_that_they_name():
    """A faster left wheel turns to the right; an eye tilted up and left sees the scene farther down and right."""
    env = bare(OPTOMOTOR, camera="ideal", robots=2, slowest_deg_s=0.0, fastest_deg_s=1e-9)
    env.reset(seed=1, options={"wheel_gain": (1.2, 0.8), "shell": 0.6})
    turns = [env.step([0.3, 0.3])[-1]["turn_deg_s"] for _ in range(20)]
    assert turns[-1] == pytest.approx(math.degrees(0.3 * 35.0 * (0.8 - 1.2) / RobotConfig().track_cm), rel=0.03)
    assert all((env._sim.model.material(f"parked{i}/shell").rgba[:3] == np.float32(0.6)).all() for i in (1, 2))
    pictures, far = [], CameraConfig().focal_px * math.tan(math.radians(3.0))
    for tilt in ((0.0, 0.0), (3.0, 0.0), (0.0, 3.0)):
        env.reset(seed=1, options={"tilt": tilt})
        pictures.append(env.luma)
    assert moved(np.array(pictures[:2])) == pytest.approx([0.0, far], abs=0.5)
    assert moved(np.array(pictures[::2])) == pytest.approx([far, 0.0], abs=0.5)


def test_latency_delays_what_the_wheels_are_told():
    """By the nearest number of control intervals, of which a frame has two; within that frame the robot turns."""
    env = bare(OPTOMOTOR, observation="state")
    interval_ms = 1000 / 60
    for intervals in (0.0, 0.4, 0.6, 1.4, 1.6, 3.0, 6.0):
        env.reset(seed=0, options={"latency_ms": intervals * interval_ms})
        turning = [abs(env.step([-0.3, 0.3])[-1]["turn_deg_s"]) > 20.0 for _ in range(8)]
        assert turning.index(True) == round(intervals) // 2


def test_a_moved_start_keeps_clear():
    env = bare(AVOIDANCE, observation="state", robots=20, randomise={"start": (-20.0, 20.0)})
    plain = bare(AVOIDANCE, observation="state", robots=20)
    ways = []
    for seed in range(8):
        info, was = env.reset(seed=seed)[1], plain.reset(seed=seed)[1]
        here, others = env.poses.pop("observer"), [pose for name, pose in env.poses.items() if name != "observer"]
        assert min(gap_to_robot(here, pose)[0] for pose in others) > 0.9 * CLEARANCE
        assert gap_to_arena(here)[0] > 0.9 * CLEARANCE and not info["touched"]
        wanted = complex(info["randomised"]["ahead_cm"], info["randomised"]["left_cm"])
        turned = wanted * cmath.exp(1j * math.radians(was["heading_deg"]))
        share = complex(info["x_cm"] - was["x_cm"], info["y_cm"] - was["y_cm"]) / turned
        ways.append(share.real)
        assert -1e-3 < share.real < 1.001 and abs(share.imag) < 1e-3
    assert max(ways) == pytest.approx(1.0, abs=1e-3), "nobody was moved all the way"


# Start poses.


@every_env
def test_a_robot_starts_where_it_is_put(name):
    env = bare(name, observation="state")
    env.reset(seed=1)
    before = env.poses
    info = env.reset(seed=1, options={"poses": {"observer": (-30.0, 12.0, 90.0)}})[1]
    assert (info["x_cm"], info["y_cm"], info["heading_deg"]) == pytest.approx((-30.0, 12.0, 90.0), abs=0.02)
    for robot, pose in before.items():
        if robot != "observer" and math.hypot(pose.x + 0.3, pose.y - 0.12) > 0.051:
            assert env.poses[robot] == pose, "others start where the seed puts them"
    assert not info["touched"]


# Vector envs, presets, refusals.


BAD_RANGES: list[Any] = [{"ligth": (0.7, 1.3)}, {"light": (1.3, 0.7)}, {"light": (0.7, 9.0)}, "domian"]


@pytest.mark.parametrize("ranges", BAD_RANGES, ids=str)
def test_a_bad_range_is_refused(ranges):
    with pytest.raises(ValueError, match=next(iter(ranges)) if isinstance(ranges, dict) else "randomise"):
        checked(EnvOptions, {"randomise": ranges})


BAD: list[dict[str, Any]] = [
    {"ligth": 0.5}, {"light": 3.0}, {"ae_target": 90.0}, {"poses": {"targt": (0, 0, 0)}},
    {"poses": {"target": (43, 0, 0)}}, {"poses": {"target": (0, 0, 0), "observer": (4, 0, 0)}},
]  # fmt: skip


def test_a_bad_option_of_a_reset_is_named_and_changes_nothing():
    env = bare(FIXATION, observation="state")
    env.reset(seed=0)
    expected = fingerprint([env.reset()])
    env.reset(seed=0)
    for options in BAD:
        with pytest.raises(ValueError, match=next(iter(options))):
            env.reset(seed=5, options=options)
    assert fingerprint([env.reset()]) == expected, "a refused reset draws nothing"
