"""Runs in odd places: a user without a home, one episode, a robot at rest, one repeat."""

from __future__ import annotations

import csv
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import polars as pl

from tests.helpers.processes import QUICK

ROOT = Path(__file__).parents[2]
NOBODY = """
import os, pwd
def unknown(uid):
    raise KeyError(f"getpwuid(): uid not found: {uid}")
pwd.getpwuid = unknown
from experiments.bench.cli.entry import main
main()
"""


def test_a_user_without_a_home_gets_rows(tmp_path):
    """As in a container that is started with any number for a user."""
    environment = {name: value for name, value in os.environ.items() if name not in ("HOME", "XDG_CACHE_HOME")}
    command = [sys.executable, "-c", NOBODY, "run", "speed", *QUICK, "--workers", "0", "--out", "out", "-q"]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert pl.read_parquet(tmp_path / "out" / "trials.parquet").height
    assert len(json.loads((tmp_path / "out" / "run.json").read_text())["reference_frames"][0]) == 12


def test_one_episode_has_no_interval_and_a_robot_at_rest_a_gain_of_0(colias):
    done = colias("behave", "optomotor", "--episodes", "1", "--out", "out", "--no-recordings", "--workers", "0")
    assert done.returncode == 0, done.stderr
    assert "nan" not in done.stdout and not re.search(r"\de-\d", done.stdout)
    with (colias.folder / "out" / "summary.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {(row["ci_low"], row["ci_high"]) for row in rows} == {("", "")}
    still = colias("behave", "still", "--env", "Optomotor", "--episodes", "3", "--no-baselines", "--no-recordings",
                   "--out", "still", "--workers", "0")  # fmt: skip
    assert still.returncode == 0, still.stderr
    assert re.search(r"still +0 ", still.stdout), still.stdout
    assert pl.read_parquet(colias.folder / "still" / "trials.parquet")["optomotor_gain"].to_list() == [0.0] * 3


def test_one_repeat_leaves_empty_cells_in_a_map(colias):
    grid = ("--measure", "spikes", "--over", "dsnn.n_con=4,8")
    done = colias("sweep", "speed", *QUICK[:4], *grid, "--out", "out", "--workers", "0")
    assert done.returncode == 0, done.stderr
    with (colias.folder / "out" / "counts.csv").open() as file:
        assert {(row["n"], row["ci_low"], row["ci_high"]) for row in csv.DictReader(file)} == {("1", "", "")}
