"""What an env rewards and shows, recomputed from its infos by the formulas of its page, and from its picture."""

import math

import numpy as np
import pytest

from colias_sim import CameraConfig
from tests.helpers.envs import bare

FOCAL_PX, FPS, TOP_CM_S, HALF_VIEW_DEG = 49.5 / math.tan(math.radians(35)), 30.0, 35.0, 35.0
SET = {"Optomotor": {"fastest_deg_s": 50.0}, "Pursuit": {"distance_cm": 7.0}}
"""What is set otherwise than usual where terms are recomputed."""


def effort(left, right):
    return -0.05 * (left**2 + right**2) / 2


def centre(info):
    return max(1 - abs(info["bearing_deg"]) / HALF_VIEW_DEG, -1)


TERMS = {
    "Optomotor": lambda info, left, right: {
        "hold": max(1 - abs(info["slip_deg_s"]) / 50, -1),
        "effort": effort(left, right),
    },
    "Fixation": lambda info, left, right: {
        "centre": centre(info),
        "effort": effort((left - right) / 2, (right - left) / 2),
    },
    "Pursuit": lambda info, left, right: {"distance": max(1 - abs(info["gap_cm"] - 7) / 7, -1), "centre": centre(info)},
    "Avoidance": lambda info, left, right: {"ahead": info["ahead_cm"] * FPS / TOP_CM_S},
}
"""Env -> the terms of its reward as its page has them, from an info, the way along the heading, and the action."""


def steps(name, action_of, most, **options):
    """Yield the action, the info before, the observation and the rest of each step, until the episode ends."""
    env = bare(f"colias_sim/{name}-v0", **options)
    _, info = env.reset(seed=11)
    for step in range(most):
        action = np.asarray(action_of(step), np.float32)
        before, (image, reward, ended, _, info) = info, env.step(action)
        yield action, before, image, reward, ended, info
        if ended:
            break


def ahead_cm(before, after):
    """How far the robot went along its heading, by its poses."""
    heading = math.radians(before["heading_deg"] + after["heading_deg"]) / 2
    if abs(after["heading_deg"] - before["heading_deg"]) > 180:
        heading += math.pi
    dx, dy = after["x_cm"] - before["x_cm"], after["y_cm"] - before["y_cm"]
    return dx * math.cos(heading) + dy * math.sin(heading)


@pytest.mark.parametrize(("hfov_deg", "off_deg", "seen"), [
    (70, 34, True), (70, 36, False), (120, 59, True), (120, 61, False), (40, 19, True), (40, 21, False),
])  # fmt: skip
def test_a_target_is_in_the_view_of_the_envs_own_camera(hfov_deg, off_deg, seen):
    env = bare("colias_sim/Fixation-v0", observation="state", camera={"hfov_deg": hfov_deg})
    lens_cm, turn = CameraConfig().forward_cm, math.radians(-off_deg)
    target = lens_cm + 15 * math.cos(turn), 15 * math.sin(turn), 0.0
    info = env.reset(seed=0, options={"poses": {"observer": (0.0, 0.0, 0.0), "target": target}})[1]
    moved = env.step([0.0, 0.0])[-1]
    assert info["bearing_deg"] == pytest.approx(off_deg, abs=0.3) and info["in_view"] is seen
    assert moved["reward_centre"] == pytest.approx(1 - abs(moved["bearing_deg"]) / (hfov_deg / 2))


@pytest.mark.parametrize("name", TERMS)
def test_the_reward_is_the_sum_of_its_pages_terms(name):
    rng, speeds = np.random.default_rng(5), []
    for (left, right), before, _, reward, ended, info in steps(
        name, lambda _: rng.uniform(-1, 1, 2), 60, observation="state", **SET.get(name, {})
    ):
        ahead = ahead_cm(before, info)
        terms = TERMS[name](info | {"ahead_cm": ahead}, left, right) | {"touch": -10.0 * info["touched"]}
        parts = {key.removeprefix("reward_"): value for key, value in info.items() if key.startswith("reward_")}
        assert parts.keys() == terms.keys() and ended == info["touched"]
        for term, value in terms.items():  # `ahead` is the speed at the frame's end, and wheels change theirs within it
            assert parts[term] == pytest.approx(value, abs=0.2 if term == "ahead" else 1e-6), term
        assert reward == pytest.approx(sum(parts.values()), abs=1e-9)
        assert info["driven_cm"] == pytest.approx(abs(ahead), abs=0.05)
        speeds.append((parts.get("ahead", 0.0), ahead * FPS / TOP_CM_S))
    if name == "Avoidance":
        rewarded, driven = np.array(speeds).T
        assert np.corrcoef(rewarded, driven)[0, 1] > 0.9


def test_driving_into_the_wall_costs_10_and_ends_the_episode():
    options = {"observation": "state", "robots": 1, "robot": {"max_speed_cm_s": 25.0}}
    driven_into = list(steps("Avoidance", lambda _: (1, 1), 200, **options))
    rewards = [info["reward_ahead"] for *_, info in driven_into]
    driven = sum(ahead_cm(before, info) for _, before, *_, info in driven_into)
    assert sum(rewards) / FPS * 25.0 == pytest.approx(driven, rel=0.02)
    *_, reward, ended, info = driven_into[-1]
    assert ended and info["touched"] and info["reward_touch"] == -10.0 and reward < -9
    assert math.hypot(info["x_cm"], info["y_cm"]) == pytest.approx(45 - 2, abs=0.5), "a hull of 2 cm at the wall"
