"""What ``colias run --again`` compares: which differences are rounding, and by what CPU numbers are."""

import json
from pathlib import Path
from types import SimpleNamespace

import cv2
import polars as pl
import pytest

from experiments.cli import main
from experiments.kinds.compare import ROUNDING, first_difference
from experiments.store.tables import cpu_features

FRAMES = pl.DataFrame({
    "trial": [0, 0, 0, 0], "model": ["dsnn", "dsnn", "emd", "emd"], "hs": [0.5, -0.1, 2e-3, 1e-3],
    "vs": [1e-9, 2e-9, 0.0, 0.0], "hs_spikes": [300_000, 0, None, None], "stimulus_x_cm": [40.0, 1e-15, 40.0, 1e-15],
    "wall_s": [1.0, 1.0, 1.0, 1.0],
})  # fmt: skip


def with_value(column: str, row: int, value: float | None):
    """A run whose frames have another value in one place."""
    values = FRAMES[column].to_list()
    values[row] = value
    return SimpleNamespace(trials=FRAMES.clear(), frames=FRAMES.with_columns(pl.Series(column, values)))


RUN = with_value("hs", 0, 0.5)


@pytest.mark.parametrize("column, row, value", [
    ("hs", 1, -0.1 + 4.9e-6), ("hs", 2, 2e-3 + 1.9e-8),  # a hundred-thousandth of 0.5, and of another model's 0.002
    ("vs", 0, 3e-9),  # of a size that HS has
    ("stimulus_x_cm", 1, -3e-15),
])  # fmt: skip
def test_up_to_a_hundred_thousandth_of_the_size_is_rounding(column, row, value):
    other = with_value(column, row, value)
    assert first_difference(RUN, other).startswith("frames.parquet, trial 0, model ")
    assert first_difference(RUN, other, ROUNDING) == "" == first_difference(other, RUN, ROUNDING)


@pytest.mark.parametrize("column, row, value", [
    ("hs", 1, -0.1 + 5.1e-6), ("hs", 2, 2e-3 + 2.1e-8), ("vs", 2, 3e-8), ("stimulus_x_cm", 1, 5e-4),
    ("hs_spikes", 0, 300_001),  # a count is equal or not, whatever its size
    ("hs_spikes", 2, 0), ("hs", 0, None),
])  # fmt: skip
def test_more_is_a_difference_and_so_is_any_of_counts_and_of_what_is_not_there(column, row, value):
    other = with_value(column, row, value)
    for part in (0.0, ROUNDING):
        assert f" {column} is " in first_difference(RUN, other, part)
        assert f" {column} is " in first_difference(other, RUN, part)


def test_equal_rows_have_no_difference_whatever_they_took():
    assert first_difference(RUN, with_value("wall_s", 0, 2.0)) == ""
    assert "rows" in first_difference(RUN, SimpleNamespace(trials=FRAMES.clear(), frames=FRAMES[:2]), ROUNDING)


def test_the_features_are_those_that_the_cpu_has():
    supported = {cv2.getHardwareFeatureName(i): cv2.checkHardwareSupport(i) for i in range(1, 512)}
    listed = cv2.getCPUFeaturesLine().replace("*", "").replace("?", "").split()
    assert cpu_features().split() == [name for name in listed if supported[name]]


def test_a_run_of_another_cpu_is_equal_up_to_rounding(tmp_path, monkeypatch, capfd):
    """And run.json says which CPU computed it; a larger difference is told by the exit status."""
    monkeypatch.chdir(tmp_path)
    small = ("--set", "plain.rows=30", "--set", "plain.columns=40", "--set", "plain.width=10")
    assert main.command(["watch", "plain", *small, "--out", "a", "-q", "--no-view"]) == 0
    file, frames = Path("a/run.json"), pl.read_parquet("a/frames.parquet")
    description = json.loads(file.read_text())
    assert description["cpus"] == [cpu_features()]
    file.write_text(json.dumps(description | {"cpus": ["NEON"]}))
    for part, status, said in (
        (1e-6, 0, "equal up to rounding: every row of a "),
        (1e-4, 1, "differs: frames.parquet"),
    ):
        frames.with_columns(pl.col("hs") * (1.0 + part)).write_parquet("a/frames.parquet")
        assert main.command(["run", "--again", "a", "--out", f"again-{status}", "-q"]) == status
        out, err = capfd.readouterr()
        assert out.startswith(said) and "NEON" in err
