"""The contract: small runs of every kind give the rows that they gave in version 0.3.0 (tests/golden/tables)."""

import json
import warnings
from pathlib import Path

import gymnasium as gym
import numpy as np
import polars as pl
import pytest
from polars.testing import assert_frame_equal

import colias_sim  # noqa: F401
from tests.helpers.inside import inside

TABLES = Path(__file__).parent / "golden" / "tables"
ONE = ("--repeats", "1", "--no-recordings")
FIRST_SPEED, FIRST_ANGLE = ("--set", "experiment.speeds_cm_s=2"), ("--set", "experiment.angles_deg=-30")


def models(*names):
    return tuple(part for name in names for part in ("--model", name))


RUNS = {
    "r-general": ("run", "general", "--seed", "3", *ONE),
    "r-speed": ("run", "speed", "--seed", "3", *ONE),
    "r-egomotion": ("run", "egomotion", "--seed", "3", *ONE),
    "r-approach-mechanism": ("run", "approach-mechanism", "--seed", "3", *ONE),
    "r-models": (
        "run", "speed", "--seed", "5", *ONE, *FIRST_SPEED, "--eyes", "both",
        *models("emd", "lgmd2", "lplc2", "flow", "dsnn-onboard"),
    ),
    "r-wheels": (
        "run", "angular-approach", "--seed", "7", *ONE, *FIRST_ANGLE, "--set", "robot.preset=colias4", "--set",
        "camera.preset=ov7670",
    ),
    "c-clean": ("run", "clean", "--seed", "3", *ONE),
    "c-clutter-translation": ("run", "clutter-translation", "--seed", "3", *ONE),
    "t": ("tune", "--only", *models("dsnn", "lgmd2"), "--curve", "speed", "--curve", "l-over-v"),
    "b-optomotor": ("behave", "optomotor", "--episodes", "1", "--no-recordings"),
    "b-fixation": ("behave", "fixation", "--episodes", "1", "--no-recordings"),
    "b-escape": ("behave", "escape-lplc2", "--episodes", "2", "--no-baselines", "--no-recordings"),
}  # fmt: skip
"""Run -> its command: with the numbers and seeds of trials that the experiment as it is declared has."""
KINDS = {
    "r": ("robot", ["experiment", "trial", "model"]),
    "c": ("clips", ["experiment", "trial", "model"]),
    "t": ("tuning", ["clip", "repeat", "model"]),
    "b": ("episodes", ["model", "repeat"]),
}
"""First letter of a run -> its table, and the columns that name a row. Fewer curves or episodes have other trials."""
BY_CLOCK = ("wall_s", "us_", "code", "run", "trial")
SECTIONS = ("dsnn", "robot", "camera", "scene", "emd", "dsn2017")
"""Columns of single parameters begin with these and a point: how tables show settings is not a number."""


def assert_same(golden, today, key):
    """Texts and counts are equal, other numbers to a millionth; rows are named by the columns ``key``."""
    columns = [
        column.name
        for column in golden
        if column.name not in key and column.count() and not column.name.startswith(BY_CLOCK)
        and column.name.split(".")[0] not in SECTIONS
    ]  # fmt: skip
    left_positive = [name for name in columns if "bearing" in name]  # then
    golden = golden.with_columns(-pl.col(name) for name in left_positive)
    one, other = (table.select(*key, *columns).sort(key) for table in (golden, today))
    assert_frame_equal(one, other, check_dtypes=False, rel_tol=5e-7, abs_tol=5e-7)


def run(folder, *command):
    done = inside(folder, [*command, "--out", "out", "--workers", "0", "-q"])
    assert done.returncode == 0, done.stderr
    return folder / "out"


@pytest.mark.parametrize("name", RUNS)
def test_a_run_gives_the_golden_rows(name, tmp_path):
    folder = run(tmp_path, *RUNS[name])
    table, key = KINDS[name[0]]
    golden = pl.read_parquet(TABLES / f"{table}.parquet").filter(run=name)
    assert_same(golden, pl.read_parquet(folder / "trials.parquet"), key)
    frames = TABLES / f"frames-{name}.parquet"
    if frames.exists():
        golden = pl.read_parquet(frames).rename({"sim_time_s": "time_s"}, strict=False)  # its name until 0.4
        key = ["trial", "model", "frame"]
        assert_same(golden, pl.read_parquet(folder / "frames.parquet").join(golden, on=key, how="semi"), key)


def test_the_leaderboard_gives_the_golden_scores(tmp_path):
    folder = run(tmp_path, "leaderboard", "--only", *models("emd", "lgmd1"), "--repeats", "1")
    for board in ("leaderboard.csv", "looming.csv"):
        assert_same(pl.read_csv(TABLES / board), pl.read_csv(folder / board), ["model"])


@pytest.mark.parametrize("name", ["Optomotor", "Fixation", "Pursuit", "Avoidance"])
@pytest.mark.parametrize("observation", ["pixels", "neural", "state"])
def test_an_env_gives_the_golden_return_and_observations(name, observation):
    golden = json.loads((TABLES / "envs.json").read_text())[f"{name}/{observation}"]
    rng, total, means = np.random.default_rng(5), 0.0, []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        env = gym.make(f"colias_sim/{name}-v0", observation=observation)
        env.reset(seed=11)
        for _ in range(golden["steps"]):
            action = rng.uniform(env.action_space.low, env.action_space.high).astype(np.float32)
            seen, reward, ended, cut, _ = env.step(action)
            total += float(reward)
            means.append(float(np.mean(np.asarray(seen, float))))
        env.close()
    assert (ended or cut) == (golden["steps"] < 40)
    assert total == pytest.approx(golden["return"], abs=2e-6)
    np.testing.assert_allclose(means[::8], golden["mean_observation"], atol=2e-6)
