"""What a run writes into its tables: what does not apply is null, and whatever is written can be gone on with."""

import json
import math
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import experiments
from experiments.cli import main
from experiments.declare.conditions import Condition
from experiments.declare.experiment import Listed
from experiments.judge.sweep import MEASURES
from experiments.store.tables import TrialRecord

COUNTS = ("spikes", "hs_spikes", "vs_spikes", "looming_spikes", "firing_rate_hz", "spikes_in_view", "rate_in_view_hz",
          "spikes_in_window", "spikes_in_inner_window")  # fmt: skip
QUICK = ("--set", "experiment.speeds_cm_s=20", "--workers", "0")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def rows(name: str) -> list[dict]:
    return pl.read_parquet(f"{name}/trials.parquet").to_dicts()


# --- what is written can be read -------------------------------------------------------------------------------------


def test_a_stimulus_that_stops_early_has_no_speed_and_its_run_is_gone_on_with():
    """Open loop, by a motor that turns it aside: it never reaches the stretch of constant speed."""
    slow = Listed((Condition("translation", "rightward", 5.0, 12.0, acceleration_cm_s2=1.5),))
    circle = experiments.Experiment("circle", "", slow, "speed_cm_s", repeats=1)
    driven = {"robot.preset": "colias4", "robot.motor_inequality": 50}
    found = []
    for _ in range(2):
        experiments.run(circle, settings=driven, workers=0, quiet=True, recordings=False, out="out")
        found += rows("out")
    assert found[0] == found[1] and (found[0]["achieved_speed_cm_s"], found[0]["path_error_mm"]) == (None, None)
    assert math.isfinite(found[0]["drift_mm"]) and len(found) == 2


# --- models that do not spike ----------------------------------------------------------------------------------------


def test_counts_of_a_model_that_does_not_spike_are_null():
    models = ("--model", "emd", "--model", "lgmd1")
    assert main.command(["run", "speed", *QUICK, *models, "--repeats", "2", "--no-recordings", "--out", "out"]) == 0
    by_model = {model: [row for row in rows("out") if row["model"] == model] for model in ("dsnn", "emd", "lgmd1")}
    assert all(row[name] is None for row in by_model["emd"] for name in COUNTS)
    assert all(row["spikes"] == row["hs_spikes"] > 0 and row["vs_spikes"] is not None for row in by_model["dsnn"])
    assert all(row["spikes"] == row["looming_spikes"] and row["hs_spikes"] is None for row in by_model["lgmd1"])
    assert MEASURES["spikes"].of(by_model["emd"]) == {"value": None, "n": len(by_model["emd"])}
    summary = {*pl.read_csv("out/summary.csv").select("model", "quantity").rows()}
    assert ("emd", "peak_hs") in summary and not {("emd", name) for name in COUNTS} & summary
    assert pl.read_csv("out/comparisons.csv").select("model", "against").rows() == [("dsnn", "lgmd1")]
    verdicts = {claim["model"]: claim for claim in json.loads(Path("out/claims.json").read_text())["claims"]}
    outcome = verdicts["emd"]["outcome"]
    assert outcome["verdict"] == "not shown" and "does not spike" in outcome["measured"]
    assert experiments.load("out").figure() is not None


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, np.float64("nan")])
def test_a_number_that_is_not_finite_is_refused(value):
    """What does not apply is null, so NaN is a fault, say of the reward of a user's env."""
    frames = pl.DataFrame({"trial": [7]})
    assert TrialRecord(7, ({"reward": None, "frames": 3, "model": "a"},), frames, None).rows
    with pytest.raises(ValueError, match=r"trial 7: reward must be a finite number"):
        TrialRecord(7, ({"reward": 0.0}, {"reward": value}), frames, None)
