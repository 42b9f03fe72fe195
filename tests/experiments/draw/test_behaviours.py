"""Behaviours' figures, by tables made up for them: no behaviour is called best beyond its interval."""

import numpy as np
import polars as pl
import pytest

from colias_sim.envs import ENVS, RETURN
from experiments.draw.behaviours import draw, finding, show
from experiments.judge.scores import summary
from experiments.judge.tests import Score
from scenes import ARENA_RADIUS_CM
from tests.helpers.episodes import rows

PURSUIT = "colias_sim/Pursuit-v0"


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
    scores = [dict(zip(("behaviour", "value", "ci_low", "ci_high"), row, strict=True)) for row in returns]
    table = pl.DataFrame(scores).with_columns(measure=pl.lit(RETURN), env=pl.lit("colias_sim/Pursuit-v0"))
    words = finding(table).split()
    assert ("highest" in words) == bool(best)
    assert {name for name in ("one", "two", "three") if name in words} == set(best)


def test_without_intervals_of_returns_a_title_tells_what_those_of_collisions_do():
    rates = [("one", 30.0, 4.0, 90.0), ("two", 0.0, 0.0, 2.0), ("three", 1.0, 0.1, 5.0), ("four", 2.0, 0.5, 6.0)]
    for least, found in ((4.0, {"two", "1", "3"}), (1.0, set())):
        columns = ("behaviour", "value", "ci_low", "ci_high")
        scores = pl.DataFrame([(*rates[0][:2], least, 90.0), *rates[1:]], columns, orient="row")
        table = scores.with_columns(measure=pl.lit("collisions/min"), env=pl.lit(PURSUIT))
        assert {word for word in finding(table).split() if word in "one two three four 1 2 3 4"} == found


def test_measures_and_paths_are_the_tables_and_stand_with_their_behaviour(capsys):
    """A stroke for each episode, a dot with its interval for each measure; a cross where a path ended by touching."""
    rng, names = np.random.default_rng(0), ("one", "two", "three")
    columns = {**ENVS[PURSUIT].measures, RETURN: "reward"}
    values = (pl.Series(column, rng.uniform(0, 1, 18)) for column in columns.values())
    trials = pl.concat(rows(2, 4, name=name, env=PURSUIT) for name in names)
    trials = trials.with_columns(pl.Series("trial", rng.permutation(18)), *values)
    places = {f"{axis}_cm": rng.uniform(-40, 40, 54) for axis in "xy"}
    frames = pl.DataFrame({"trial": np.repeat(range(18), 3), **places})
    figure = draw(trials, frames, "")
    titles = {axes: axes.get_title("left").replace("\n", " ") for axes in figure.axes if axes.get_visible()}
    better = {
        title[:-2]: title[-1] for title in titles.values() if title[-1] in "\N{LEFTWARDS ARROW}\N{RIGHTWARDS ARROW}"
    }
    assert better[RETURN] == better["time on target"] != better["collisions/min"] == better["gap error (cm)"]
    panels = {title[:-2] if title[:-2] in better else title: axes for axes, title in titles.items()}
    scores, found = summary(trials, PURSUIT, ""), {}
    assert panels.keys() == {*columns, "collisions/min", *names}
    ticks = panels["time on target"].get_yticklabels()
    of_row = {tick.get_position()[1]: tick.get_text() for tick in ticks}
    for measure in panels.keys() - {*names}:
        axes = panels[measure]
        for line in axes.lines:
            found.setdefault((of_row[line.get_ydata()[0]], line.get_marker()), []).extend(line.get_xdata())
        ends = [segment[:, 0] for whiskers in axes.collections for segment in whiskers.get_segments()]
        for name, interval in zip(names, ends, strict=True):
            (row,) = scores.filter(behaviour=name, measure=measure).to_dicts()
            assert (*found.pop((name, "o")), *interval) == pytest.approx((row["value"], row["ci_low"], row["ci_high"]))
            episodes = trials.filter(model=name)[columns[measure]].to_list() if measure in columns else []
            assert sorted(found.pop((name, "|"), [])) == sorted(episodes)
    for name in names:
        own = trials.filter(model=name).sort("repeat", descending=True)  # the first lies on top
        paths = [frames.filter(trial=trial).select("x_cm", "y_cm").to_numpy() for trial in own["trial"]]
        ended = [path[-1:] for path, touched in zip(paths, own["touched"], strict=True) if touched]
        for mark, expected in (("None", paths), ("o", [path[:1] for path in paths]), ("x", ended)):
            lines = [line for line in panels[name].lines if line.get_marker() == mark]
            np.testing.assert_array_equal([line.get_xydata() for line in lines], expected)
        assert panels[name].patches[0].get_radius() == ARENA_RADIUS_CM
    show(scores, "")
    told = capsys.readouterr().out
    for value, low, high in scores.select("value", "ci_low", "ci_high").drop_nulls().rows():
        assert str(Score(value, low, high, 0)) in told
