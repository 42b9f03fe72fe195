"""Several training seeds: the interquartile mean and its interval, what is gone on with, refused and written."""

import csv
import itertools
import json
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from experiments.bench.cli import train as command
from experiments.bench.closed_loop import policy_file
from experiments.bench.closed_loop.policy import About, Policy
from experiments.bench.run.errors import UsageError
from experiments.bench.training import evaluate, study
from experiments.bench.training.scores import interquartile_mean

OPTOMOTOR = "colias_sim/Optomotor-v0"
ABOUT = About(OPTOMOTOR, seed=3, steps=600, envs=2)
MADE = {"stable-baselines3": "2.9.2", "torch": "2.13.0"}
ASKED = study.Study(ABOUT, 3)


# --- the number -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("scores", "mean"),
    [
        ([7.0, -50.0, 2.0, 3.0, 900.0], 4.0),  # one of five left out at either end
        ([1.0, 2.0, 3.0, 10.0], 2.5),
        ([1.0, 2.0, 4.0], 7 / 3),  # of three none
        ([8.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], 4.5),
        ([[0.0, 10.0], [1.0, 20.0]], 5.5),  # of all runs' scores together
    ],
)
def test_the_mean_is_of_the_middle_half(scores, mean):
    estimate = interquartile_mean(scores, 0)
    assert estimate.value == pytest.approx(mean) and estimate.n == len(scores)
    assert estimate.low <= estimate.value <= estimate.high


def test_the_interval_is_that_of_every_resample():
    """Five runs have 3,125 resamples: all of them, not a draw."""
    runs = np.array([0.31, 0.52, 0.55, 0.71, 0.93])
    every = np.sort(np.array(list(itertools.product(runs, repeat=5))), axis=1)[:, 1:4].mean(axis=1)
    estimate = interquartile_mean(runs, 0)
    # A draw of 50,000 may stop at the next of these steps.
    for end, share in ((estimate.low, 0.025), (estimate.high, 0.975)):
        assert np.quantile(every, share - 0.003) - 1e-12 <= end <= np.quantile(every, share + 0.003) + 1e-12


def test_runs_are_drawn_within_their_task():
    """Tasks far apart, runs alike: what differs between tasks is no uncertainty."""
    estimate = interquartile_mean([[0.0, 100.0]] * 6, 0)
    assert (estimate.value, estimate.low, estimate.high) == (50.0, 50.0, 50.0)


def test_the_interval_of_several_tasks_is_that_of_numpy():
    rng = np.random.default_rng(5)
    scores = rng.normal([0.0, 0.5, 3.0], 1.0, (6, 3))
    drawn = np.stack([scores[rng.integers(6, size=(20_000, 6)), task] for task in range(3)], axis=-1)
    every = stats.trim_mean(drawn.reshape(20_000, -1), 0.25, axis=1)
    estimate = interquartile_mean(scores, 0)
    assert (estimate.low, estimate.high) == pytest.approx(np.quantile(every, (0.025, 0.975)), abs=0.03)


def test_equal_seeds_give_equal_intervals():
    runs = np.random.default_rng(1).normal(size=9)
    assert interquartile_mean(runs, 4) == interquartile_mean(runs, 4) != interquartile_mean(runs, 5)


def test_one_run_has_no_interval_and_none_is_refused():
    estimate = interquartile_mean([0.4], 0)
    assert estimate.value == 0.4 and np.isnan([estimate.low, estimate.high]).all()
    for wrong in ([], [[]], [0.1, np.nan]):
        with pytest.raises(ValueError, match="legal are finite numbers of one run or more"):
            interquartile_mean(wrong, 0)


def test_the_interval_of_five_runs_is_too_narrow_as_the_documentation_says():
    """By every resample of each of 500 samples of five normal scores: in how many the true mean lies inside."""
    draws, places = (
        np.random.default_rng(2).normal(size=(500, 5)),
        np.array(list(itertools.product(range(5), repeat=5))),
    )
    inside = 0
    for runs in draws:
        every = np.sort(runs[places], axis=1)[:, 1:4].mean(axis=1)
        low, high = np.quantile(every, (0.025, 0.975))
        inside += low <= 0.0 <= high
    assert 0.86 < inside / 500 < 0.93


# --- a study's folder -------------------------------------------------------------------------------------------------


def learnt(asked, folder, seed, *, versions=None):
    """What a training leaves, without the training."""
    about = asked.about(seed)
    rng = np.random.default_rng(seed)
    layers = [
        (rng.normal(0, 0.3, shape).astype(np.float32), np.zeros(shape[0], np.float32)) for shape in about.shapes()
    ]
    fields = {name: getattr(about, name) for name in ("env", "options", "model", "seed", "envs", "hidden", "steering")}
    policy = Policy(About(**fields, steps=asked.steps(), versions=versions or MADE), layers)
    (folder / f"seed-{seed}").mkdir()
    policy_file.save(policy, folder / f"seed-{seed}" / f"policy-{seed}.npz")


@pytest.fixture
def begun(tmp_path):
    """A study of three seeds, of which two are trained."""
    folder = tmp_path / "study"
    assert study.open_folder(ASKED, folder) == []
    for seed in (3, 4):
        learnt(ASKED, folder, seed)
    return folder


def test_what_is_finished_is_known_again(begun):
    assert study.open_folder(ASKED, begun) == [3, 4]
    (begun / "seed-5.part").mkdir()  # of a process that was killed as it wrote
    assert study.open_folder(ASKED, begun) == [3, 4]


def test_a_new_study_overwrites_nothing(tmp_path):
    (tmp_path / "letters.txt").write_text("mine")
    with pytest.raises(FileExistsError, match="holds something already"):
        study.open_folder(ASKED, tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["letters.txt"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"steps": 5000}, "has steps 600, asked for is 5000"),
        ({"seed": 4}, "has seeds 3 to 5, asked for is 4 to 6"),
        ({"envs": 4}, "has envs 2, asked for is 4"),
        ({"options": {"camera": "ov7670"}}, "has options {}, asked for is {'camera': 'ov7670'}"),
        ({"env": "colias_sim/Fixation-v0"}, "has env colias_sim/Optomotor-v0, asked for is colias_sim/Fixation-v0"),
    ],
)
def test_another_study_is_not_gone_on_with(begun, changes, message):
    with pytest.raises(UsageError, match=message):
        study.open_folder(study.Study(replace(ABOUT, **changes), 3), begun)


def test_a_policy_that_is_not_the_studys_is_refused(begun):
    (begun / "seed-4" / "policy-4.npz").replace(begun / "seed-3" / "policy-3.npz")
    with pytest.raises(UsageError, match=r"policy-3.npz: has seed 4, asked for is 3; remove .*seed-3"):
        study.open_folder(ASKED, begun)
    (begun / "seed-3" / "policy-3.npz").write_bytes(b"cut short")
    with pytest.raises(UsageError, match="not a policy file"):
        study.open_folder(ASKED, begun)


def test_policies_of_two_releases_of_pytorch_are_not_mixed(begun, monkeypatch):
    monkeypatch.setattr(study, "installed", lambda: MADE | {"torch": "2.12.0"})
    with pytest.raises(UsageError, match=r"learnt by torch 2.13.0, installed is 2.12.0"):
        study.check_installed(study.versions(ASKED, begun, [3, 4]), begun)
    learnt(ASKED, begun, 5, versions=MADE | {"torch": "2.12.0"})
    with pytest.raises(UsageError, match=r"learnt by torch 2.12.0, earlier seeds by 2.13.0; remove .*seed-5"):
        study.open_folder(ASKED, begun)


# --- the command ------------------------------------------------------------------------------------------------------


def table(folder, name):
    with (folder / name).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_what_is_missing_is_trained_and_all_are_judged(begun, monkeypatch, capsys):
    """The training itself is left out: it needs the extra, see tests/bench/training/test_train.py."""
    trained = []

    def train(asked, folder, seed, resources):
        trained.append(seed)
        learnt(asked, folder, seed)

    monkeypatch.setattr(study, "train", train)
    monkeypatch.setattr(study, "installed", lambda: MADE)
    monkeypatch.setattr(command, "_require_training", lambda: None)
    monkeypatch.setattr(evaluate, "JUDGED", 1)
    before = (begun / "seed-3" / "policy-3.npz").stat().st_mtime_ns
    asked = {"env": "Optomotor", "seed": 3, "seeds": 3, "steps": 600, "envs": 2, "out": begun, "workers": 0}
    assert command.train(**asked) == 0
    assert trained == [5] and (begun / "seed-3" / "policy-3.npz").stat().st_mtime_ns == before
    printed = " ".join(capsys.readouterr().out.split())
    assert "3 training seeds (3 to 5) of 1,024 steps in 2 envs; 1 episode each" in printed
    assert "torch 2.13.0" in printed and "3 training seeds are few" in printed

    values = defaultdict(list)
    for row in table(begun, "scores.csv"):
        behaviour = "PPO" if row["behaviour"].startswith("policy-") else row["behaviour"]
        values[row["measure"], behaviour].append(float(row["value"]))
    rows = {(row["measure"], row["behaviour"]): row for row in table(begun, "policies.csv")}
    opponents = {"optomotor-pi", "optomotor", "still", "random", "oracle-heading"}
    assert {behaviour for _, behaviour in rows} == {"PPO", *opponents}
    assert {measure for measure, _ in rows} == {"optomotor gain", "RMS slip (deg/s)", "return"}
    for (measure, behaviour), row in rows.items():
        assert float(row["value"]) == pytest.approx(stats.trim_mean(values[measure, behaviour], 0.25))
        assert row["interval_over"] == ("training seeds" if behaviour == "PPO" else "episodes")
        assert (row["training_seeds"], row["steps"], row["envs"], row["torch"]) == ("3 to 5", "1024", "2", "2.13.0")
    assert float(rows["return", "PPO"]["ci_low"]) < float(rows["return", "PPO"]["ci_high"])
    assert (begun / "policies.png").exists() and (begun / "policies.svg").exists()
    assert json.loads((begun / "training.json").read_text())["seeds"] == [3, 4, 5]

    first = (begun / "policies.csv").read_bytes()
    assert command.train(**asked) == 0 and trained == [5], "again: nothing is trained, nothing played"
    assert (begun / "policies.csv").read_bytes() == first
