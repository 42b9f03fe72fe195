"""The envs against Gymnasium's contract, whatever is registered: spaces, seeds, ends, errors, pictures, docstrings."""

import importlib
import inspect
import json
import math
import re
import subprocess
import sys
import weakref
from collections.abc import Iterator
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import error
from gymnasium.utils.env_checker import check_env
from hypothesis import given
from hypothesis import strategies as st

import dsnn
from colias_sim import GLUnavailable, Pose
from colias_sim.envs import ENVS, NEURAL, Other, State
from colias_sim.envs.actions import MANOEUVRES
from colias_sim.envs.base import TOUCH_COST, ColiasEnv
from colias_sim.envs.options import options_of
from colias_sim.envs.senses import LENGTH, SPEED, TURN
from colias_sim.offscreen import _Surface
from scenes import ARENAS

NAMES = sorted(ENVS)
SENSES = ("pixels", "neural", "both", "state")
AHEAD = np.array([0.3, 0.3], np.float32)
every_env = pytest.mark.parametrize("name", NAMES)


def bare(name: str, **options: Any) -> ColiasEnv[Any]:
    """The env without Gymnasium's wrappers: no time limit, no checks but its own."""
    env = gym.make(name, **options).unwrapped
    assert isinstance(env, ColiasEnv)
    return env


def env_class(name: str) -> type[ColiasEnv[Any]]:
    module, _, cls = ENVS[name].entry_point.partition(":")
    return getattr(importlib.import_module(module), cls)


def options_type(name: str) -> type[Any]:
    return env_class(name).options_type


def robots_at_ends(name: str) -> tuple[int, int]:
    low, high = (int(end) for end in re.findall(r"\d+", str(options_of(options_type(name))["robots"].metadata)))
    return low, high


def episode(env: gym.Env[Any, Any], seed: int | None = None, steps: int = 25) -> list[Any]:
    """Everything an agent is told in an episode of random actions (of the seed), up to its end."""
    rng, told = np.random.default_rng(seed), [env.reset(seed=seed)]
    discrete = isinstance(env.action_space, gym.spaces.Discrete)
    for _ in range(steps):
        told.append(env.step(int(rng.integers(7)) if discrete else rng.uniform(-1.0, 1.0, 2).astype(np.float32)))
        if told[-1][2] or told[-1][3]:
            break
    return told


def fingerprint(told: list[Any]) -> str:
    """All of it to the last bit."""

    def plain(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: plain(value[key]) for key in sorted(value)}
        if isinstance(value, tuple | list):
            return [plain(item) for item in value]
        return value.tobytes().hex() if isinstance(value, np.ndarray) else repr(value)

    return json.dumps(plain(told))


def touches_on_purpose(env: ColiasEnv[Any]) -> None:
    """Reset, and drive straight at the wall, whatever is between."""
    env.reset(seed=3)
    env._sim.reset(spread(env) | {"observer": Pose(0.36, 0.0, 0.0)}, np.random.default_rng(0))


def spread(env: ColiasEnv[Any]) -> dict[str, Pose]:
    """Everybody but the observer on a grid far from where it drives."""
    others = [name for name in env.poses if name != "observer"]
    return {name: Pose(-0.12 - 0.07 * (i // 5), -0.16 + 0.08 * (i % 5), 0.0) for i, name in enumerate(others)}


# Registered, and as documented.


def test_there_are_envs_and_a_fresh_process_makes_them_by_module():
    assert NAMES
    for command in (
        f"import gymnasium as g; e = g.make('colias_sim:{NAMES[0]}')",
        f"import colias_sim, gymnasium as g; e = g.make('{NAMES[0]}')",
    ):
        code = f"{command}; o, i = e.reset(seed=0); assert o in e.observation_space; e.close()"
        done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")


@every_env
@pytest.mark.parametrize("actions", ["wheels", "manoeuvres"])
@pytest.mark.parametrize("observation", SENSES)
def test_gymnasium_s_own_checks(name, observation, actions):
    env = gym.make(name, observation=observation, actions=actions, render_mode="rgb_array", render_width=64)
    # It warns, and so fails, of what is not as it should be; pictures do not depend on what is observed.
    check_env(env.unwrapped, skip_render_check=(observation, actions) != ("pixels", "wheels"))
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
    for observation, *_ in episode(env, seed=1, steps=6):
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
@pytest.mark.parametrize("options", [{}, {"observation": "both", "randomise": 1.0, "actions": "manoeuvres"}], ids=str)
def test_a_seed_decides_everything(name, options):
    env, other = bare(name, **options), bare(name, **options)
    first = fingerprint(episode(env, seed=5))
    assert fingerprint(episode(env, seed=6)) != first
    env.reset()
    env.step(env.action_space.sample())  # in mid-episode
    assert fingerprint(episode(env, seed=5)) == first
    assert fingerprint(episode(other, seed=5)) == first
    # The episodes that follow a seed are decided too, and differ.
    second = episode(other)[0]
    assert fingerprint(second) == fingerprint(episode(env)[0])
    assert fingerprint(second) != fingerprint(episode(env)[0])
    env.close()
    other.close()


def test_a_seed_decides_everything_in_another_process_too():
    code = (
        "from tests.test_envs import *\n"
        "for name in NAMES: print(fingerprint(episode(bare(name, observation='both'), seed=5)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    for name, there in zip(NAMES, done.stdout.split("\n"), strict=False):
        env = bare(name, observation="both")
        episode(env, seed=4)
        assert there == fingerprint(episode(env, seed=5)), name
        env.close()


@every_env
def test_what_happens_does_not_depend_on_what_is_observed_or_shown(name):
    """Poses and rewards to the last bit: baselines that see and those that know are compared in pairs."""
    told = []
    for options in (
        {"observation": "state"},
        {"observation": "pixels", "noise": 0.0},
        {"observation": "neural", "model": "flow", "noise": 2.0},
        {"observation": "state", "render_mode": "rgb_array_list", "render_width": 32, "render_height": 24},
    ):
        env = bare(name, **options)
        told.append([(info, rest[:2]) for _, *rest, info in episode(env, seed=2)])
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
    env = bare(name, observation="state", **({"follow": True} if "follow" in options_of(options_type(name)) else {}))
    touches_on_purpose(env)
    for _ in range(60):
        _, reward, terminated, truncated, info = env.step(AHEAD)
        assert info["touched"] == terminated == (info["reward_touch"] != 0.0) and not truncated
        if terminated:
            break
    assert terminated and info["reward_touch"] == -TOUCH_COST and reward < -TOUCH_COST / 2
    assert math.hypot(info["x_cm"], info["y_cm"]) == pytest.approx(43.0, abs=0.6)  # hull against panel
    with pytest.raises(error.ResetNeeded, match="reset"):
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
    with pytest.raises(error.ResetNeeded, match=r"step\(\) before reset"):
        env.step(AHEAD)
    with pytest.raises(error.ResetNeeded, match=r"render\(\) before reset"):
        env.render()
    with pytest.raises(ValueError, match="no such option"):
        env.reset(options={"level": 3})
    env.reset(seed=0, options={})
    env.close()
    env.close()
    for late in (env.reset, env.render, lambda: env.step(AHEAD)):
        with pytest.raises(error.ClosedEnvironmentError, match="closed"):
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


# Mistakes.

WRONG: list[Any] = [
    np.array([np.nan, 0.0]), [0.0, np.inf], [1.1, 0.0], [0.0, -1.5], [1e300, 0.0], [0.0, 0.0, 0.0], np.zeros((2, 1)),
    None, [None, None], "ab", ["0.1", "0.2"], [1j, 0.0], [[0.0], [0.0, 1.0]], {}, 7, -1, 2.5, 10**30,
    np.full((90, 90), np.nan),
]  # fmt: skip


@pytest.mark.parametrize("actions", ["wheels", "manoeuvres"])
@pytest.mark.parametrize("wrong", WRONG, ids=lambda wrong: " ".join(repr(wrong).split())[:30])
def test_an_illegal_action_is_told_and_nothing_happens(wrong, actions):
    env = bare(NAMES[0], observation="state", actions=actions)
    env.reset(seed=0)
    before = env.poses
    with pytest.raises(error.InvalidAction, match="expected") as told:
        env.step(wrong)
    assert "\n" not in str(told.value) and len(str(told.value)) < 160
    assert env.poses == before
    observation, *_ = env.step(env.action_space.sample())
    assert env.observation_space.contains(observation)
    env.close()


@pytest.mark.parametrize("legal", [[0.1, -0.1], (1, -1), np.array([0.5, 0.5]), np.array([-1, 1])], ids=str)
def test_two_numbers_however_written(legal):
    env = bare(NAMES[0], observation="state")
    env.reset(seed=0)
    env.step(legal)
    assert env.wheels.dtype == np.float32
    env.close()


@pytest.fixture
def contexts(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[weakref.ref[_Surface]]]:
    """Every OpenGL context that is made; all are gone in the end."""
    made: list[weakref.ref[_Surface]] = []
    start = _Surface.__init__

    def init(self: _Surface, *arguments: Any) -> None:
        start(self, *arguments)
        made.append(weakref.ref(self))

    monkeypatch.setattr(_Surface, "__init__", init)
    yield made
    assert not any(one() for one in made), "left open"


BAD = [
    ({"robots": 99}, r"robots=99.*\.\. 20"),
    ({"robots": -1}, r"robots=-1.*\.\. 20"),
    ({"arena": "brihgt"}, "arena='brihgt'.*nearest: bright"),
    ({"noise": -1}, r"noise=-1.*0 \.\. 10"),
    ({"noise": math.nan}, "noise=nan.*finite"),
    ({"observation": "pixel"}, "observation='pixel'.*'pixels', 'neural', 'both' or 'state'"),
    ({"robtos": 3}, "'robtos'.*nearest: robots"),
    ({"model": "dsn"}, "'dsn'.*nearest: dsnn"),
    ({"model": 3}, "model=3.*name.*factory"),
    ({"model": lambda shape: None}, "made None.*step.*reset"),
    ({"frame_skip": 0}, r"frame_skip=0.*1 \.\. 30"),
    ({"frame_skip": 1.5}, "frame_skip=1.5.*integer"),
    ({"randomise": 2.0, "actions": "legs"}, "actions='legs'.*'wheels'.*; randomise=2.0"),
    ({"render_view": "side", "render_mode": "rgb_array"}, "render_view='side'.*'arena', 'top' or 'observer'"),
]


@every_env
@pytest.mark.parametrize(("options", "said"), BAD, ids=lambda value: str(value)[:24])
def test_a_bad_argument_is_named_with_what_is_legal(name, options, said, contexts):
    with pytest.raises(ValueError, match=said) as told:
        gym.make(name, **options)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(
    ("name", "options", "said"),
    [
        ("Fixation", {"robots": 0}, r"robots=0.*1 \.\. 20"),
        ("Fixation", {"slowest_deg_s": 50.0, "fastest_deg_s": 20.0}, "slowest_deg_s=50.*fastest_deg_s, 20"),
        ("Optomotor", {"slowest_deg_s": 50.0, "fastest_deg_s": 20.0}, "slowest_deg_s=50.*fastest_deg_s=20"),
        ("Optomotor", {"slowest_deg_s": 0.0, "fastest_deg_s": 0.0}, "fastest_deg_s=0.*above 0"),
        ("Optomotor", {"disturbance": "push", "fastest_deg_s": 200.0}, "fastest_deg_s=200.*180"),
        ("Pursuit", {"distance_cm": 1.0}, r"distance_cm=1.*2 \.\. 30"),
        ("Avoidance", {"moving": 21}, r"moving=21.*0 \.\. 20"),
    ],
)
def test_a_bad_argument_of_one_env(name, options, said, contexts):
    with pytest.raises(ValueError, match=said) as told:
        gym.make(f"colias_sim/{name}-v0", **options)
    assert "\n" not in str(told.value)


# Pictures.


@every_env
def test_rgb_array(name, contexts):
    env = bare(name, observation="state", render_mode="rgb_array", render_width=80, render_height=60)
    env.reset(seed=0)
    first = env.render()
    assert first.shape == (60, 80, 3) and first.dtype == np.uint8 and first.std() > 10
    kept = first.copy()
    for _ in range(8):
        env.step([1.0, -1.0])
    second = env.render()
    assert np.abs(second.astype(int) - first).max() > 30, "the robot has turned"
    np.testing.assert_array_equal(first, kept)
    env.close()


def test_rgb_array_list_holds_what_came_since_the_last_call(contexts):
    env = gym.make(NAMES[0], observation="state", render_mode="rgb_array_list", render_width=48, render_height=32)
    env.reset(seed=0)
    for _ in range(3):
        env.step([0.0, 0.0])
    assert len(env.render()) == 4
    assert env.render() == []
    env.step([0.0, 0.0])
    (one,) = env.render()
    assert one.shape == (32, 48, 3)
    env.step([0.0, 0.0])
    env.reset()
    assert len(env.render()) == 1, "of this episode"
    env.close()


def test_the_observer_s_view_is_what_its_camera_sees(contexts):
    env = bare(
        "colias_sim/Pursuit-v0", noise=0.0, render_mode="rgb_array", render_view="observer",
        render_width=99, render_height=72,
    )  # fmt: skip
    env.reset(seed=0)
    shown = env.render().astype(float) @ (0.299, 0.587, 0.114)
    luma = env.luma.astype(float)
    env.close()
    alike = np.corrcoef(shown.ravel(), luma.ravel())[0, 1]
    assert alike > 0.98
    for other in (shown[:, ::-1], shown[::-1], np.roll(shown, 3, 0), np.roll(shown, 3, 1)):
        assert np.corrcoef(other.ravel(), luma.ravel())[0, 1] < alike - 0.01


def test_the_views_differ_and_the_top_one_looks_down(contexts):
    pictures = {}
    for view in ("arena", "top", "observer"):
        env = bare(
            "colias_sim/Fixation-v0", observation="state", render_mode="rgb_array", render_view=view,
            render_width=120, render_height=120,
        )  # fmt: skip
        env.reset(seed=0)
        pictures[view] = env.render().astype(int)
        target = env.poses["target"]
        env.close()
    assert len({picture.tobytes() for picture in pictures.values()}) == 3
    # The black robot from above: right in the picture is +x, up is +y.
    dark = pictures["top"].max(-1) < 40
    rows, columns = np.nonzero(dark[20:100, 20:100])
    towards = math.atan2(39.5 - rows.mean(), columns.mean() - 39.5)
    assert math.remainder(towards - math.atan2(target.y, target.x), 2 * math.pi) == pytest.approx(0.0, abs=0.3)


def test_without_a_screen_a_window_is_refused(monkeypatch, contexts):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(GLUnavailable, match="rgb_array") as told:
        gym.make(NAMES[0], render_mode="human")
    assert "\n" not in str(told.value)


@every_env
def test_closing_frees_every_context(name, contexts):
    env = gym.make(name, render_mode="rgb_array")
    env.reset(seed=0)
    env.render()
    assert len(contexts) == 2
    env.close()


# Docstrings.


@every_env
def test_the_docstring_is_a_whole_page(name):
    page = inspect.getdoc(env_class(name)) or ""
    titles = re.findall(r"^## (.+)$", page, re.M)
    assert titles == [
        "Description", "Action Space", "Observation Space", "Rewards", "Info", "Starting State", "Episode End",
        "Arguments", "Version History",
    ]  # fmt: skip
    assert not re.search(r"<[A-Z]+>|\{\w*\}", page), "a placeholder"
    assert not re.search(r"^ +[#|]", page, re.M), "an indented title or table"
    assert f"{ENVS[name].max_episode_steps} steps" in page
    for option, field in options_of(options_type(name)).items():
        (row,) = re.findall(rf"^\| `{option}` \| `(.+?)` \| (.+?) \| (.+) \|$", page, re.M)
        assert row[0].replace('"', "'") == repr(field.default)
    env = bare(name, observation="state")
    *_, info = episode(env, seed=0)[1]
    env.close()
    for key in info:
        said = key.removeprefix("reward_")
        assert f"`{said}`" in page, f"info's {key}"


# State.

angles = st.floats(-math.pi, math.pi)
others = st.builds(Other, st.floats(0, LENGTH), angles, st.floats(-SPEED, SPEED), st.floats(-SPEED, SPEED))


@given(
    st.builds(
        State,
        st.floats(-SPEED, SPEED),
        *[st.floats(-TURN, TURN)] * 3,
        st.floats(0, LENGTH),
        angles,
        st.lists(others, max_size=4).map(tuple),
    )
)
def test_a_state_is_read_back_from_its_vector(state):
    vector = state.vector()
    assert vector.shape == (7 + 5 * len(state.others),) and vector.dtype == np.float32
    assert np.abs(vector).max() <= 1.0
    back = State.read(vector)
    for one, two in [(state, back), *zip(state.others, back.others, strict=True)]:
        for field in (name for name in one.__slots__ if name != "others"):
            off = getattr(one, field) - getattr(two, field)
            assert math.remainder(off, 2 * math.pi) == pytest.approx(0.0, abs=1e-5)
