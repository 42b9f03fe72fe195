from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import polars as pl
import pytest
import rerun as rr

from colias_sim.envs import ENVS, Other, State
from dsnn import Response
from experiments.behaviours import (
    AHEAD,
    AVOIDANCE,
    BEHAVIOURS,
    FIXATION,
    FIXATION_GAINS,
    OPTOMOTOR,
    OPTOMOTOR_GAINS,
    ProportionalIntegral,
    Saccades,
)
from experiments.bench.closed_loop import claims as closed_loop_claims
from experiments.bench.closed_loop import recording as closed_loop_recording
from experiments.bench.closed_loop.behaviour import Behaviour, by_name
from experiments.bench.closed_loop.episode import EpisodeSpec, Setting, agent, play_behaviour, play_entry
from experiments.bench.closed_loop.find import env_id, load_behaviour
from experiments.bench.closed_loop.run import BehaviourPlan, plan, score
from experiments.bench.closed_loop.scores import (
    finished,
    free_distance,
    mean,
    mean_difference,
    optomotor_gain,
    rate,
    rate_ratio,
    scores,
)
from experiments.bench.closed_loop.seen import response
from experiments.bench.closed_loop.steering import Steering
from experiments.bench.run.errors import UsageError
from tests.conftest import Colias
from tests.helpers.episodes import gaze, outcomes, rows

SILENT = Response()


@pytest.fixture(params=list(BEHAVIOURS))
def entry(request):
    return BEHAVIOURS[request.param]


def test_every_behaviour_plays_in_its_env(entry):
    spec = EpisodeSpec(0, 0, 5, Setting(entry.name, entry.env, steps=12))
    episode = play_behaviour(spec, images=True)
    assert episode.steps == 12
    assert np.isfinite(episode.rewards).all() and (np.abs(episode.wheels) <= 1).all()
    assert len(episode.frames) == (12 if entry.senses == "neural" else 0)
    assert (episode.series is not None) == (entry.senses == "neural")
    again = play_behaviour(spec, images=True)
    np.testing.assert_array_equal(again.wheels, episode.wheels)
    np.testing.assert_array_equal(again.frames, episode.frames)


def test_baselines_are_behaviours_of_envs():
    for env, entry in ENVS.items():
        assert set(entry.baselines) <= set(BEHAVIOURS)
        assert [BEHAVIOURS[name].env for name in entry.baselines if name.startswith("oracle")] == [env]


def test_two_behaviours_do_not_share_a_name():
    one = BEHAVIOURS["still"]
    with pytest.raises(ValueError, match="share a name"):
        by_name([one, one])


def test_equal_seeds_are_equal_worlds_whoever_plays():
    paths = []
    for name in ("still", "oracle-target", "fixation"):
        episode = play_behaviour(EpisodeSpec(0, 0, 3, Setting(name, FIXATION, steps=40)), images=False)
        paths.append(episode.paths["target"])
    for other in paths[1:]:  # one solver moves all robots: the others' wheels round what it finds otherwise
        np.testing.assert_allclose(other, paths[0], atol=1e-6)


# The reflexes turn the right way.


def test_optomotor_turns_with_the_motion():
    left, right = BEHAVIOURS["optomotor"].make(np.random.default_rng())(Response(hs=0.5))
    assert left == -right > 0  # rightward: clockwise
    assert BEHAVIOURS["optomotor"].make(np.random.default_rng())(SILENT) == (0.0, 0.0)


def stepped(name, seen, frames):
    """Wheels of a behaviour that sees the same for some frames, (frames, 2)."""
    policy = BEHAVIOURS[name].make(np.random.default_rng())
    return np.array([policy(seen) for _ in range(frames)])


@pytest.mark.parametrize(("name", "channel"), [("optomotor-pi", "hs"), ("fixation-pi", "azimuth")])
def test_a_pi_reflex_turns_as_a_policy_that_gives_its_answers(name, channel):
    """Proportional and integral by hand, through the policy's `Steering`, to the right of what is positive."""
    gains = {"optomotor-pi": OPTOMOTOR_GAINS, "fixation-pi": FIXATION_GAINS}[name]
    proportional, integral = gains
    steering, command, total = Steering(), np.zeros(2, np.float32), 0.0
    policy = BEHAVIOURS[name].make(np.random.default_rng())
    for error in np.random.default_rng(1).uniform(-0.3, 0.3, 40).tolist():
        total = np.clip(total + integral * error / 30, -1.0, 1.0)
        answer = proportional * error + total
        command = steering.command(command, np.array([answer, -answer], np.float32))
        assert policy(Response(**{channel: error})) == pytest.approx(command.tolist(), abs=1e-6)
    right = stepped(name, Response(**{channel: 0.2}), 60)
    assert (right[:, 0] == -right[:, 1]).all() and (right[:, 0] > 0).all()
    np.testing.assert_array_equal(stepped(name, Response(**{channel: -0.2}), 60), -right)
    assert not stepped(name, SILENT, 5).any()


def test_an_integral_does_not_wind_up():
    """After minutes of a full error it takes as many frames to turn back as after its answer's ends are reached."""

    def frames_to_turn_back(frames):
        policy = ProportionalIntegral(lambda seen: seen.hs, 0.5, 1.0)
        for _ in range(frames):
            policy(Response(hs=1.0))
        return next(frame for frame in range(999) if policy(Response(hs=-1.0))[0] < 0)

    assert frames_to_turn_back(90) == frames_to_turn_back(9000)


def test_fixation_turns_towards_motion():
    left, right = BEHAVIOURS["fixation"].make(np.random.default_rng())(Response(azimuth=-0.5))
    assert left == -right < 0


@pytest.mark.parametrize(("name", "seen", "side"), [
    ("avoidance", Response(hs=0.4, looming_spikes=1), -1.0),
    ("avoidance", Response(hs=-0.4, looming_spikes=1), 1.0),
    ("hybrid", Response(azimuth=-0.4, looming_spikes=1), 1.0),
    ("hybrid", Response(azimuth=0.4, looming_spikes=1), -1.0),
])  # fmt: skip
def test_looming_is_turned_away_from(name, seen, side):
    policy = BEHAVIOURS[name].make(np.random.default_rng())
    ahead = policy(SILENT)
    assert ahead[0] == ahead[1] > 0
    left, right = policy(seen)
    assert left == -right and left * side > 0


def test_a_saccade_lasts_and_looks_away():
    policy = Saccades(lambda seen: 1.0)
    loom = Response(looming_spikes=1)
    turning = [policy(loom)[0] != AHEAD for _ in range(policy.TURN_FRAMES + policy.ECHO_FRAMES)]
    assert turning == [True] * policy.TURN_FRAMES + [False] * policy.ECHO_FRAMES
    assert policy(loom)[0] == -policy(SILENT)[1]  # then at once again


@pytest.mark.parametrize("hold", [True, False])
def test_a_held_side_stays_while_looming_goes_on(hold):
    sides = iter([1.0, -1.0, 1.0, -1.0])
    policy = Saccades(lambda seen: next(sides), hold=hold)
    turns = [policy(Response(looming_spikes=1)) for _ in range(3 * (policy.TURN_FRAMES + policy.ECHO_FRAMES))]
    begun = [math.copysign(1.0, left) for left, right in turns if left == -right][:: policy.TURN_FRAMES]
    assert begun == ([1.0, 1.0, 1.0] if hold else [1.0, -1.0, 1.0])
    for _ in range(policy.HOLD + 1):
        policy(SILENT)
    assert math.copysign(1.0, policy(Response(looming_spikes=1))[0]) == -1.0


def test_privileged_ones_use_what_they_are_told():
    state = State(0.0, 0.0, 0.0, 1.0, 0.5, 0.0, (Other(0.1, -0.3, 0.0, 0.0),))
    left, right = BEHAVIOURS["oracle-heading"].make(np.random.default_rng())(state)
    assert left - right == pytest.approx(1.0 * 0.032 / 0.35)  # undoes 1 rad/s to the left
    assert BEHAVIOURS["oracle-target"].make(np.random.default_rng())(state)[0] < 0  # to the left


@pytest.mark.parametrize(("name", "env", "column"), [
    ("oracle-heading", OPTOMOTOR, "rms_slip_deg_s"),
    ("oracle-target", FIXATION, "rms_off_axis_deg"),
])  # fmt: skip
def test_an_oracle_knows_the_truth_under_the_robots_own_wheels_too(name, env, column):
    """Their dead band swallows small commands: without memory `oracle-heading` stands as `still` does."""
    truth, still = (
        finished(play_entry(BEHAVIOURS[who], env, {"robot": "colias4"}, 3000, steps=150), 0, 0, None).rows[0]
        for who in (name, "still")
    )
    assert truth[column] < still[column] / 2 and truth["reward"] > still["reward"]


def test_observations_are_responses():
    seen = response(np.array([0.1, -0.2, 1, -2, 0.7, 3, 0.5], np.float32))
    assert (seen.hs_spikes, seen.vs_spikes, seen.looming_spikes) == (1, -2, 3)
    assert (seen.hs, seen.vs, seen.looming, seen.azimuth) == pytest.approx((0.1, -0.2, 0.7, 0.5))


@pytest.mark.parametrize(("name", "model", "channels"), [
    ("azimuth", "dsnn", "hs, vs"),
    ("looming_spikes", "dsnn", "hs, vs"),
    ("looming", "dsnn", "hs, vs"),
    ("hs", "lgmd1", "looming"),
    ("hs_spikes", "lgmd1", "looming"),
])  # fmt: skip
def test_a_reflex_cannot_read_what_its_model_does_not_answer(name, model, channels):
    entry = Behaviour("mine", "", OPTOMOTOR, lambda rng: lambda seen: (0.1, getattr(seen, name)), model=model)
    with pytest.raises(UsageError) as caught:
        play_entry(entry, OPTOMOTOR, {}, 0, steps=2)
    message = f"the reflex reads {name}, which {model} does not answer; its channels are {channels}"
    assert str(caught.value) == message


def test_what_a_model_declares_is_read_as_ever():
    numbers = np.array([0.1, -0.2, 1, -2, 0.7, 3, 0.5], np.float32)
    whole, part = response(numbers), response(numbers, ("hs", "vs"), "dsnn")
    assert all(getattr(part, name) == getattr(whole, name) for name in ("hs", "vs", "hs_spikes", "vs_spikes"))
    assert isinstance(part, Response) and "azimuth" not in repr(part)
    assert getattr(part, "azimuth", 0.0) == 0.0


def test_wheels_beyond_the_maximum_are_cut():
    act = agent(lambda seen: (3.0, -2.0), "neural")
    np.testing.assert_array_equal(act(np.zeros(7, np.float32)), [1.0, -1.0])


# Scores.


@pytest.mark.parametrize(("hits", "low", "high"), [(0, 0.0, 3.689), (1, 0.0253, 5.572), (10, 4.795, 18.39)])
def test_rates_have_garwoods_intervals(hits, low, high):
    """The table of Garwood 1936."""
    score = rate(rows(hits, 20 - hits, metres=0.05), "driven_m")
    assert (score.value, score.low, score.high) == pytest.approx((hits, low, high), rel=1e-3)


def test_free_distance_is_the_rates_reciprocal():
    played = rows(4, 6, metres=2.0)
    per_metre, free = rate(played, "driven_m"), free_distance(played)
    assert (free.value, free.low, free.high) == pytest.approx((5.0, 1 / per_metre.high, 1 / per_metre.low))
    assert free_distance(rows(0, 3)).value == math.inf


def test_the_ratio_of_rates_is_exact():
    """Equal counts over stretches of 1:4 are a ratio of 4; the interval of a half is symmetric in the logarithm."""
    score = rate_ratio(rows(10, metres=1.0), rows(10, metres=4.0))
    assert score.value == pytest.approx(4.0)
    assert score.low * score.high == pytest.approx(16.0)
    assert score.low < 4.0 < score.high
    assert rate_ratio(rows(9), rows(0, 9)).value == math.inf
    assert rate_ratio(rows(9), rows(0, 9)).low > 1.0
    assert math.isnan(rate_ratio(rows(0, 5), rows(0, 5)).value)


def test_gain():
    drift = np.array([10.0, 10.0, -20.0])
    assert optomotor_gain(drift, drift) == pytest.approx(0.0)
    assert optomotor_gain(0 * drift, drift) == pytest.approx(1.0)
    assert optomotor_gain(drift / 4, drift) == pytest.approx(0.75)
    assert optomotor_gain(2 * drift, drift) == pytest.approx(-1.0)
    assert optomotor_gain(drift, 0 * drift) is None


def test_what_differs_between_worlds_cancels_in_a_difference_at_equal_seeds():
    worlds = np.random.default_rng(0).normal(0, 100, 20).tolist()
    first = [row | {"reward": world + 3.0} for row, world in zip(rows(0, 20), worlds, strict=True)]
    second = [row | {"reward": world} for row, world in zip(rows(0, 20), worlds, strict=True)]
    score = mean_difference(first, second[::-1], "reward")
    assert (score.value, score.low, score.high, score.n) == pytest.approx((3.0, 3.0, 3.0, 20))
    assert mean_difference(first[:5], second[5:], "reward") is None


def test_an_rms_keeps_swings_that_cancel_in_the_gain():
    """Of a drum at 30 degrees/s: the slip of a robot that swings about its rate, and of one that stands still."""
    still = play_entry(BEHAVIOURS["still"], OPTOMOTOR, {"slowest_deg_s": 30.0, "fastest_deg_s": 30.0}, 0, steps=40)
    swings = dataclasses.replace(still, infos={**still.infos, "slip_deg_s": np.tile([50.0, -50.0], 20)})
    one, other = (finished(episode, 0, 0, None).rows[0] for episode in (still, swings))
    assert (one["optomotor_gain"], one["rms_slip_deg_s"]) == pytest.approx((0.0, 30.0), abs=0.01)
    assert (other["optomotor_gain"], other["rms_slip_deg_s"]) == pytest.approx((1.0, 50.0), abs=0.01)


def test_scores_are_those_of_the_env():
    assert set(scores(rows(1, 1), AVOIDANCE)) == {"collisions/min", "collisions/m", "free distance (m)", "return"}
    assert scores(rows(0, 4, in_view=0.5), FIXATION)["time on target"].value == 0.5
    assert mean(rows(1), "in_view") is None


def test_no_interval_of_a_share_goes_beyond_all_and_none_of_a_distance_below_0():
    """Student's interval of four episodes at 1, 1, 1 and 0.8 would end at 1.11."""
    in_view = (1.0, 1.0, 1.0, 0.8)
    shares = [row for value in in_view for row in rows(0, 1, in_view=value, off_axis_deg=5 - 5 * value)]
    shares = [row | {"seed": seed} for seed, row in enumerate(shares)]
    on_target, off_axis = mean(shares, "in_view"), mean(shares, "off_axis_deg")
    assert on_target.low < on_target.value < on_target.high == 1.0
    assert 0.0 == off_axis.low < off_axis.value < off_axis.high
    other = [row | {"in_view": 0.0} for row in shares]
    assert mean_difference(shares, other, "in_view").high > 1.0  # of a difference nothing is cut


# Claims.


def verdicts(hybrid, lgmd, straight):
    avoiding = {AVOIDANCE: {"hybrid": hybrid, "lgmd": lgmd, "straight": straight}}
    return {claim: outcome.verdict for claim, outcome in outcomes(gaze() | avoiding).items()}


def test_claims_hold_where_their_whole_interval_does():
    good = rows(1, 19, metres=4.0), rows(12, 8, metres=3.0), rows(20, metres=0.4)
    assert verdicts(*good) == dict.fromkeys(("B1", "B2", "B3", "B4"), "holds")
    near = rows(10, 10, metres=3.0)  # rarer, but not for sure
    assert verdicts(near, rows(12, 8, metres=3.0), rows(20, metres=0.4))["B2"] == "fails"
    assert verdicts(near, near, rows(20, metres=1.0))["B1"] == "fails"


def test_claims_need_twenty_seeds():
    few = rows(1, 5, metres=4.0), rows(5, 1), rows(6, metres=0.4)
    assert verdicts(*few)["B1"] == verdicts(*few)["B2"] == "not shown"
    assert {claim.outcome.verdict for claim in closed_loop_claims.judge({})} == {"not shown"}


def test_the_plans_are_of_known_behaviours_at_equal_seeds():
    for behaviour_plan in closed_loop_claims.plans(3, 7):
        assert isinstance(behaviour_plan, BehaviourPlan)
        assert all(setting.behaviour in BEHAVIOURS for setting in behaviour_plan.settings)
        assert {spec.seed for spec in behaviour_plan.specs()} == {7, 8, 9}
        assert [spec.index for spec in behaviour_plan.specs()] == list(range(3 * len(behaviour_plan.settings)))


# Plans and wrong uses.


@pytest.mark.parametrize("name", ["Fixation", "Fixation-v0", FIXATION])
def test_envs_by_short_names(name):
    assert env_id(name) == FIXATION


def test_a_plan_has_the_baselines_of_its_env():
    behaviour_plan = plan("optomotor", "Avoidance", ["robots=3", "arena=bright"], 2, 0, baselines=True)
    assert [setting.behaviour for setting in behaviour_plan.settings] == ["optomotor", *ENVS[AVOIDANCE].baselines]
    assert dict(behaviour_plan.settings[0].options) == {"robots": 3, "arena": "bright"}


def test_a_user_file_declares_a_behaviour(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(
        "from experiments.bench.closed_loop.find import Behaviour\n"
        "BEHAVIOUR = Behaviour.reflex('mine', 'spins', 'Optomotor', lambda seen: (0.1, -0.1))\n"
    )
    assert isinstance(load_behaviour(str(file)), Behaviour)
    (tmp_path / "none.py").write_text("BEHAVIOUR = 3\n")
    with pytest.raises(UsageError, match="expected a Behaviour"):
        load_behaviour(str(tmp_path / "none.py"))


# What it leaves.


def test_a_recording_reads_back(tmp_path):
    spec = EpisodeSpec(0, 0, 2, Setting("hybrid", AVOIDANCE, steps=15))
    episode = play_behaviour(spec, images=True)
    path = tmp_path / "episode.rrd"
    path.write_bytes(closed_loop_recording.record(episode))
    entities = {str(chunk.entity_path) for chunk in rr.chunk.RrdReader(path).stream().to_chunks()}
    wanted = {"/world/observer/camera/image", "/world/observer", "/world/path", "/world/arena/wall",
              "/models/hybrid/hs",              "/models/hybrid/looming", "/models/hybrid/azimuth",
              "/world/observer/wheels", "/reward"}  # fmt: skip
    assert wanted <= entities


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    colias = Colias(tmp_path_factory.mktemp("behave"))
    done = colias("behave", "optomotor", "--episodes", "2", "--out", "run", "--workers", "2", "--set", "robots=1")
    return colias, done


def test_behave_prints_scores_and_leaves_files(played):
    colias, done = played
    assert done.returncode == 0, done.stderr
    for name in ("optomotor", *ENVS[OPTOMOTOR].baselines, "optomotor gain", "figure.png", "colias view run"):
        assert name in done.stdout
    assert "Traceback" not in done.stderr
    folder = colias.folder / "run"
    table = pl.read_parquet(folder / "trials.parquet").to_dicts()
    assert len(table) == 8 and {row["seed"] for row in table} == {0, 1}
    gains = {name: np.mean([r["optomotor_gain"] for r in table if r["model"] == name]) for name in BEHAVIOURS if
             any(r["model"] == name for r in table)}  # fmt: skip
    assert gains["oracle-heading"] > 0.9 and abs(gains["straight"]) < 0.05
    assert len(list((folder / "recordings").glob("*.rrd"))) == 2  # of the behaviour asked for
    assert pl.read_parquet(folder / "frames.parquet").height == sum(row["frames"] for row in table)
    assert json.loads((folder / "run.json").read_text())["settings"][0]["options"] == [["robots", 1]]


def test_behave_goes_on_where_it_was_and_refuses_another(played):
    colias, _ = played
    before = (colias.folder / "run" / "trials.parquet").read_bytes()
    again = colias("behave", "optomotor", "--episodes", "2", "--out", "run", "--workers", "2", "--set", "robots=1")
    assert again.returncode == 0 and "of them done already" in again.stderr
    assert (colias.folder / "run" / "trials.parquet").read_bytes() == before
    other = colias("behave", "optomotor", "--episodes", "3", "--out", "run", "--workers", "1", "--set", "robots=1")
    assert other.returncode == 2 and len(other.stderr.strip().splitlines()) == 1


def test_numbers_do_not_depend_on_workers(played, tmp_path):
    colias, _ = played
    done = colias("behave", "optomotor", "--episodes", "2", "--out", "alone", "--workers", "0", "--set", "robots=1",
                  "--no-baselines", "-q")  # fmt: skip
    assert done.returncode == 0 and done.stdout == "" and done.stderr == ""
    one = pl.read_parquet(colias.folder / "run" / "trials.parquet").to_dicts()[:2]
    assert pl.read_parquet(colias.folder / "alone" / "trials.parquet").to_dicts() == one


def test_scoring_needs_an_episode():
    with pytest.raises(UsageError, match="--episodes must be"):
        score(BEHAVIOURS["still"], episodes=0)
