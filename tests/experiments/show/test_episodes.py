"""Episodes: equal seeds are equal worlds, what a reflex sees, columns by hand, recordings read back, the wrapper."""

import gymnasium as gym
import numpy as np
import pytest

import colias_sim  # noqa: F401  (registers the envs)
from colias_sim.config import RobotConfig
from colias_sim.envs import State
from colias_sim.envs.measures import optomotor_gain
from dsnn import Response
from experiments import Behaviour, RecordRerun, UsageError
from experiments.declare.behaviour import AVOIDANCE, FIXATION, OPTOMOTOR, PURSUIT
from experiments.kinds.episodes import load_behaviour, plan as plan_episodes
from experiments.paper.behaviours import BEHAVIOURS
from experiments.show.episodes import play, response, wheels
from experiments.store.asked import Asked
from tests.helpers.recordings import columns

STEPS = 6


@pytest.mark.parametrize("name", list(BEHAVIOURS))
def test_every_behaviour_plays_in_its_env(name):
    entry = BEHAVIOURS[name]
    episode = play(entry, entry.env, {}, 5, 8, images=True)
    assert len(episode.rewards) == 8
    assert np.isfinite(episode.rewards).all() and (np.abs(episode.wheels) <= 1).all()
    assert len(episode.images) == len(episode.responses) == (8 if entry.senses == "neural" else 0)


def test_an_episode_depends_on_its_seed_alone_and_its_world_on_no_behaviour():
    played = [play(BEHAVIOURS[name], FIXATION, {}, 3, 30) for name in ("fixation", "fixation", "still")]
    assert played[0].row() == played[1].row() and played[0].steps(0).equals(played[1].steps(0))
    # One solver moves all robots: the others' wheels round what it finds otherwise.
    np.testing.assert_allclose(played[2].poses["target"], played[0].poses["target"], atol=1e-4)
    assert play(BEHAVIOURS["still"], FIXATION, {}, 4, 2).poses["target"][0] != played[2].poses["target"][0]


@pytest.mark.parametrize(("name", "env", "column"), [
    ("oracle-heading", OPTOMOTOR, "rms_slip_deg_s"),
    ("oracle-target", FIXATION, "rms_off_axis_deg"),
])  # fmt: skip
def test_an_oracle_knows_the_truth_under_the_robots_own_wheels_too(name, env, column):
    """Their dead band swallows small commands: without memory `oracle-heading` stands as `still` does."""
    truth, still = (play(BEHAVIOURS[who], env, {"robot": "colias4"}, 3000, 150).row() for who in (name, "still"))
    assert truth[column] < still[column] / 2 and truth["reward"] > still["reward"]


def test_a_frozen_model_sees_the_first_frame_throughout_in_the_same_world():
    seen, frozen = (play(BEHAVIOURS["fixation"], FIXATION, {}, 3, 20, images=True, frozen=it) for it in (False, True))
    assert frozen.poses["target"][0] == seen.poses["target"][0]
    assert any(answer.hs for answer in seen.responses) and not any(answer.hs for answer in frozen.responses)
    plan = plan_episodes(
        Asked(kind="episodes", what=("fixation",), repeats=2, options={"controls": True, "baselines": False})
    )
    assert [trial.condition for trial in plan.trials] == ["fixation", "fixation~frozen"] * 2


# --- what a reflex sees and does --------------------------------------------------------------------------------------


@pytest.mark.parametrize("robot", [{"max_speed_cm_s": 15.3}, {"max_speed_cm_s": 70.0}, {"track_cm": 2.4}])
def test_the_heading_oracle_turns_by_the_robots_own_wheels(robot):
    """Its first command turns the robot as fast as the drum, and so it slips no more than the default robot."""
    config, oracle = RobotConfig(**robot), BEHAVIOURS["oracle-heading"]
    left, right = oracle.make(np.random.default_rng(0))(State(0.0, 0.0, 0.0, 1.5, 0.4, 0.0, (), config.full_turn))
    assert (left - right) * config.max_speed_cm_s / config.track_cm == pytest.approx(1.5)
    own, usual = (play(oracle, OPTOMOTOR, {"robot": it}, 3001, 90).row()["rms_slip_deg_s"] for it in (robot, "default"))
    assert own <= 1.02 * usual


def test_observations_are_responses():
    numbers = np.array([0.1, -0.2, 1, -2, 0.7, 3, 0.5], np.float32)
    seen, part = response(numbers), response(numbers, ("hs", "vs"))
    assert (seen.hs_spikes, seen.vs_spikes, seen.looming_spikes) == (1, -2, 3)
    assert (seen.hs, seen.vs, seen.looming, seen.azimuth) == pytest.approx((0.1, -0.2, 0.7, 0.5))
    assert all(getattr(part, name) == getattr(seen, name) for name in ("hs", "vs", "hs_spikes", "vs_spikes"))
    assert getattr(part, "azimuth", 0.0) == 0.0


@pytest.mark.parametrize(("name", "model"), [("azimuth", "dsnn"), ("looming_spikes", "dsnn"), ("hs_spikes", "lgmd1")])
def test_a_reflex_cannot_read_what_its_model_does_not_answer(name, model):
    entry = Behaviour("mine", "", OPTOMOTOR, lambda rng: lambda seen: (0.1, getattr(seen, name)), model=model)
    with pytest.raises(AttributeError, match=name):
        play(entry, OPTOMOTOR, {}, 0, 2)


def test_wheels_beyond_the_maximum_are_cut():
    np.testing.assert_array_equal(wheels(lambda seen: (3.0, -2.0), Response()), [1.0, -1.0])


def test_a_user_file_declares_a_behaviour(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(
        "from experiments import Behaviour\n"
        "BEHAVIOUR = Behaviour.reflex('mine', 'spins', 'Optomotor', lambda seen: (0.1, -0.1))\n"
    )
    assert load_behaviour(str(file)).name == "mine"
    file.write_text("BEHAVIOUR = 3\n")
    for wrong in (str(file), "hybird", str(tmp_path / "none.npz")):
        with pytest.raises(UsageError):
            load_behaviour(wrong)


# --- columns ----------------------------------------------------------------------------------------------------------


def test_gain():
    drift = np.array([10.0, 10.0, -20.0])
    assert optomotor_gain(drift, drift) == pytest.approx(0.0)
    assert optomotor_gain(0 * drift, drift) == pytest.approx(1.0)
    assert optomotor_gain(drift / 4, drift) == pytest.approx(0.75)
    assert optomotor_gain(2 * drift, drift) == pytest.approx(-1.0)
    assert optomotor_gain(drift, 0 * drift) is None


def test_an_rms_keeps_swings_that_cancel_in_the_gain():
    """Of a drum at 30 degrees/s: the slip of a robot that stands still, and of one that swings about its rate."""
    episode = play(BEHAVIOURS["still"], OPTOMOTOR, {"slowest_deg_s": 30.0, "fastest_deg_s": 30.0}, 0, 40)
    row = episode.row()
    assert (row["optomotor_gain"], row["rms_slip_deg_s"]) == pytest.approx((0.0, 30.0), abs=0.01)
    episode.infos["slip_deg_s"] = [50.0, -50.0] * 20
    row = episode.row()
    assert (row["optomotor_gain"], row["rms_slip_deg_s"]) == pytest.approx((1.0, 50.0), abs=0.01)


def test_errors_of_gap_and_bearing_are_sizes_against_the_distance_that_is_set():
    episode = play(BEHAVIOURS["still"], PURSUIT, {"distance_cm": 6.0}, 0, 4)
    episode.infos |= {"gap_cm": [4.0, 4.0, 8.0, 12.0], "bearing_deg": [10.0, -10.0, 50.0, -50.0]}
    assert (episode.row()["gap_error_cm"], episode.row()["off_axis_deg"]) == (3.0, 30.0)


# --- recordings -------------------------------------------------------------------------------------------------------


def env(**options):
    return gym.make("colias_sim/Pursuit-v0", observation="neural", model="dsnn", max_episode_steps=STEPS, **options)


def drive(driven, episodes=1, steps=STEPS):
    """Everything that an agent sees of episodes."""
    seen = []
    for episode in range(episodes):
        observation, info = driven.reset(seed=episode)
        seen.append((np.copy(observation), info))
        for step in range(steps):
            taken = driven.step(np.array([0.3, 0.1 * step], np.float32))
            seen.append((np.copy(taken[0]), *taken[1:]))
    return seen


def test_a_recorded_env_is_the_same_env_and_its_recording_what_the_episode_was(tmp_path):
    plain, recorded = env(frame_skip=2), RecordRerun(env(frame_skip=2), tmp_path / "new" / "episode.rrd")
    expected, seen = drive(plain), drive(recorded)
    plain.close()
    for one, other in zip(expected, seen, strict=True):
        np.testing.assert_array_equal(one[0], other[0])
        assert one[1:] == other[1:]
    (path,) = recorded.recorded  # written at the episode's end, not when the env is closed
    recorded.close()
    held = columns(path)
    commands = [[0.3, 0.1 * step] for step in range(STEPS)]
    np.testing.assert_allclose(held["/world/observer/wheels"]["scalars"], commands, atol=1e-6)
    np.testing.assert_allclose(np.ravel(held["/models/dsnn/hs"]["scalars"]), [step[0][0] for step in seen[1:]])
    assert held["/reward"]["frame"] == [*range(STEPS)]
    np.testing.assert_allclose(held["/reward"]["time"], 1e9 * 2 / 30 * np.arange(1, STEPS + 1), atol=1)
    assert held["/__properties/episode"]["return"][0] == pytest.approx([sum(step[1] for step in seen[1:])])
    terms = [name for name in seen[1][4] if name.startswith("reward_")]
    assert terms and held["/reward"]["scalars"] == [[info[name] for name in terms] for *_, info in seen[1:]]
    shown = {
        "/world/observer/camera/image",
        "/world/path",
        "/world/arena/wall",
        "/models/dsnn/hs",
        "/models/dsnn/threshold",
    }
    assert shown <= held.keys()


@pytest.mark.parametrize(
    ("name", "trigger", "files"),
    [("one", None, ["one"]), ("{episode:02d}", None, ["00", "01", "02"]),
     ("odd-{episode}", lambda episode: episode % 2 == 1, ["odd-1"])],
)  # fmt: skip
def test_which_episodes_are_recorded(name, trigger, files, tmp_path):
    recorded = RecordRerun(env(), str(tmp_path / f"{name}.rrd"), trigger)
    drive(recorded, episodes=3)
    recorded.close()
    assert [path.stem for path in recorded.recorded] == files == sorted(path.stem for path in tmp_path.iterdir())


def test_braces_of_a_path_are_its_own(tmp_path):
    recorded = RecordRerun(env(), tmp_path / "{a}{0}{" / "{episode:03d}.rrd")
    drive(recorded)
    recorded.close()
    assert recorded.recorded == [tmp_path / "{a}{0}{" / "000.rrd"]


def test_a_recording_says_its_seed_and_how_it_ended(tmp_path):
    """It is left by a reset or by closing the env, or it ends by its time, or by touching the wall."""
    recorded = RecordRerun(env(), str(tmp_path / "{episode}.rrd"))
    drive(recorded)
    for seed in (None, 2**70):
        recorded.reset(seed=seed)
        recorded.step(np.zeros(2, np.float32))
    recorded.close()
    crash = RecordRerun(gym.make(AVOIDANCE, observation="state"), str(tmp_path / "crash.rrd"))
    crash.reset(seed=0)
    while not crash.step(np.ones(2, np.float32))[2]:
        pass
    crash.close()
    told = [columns(path)["/__properties/episode"] for path in (*recorded.recorded, *crash.recorded)]
    assert [one["ended by"][0] for one in told] == [["time"], ["left"], ["left"], ["touched something"]]
    assert [one["reset seed"][0] for one in told] == [["0"], ["none"], [f"{2**70}"], ["0"]]


def test_what_cannot_be_recorded_is_refused_at_once(tmp_path):
    other = gym.make("CartPole-v1")
    with pytest.raises(UsageError, match="CartPoleEnv is no env of colias_sim"):
        RecordRerun(other, tmp_path / "episode.rrd")
