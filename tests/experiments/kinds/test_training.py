"""Trained policies: their files, steering, several training seeds together; PPO itself where the extra is set up."""

import dataclasses
import itertools
import sys

import numpy as np
import polars as pl
import pytest
from scipy import stats

from colias_sim import CameraConfig, RobotConfig
from colias_sim.envs import NEURAL
from dsnn import Response
from experiments import UsageError
from experiments.declare.behaviour import WHEELS, TrainedPolicy, load_policy, sense, steer
from experiments.judge.scores import SUMMARY
from experiments.kinds import training as train
from experiments.kinds.episodes import load_behaviour
from experiments.kinds.result import perform
from experiments.store.asked import Asked
from experiments.store.workers import Workers

OPTOMOTOR = "colias_sim/Optomotor-v0"
SENSED = len(NEURAL) + WHEELS
"""Senses of a network: the neural observation, and its last command to the wheels."""
UNTRAINED = TrainedPolicy(OPTOMOTOR, seed=3, steps=512, envs=2, hidden=(5, 4))


def random_policy(policy=UNTRAINED):
    rng = np.random.default_rng(policy.seed)
    sizes = [SENSED, *policy.hidden, WHEELS]
    layers = [(rng.normal(0, 0.3, shape).astype(np.float32), rng.normal(0, 0.3, shape[0]).astype(np.float32))
              for shape in zip(sizes[1:], sizes[:-1], strict=True)]  # fmt: skip
    return dataclasses.replace(policy, layers=layers)


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "policy.npz"
    random_policy().save(path)
    return path


# --- files ------------------------------------------------------------------------------------------------------------


def test_a_policy_comes_back_as_it_was_saved(saved, tmp_path):
    policy, back = random_policy(), load_policy(saved)
    assert back == policy
    for (weights, biases), (w, b) in zip(policy.layers, back.layers, strict=True):
        assert np.array_equal(weights, w) and np.array_equal(biases, b) and w.dtype == np.float32
    random_policy().save(tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == saved.read_bytes()


def test_a_policy_plays_under_the_eye_and_wheels_that_it_was_trained_with(tmp_path):
    options = {"camera": "ov7670", "robot": {"preset": "colias4", "trim": 2}, "randomise": {"light": [0.7, 1.3]}}
    policy = dataclasses.replace(UNTRAINED, options=options)
    random_policy(policy).save(tmp_path / "policy.npz")
    assert load_behaviour(str(tmp_path / "policy.npz")).options == options
    env = train.steered(policy)
    _, info = env.reset(seed=0)
    assert info["randomised"].keys() == {"light"}
    camera, robot = env.unwrapped._sim.camera("observer").config, env.unwrapped._sim.robots["observer"].config
    assert camera == CameraConfig.preset("ov7670")
    assert robot == dataclasses.replace(RobotConfig.preset("colias4"), trim=2)
    env.close()


# --- steering and driving ---------------------------------------------------------------------------------------------


def test_commands_fade_add_up_and_stay_within_their_limit():
    command = np.zeros(2, np.float32)
    for frame in range(1, 30):
        command = steer(command, np.array([1.0, -7.0], np.float32))
        expected = min(0.3, 0.4 * (1 - 0.9**frame))  # the sum of what is kept of 0.04 a frame
        assert command == pytest.approx([expected, -expected], rel=1e-5)
    assert steer(command, np.zeros(2, np.float32)) == pytest.approx([0.27, -0.27])
    assert sense(np.arange(7, dtype=np.float32), command)[-2:] == pytest.approx([1.0, -1.0])


def test_a_policy_answers_with_the_same_bits_alone_and_among_others():
    """A product of matrices sums in another order with another number of rows, and on another processor."""
    policy = random_policy(dataclasses.replace(UNTRAINED, hidden=(32, 32)))
    sensed = np.random.default_rng(1).uniform(-1, 1, (200, SENSED)).astype(np.float32)
    together = policy.answer(sensed)
    assert together.dtype == np.float32
    np.testing.assert_array_equal(together, [policy.answer(one) for one in sensed])
    expected = sensed.astype(float)
    for weights, biases in policy.layers[:-1]:
        expected = np.tanh(expected @ weights.T.astype(float) + biases)
    weights, biases = policy.layers[-1]
    np.testing.assert_allclose(together, expected @ weights.T.astype(float) + biases, rtol=0, atol=1e-6)


def test_each_episode_begins_with_the_wheels_at_rest(saved):
    behaviour = load_behaviour(str(saved))
    assert (behaviour.name, behaviour.env, behaviour.senses) == ("policy", OPTOMOTOR, "neural")
    seen = Response(0.5, 0.1, 1, 0, None, 0.6, 0, -0.3)
    drives = [behaviour.make(np.random.default_rng(0)) for _ in range(2)]
    first, second = drives[0](seen), drives[0](seen)
    assert drives[1](seen) == first != second
    assert max(map(abs, (*first, *second))) <= 0.3


# --- several training seeds -------------------------------------------------------------------------------------------


def test_the_interval_is_that_of_every_resample():
    """Five runs have 3,125 resamples: all of them, not a draw."""
    runs = np.array([0.31, 0.52, 0.55, 0.71, 0.93])
    every = np.sort(np.array(list(itertools.product(runs, repeat=5))), axis=1)[:, 1:4].mean(axis=1)
    estimate = train.interquartile_mean(runs, 0)
    # A draw of 50,000 may stop at the next of these steps.
    for end, share in ((estimate.low, 0.025), (estimate.high, 0.975)):
        assert np.quantile(every, share - 0.003) - 1e-12 <= end <= np.quantile(every, share + 0.003) + 1e-12
    runs = np.random.default_rng(1).normal(size=9)
    assert train.interquartile_mean(runs, 4) == train.interquartile_mean(runs, 4) != train.interquartile_mean(runs, 5)


def planned(env="Optomotor", values=None, **options):
    options = {"steps": 600, "envs": 2, "seeds": 3, **options}
    return train.plan(Asked(kind="training", what=(env,), values=values or {}, seed=3, options=options))


def test_steps_are_whole_rollouts_and_seeds_count_up():
    assert [(policy.seed, policy.steps) for policy in planned().declared] == [(3, 1024), (4, 1024), (5, 1024)]
    for wrong in ({"env": "Pursuit"}, {"values": {"robots": "3"}}):
        with pytest.raises(UsageError):
            planned(**wrong)


def test_what_is_missing_is_trained_and_all_are_judged_together(tmp_path, monkeypatch):
    """The training itself is left out: it needs the extra."""
    trained = []

    def learn(policy, advance):
        trained.append(policy.seed)
        return random_policy(policy), pl.DataFrame({"steps": [1024], "episodes": [0], "return": [None]})

    monkeypatch.setattr(train, "train", learn)
    monkeypatch.setattr(train, "require_training", lambda: None)
    monkeypatch.setattr(train, "JUDGED", 1)
    random_policy(planned().declared[0]).save(tmp_path / "policy-3.npz")
    report = perform(planned(), tmp_path, Workers(0, quiet=True))
    table = pl.read_csv(tmp_path / "policies.csv", schema=SUMMARY)
    assert trained == [4, 5] and report.failures.is_empty()
    rows = {(row["measure"], row["behaviour"]): row for row in table.iter_rows(named=True)}
    assert {behaviour for _, behaviour in rows} == {"PPO", *train.OPPONENTS[OPTOMOTOR]}
    for (measure, behaviour), row in rows.items():
        own = behaviour == "PPO"
        single = report.summary.filter(
            pl.col("behaviour").str.starts_with("policy-") if own else pl.col("behaviour") == behaviour, measure=measure
        )
        assert single.height == (3 if own else 1)
        assert row["value"] == pytest.approx(stats.trim_mean(single["value"], 0.25))
    assert rows["return", "PPO"]["ci_low"] < rows["return", "PPO"]["ci_high"]
    assert {"learning-4.csv", "figure.png"} <= {path.name for path in tmp_path.iterdir()}
    for other in ({"steps": 5000}, {"envs": 4}, {"values": {"camera": "ov7670"}}, {"seeds": 4}):
        with pytest.raises(UsageError, match="choose another"):
            perform(planned(**other), tmp_path, Workers(0, quiet=True))


def test_a_training_without_the_extra_begins_nothing(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    monkeypatch.setitem(sys.modules, "torch._dynamo", None)
    with pytest.raises(ImportError):
        perform(planned(), tmp_path, Workers(0, quiet=True))
    assert not any(tmp_path.iterdir())


# --- with the extra ---------------------------------------------------------------------------------------------------


def test_training_is_repeatable():
    pytest.importorskip("stable_baselines3")
    policy, steps = TrainedPolicy(OPTOMOTOR, seed=1, steps=256, envs=1), []
    (first, curve), (second, _) = (train.train(policy, lambda: steps.append(1)) for _ in range(2))
    assert len(steps) == 512 and curve["steps"].to_list() == [256]
    assert first.steps == 256 and "torch" in first.versions
    for ours, theirs in zip(first.layers, second.layers, strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(ours, theirs, strict=True))


def test_the_exported_network_answers_as_the_model_does():
    pytest.importorskip("stable_baselines3")
    torch = pytest.importorskip("torch")
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import DummyVecEnv

    policy = dataclasses.replace(UNTRAINED, hidden=(32, 32))
    envs = DummyVecEnv([lambda: train.steered(policy)])
    model = PPO("MlpPolicy", envs, seed=0, device="cpu", n_steps=256, batch_size=256,
                policy_kwargs={"net_arch": list(policy.hidden), "activation_fn": torch.nn.Tanh})  # fmt: skip
    envs.close()
    with torch.no_grad():  # as large as trained ones are: initial weights of the last layer are nearly 0
        for part in model.policy.parameters():
            part += 0.1 * torch.randn_like(part)
    sensed = np.random.default_rng(1).uniform(-1, 1, (200, SENSED)).astype(np.float32)
    theirs = model.policy.get_distribution(torch.from_numpy(sensed)).distribution.mean.detach().numpy()
    assert np.abs(train.exported(model, policy).answer(sensed) - theirs).max() < 1e-6
