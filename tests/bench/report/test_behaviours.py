"""Behaviours' figures, by tables made up for them: no behaviour is called best beyond its interval."""

import polars as pl
import pytest
from matplotlib.figure import Figure

from colias_sim.envs import RETURN
from experiments.bench.report.behaviours import _ways, finding


@pytest.mark.parametrize(
    ("returns", "best"),
    [
        ([("one", 9.0, 8.0, 10.0), ("two", 5.0, 4.0, 6.0)], ["one"]),
        ([("one", 5.0, 4.0, 6.0), ("two", 9.0, 8.0, 10.0), ("three", 8.5, 7.0, 9.5)], ["two", "three"]),
        ([("one", 5.0, 1.0, 9.0), ("two", 6.0, 2.0, 9.0), ("three", 7.0, 3.0, 9.0)], []),
        ([("one", 5.0, None, None), ("two", 6.0, None, None)], []),
    ],
)
def test_a_title_names_the_best_only_where_no_interval_of_the_others_reaches_it(returns, best):
    rows = [dict(zip(("behaviour", "value", "ci_low", "ci_high"), row, strict=True)) for row in returns]
    summary = pl.DataFrame(rows).with_columns(measure=pl.lit(RETURN), env=pl.lit("colias_sim/Pursuit-v0"))
    words = finding(summary).split()
    assert ("highest" in words) == bool(best)
    assert {name for name in ("one", "two", "three") if name in words} == set(best)


def test_a_cross_is_where_an_episode_ended_by_touching_something():
    trials = pl.DataFrame({"trial": [0, 1], "repeat": [0, 1], "touched": [True, False]})
    frames = pl.DataFrame({"trial": [0, 0, 1, 1], "x_cm": [0.0, 10.0, 0.0, 20.0], "y_cm": [0.0, 5.0, 0.0, 7.0]})
    axes = Figure().subplots()
    _ways(axes, trials, frames, "red")
    crosses = [line.get_xydata().tolist() for line in axes.lines if line.get_marker() == "x"]
    assert crosses == [[[10.0, 5.0]]]
