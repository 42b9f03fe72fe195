"""The style of figures: colours apart in grey, means and intervals of the data, labels clear of each other, bytes."""

import numpy as np
import polars as pl
import pytest
from matplotlib.figure import Figure

from experiments.base import palette
from experiments.draw import style
from experiments.judge.tests import summarise

RENDERED = True


def test_means_intervals_and_trials_are_those_of_the_values():
    samples = [[3.0], [1.0, 2.0], [4.0, 5.0, 9.0]]
    axes = Figure().subplots()
    style.means(axes, [1.0, 2.0, 3.0], samples, palette.INK, "dsnn")
    (line,) = (line for line in axes.lines if line.get_label() == "dsnn")
    assert list(line.get_ydata()) == [3.0, 1.5, 6.0]
    dots = [list(line.get_ydata()) for line in axes.lines if line.get_markerfacecolor() == "none"]
    assert dots == samples
    (whisker,) = (line.get_xydata() for line in axes.lines if line.get_marker() == "None")
    expected = summarise(samples[2])
    assert tuple(whisker[:, 1]) == pytest.approx((expected.low, expected.high)), "and none of fewer than three"


@pytest.mark.parametrize(("values", "scale"), [([0.0, 1.0, 99.0], "linear"), ([0.0, 1.0, 101.0], "symlog")])
def test_an_axis_is_logarithmic_where_its_values_span_more_than_two_decades_and_shows_all(values, scale):
    axes = Figure().subplots()
    axes.plot(values, range(3))
    style.decades(axes, pl.Series(values))
    low, high = axes.get_xlim()
    assert axes.get_xscale() == scale and low <= 0.0 and high > max(values)


def test_labels_of_lines_that_end_together_do_not_collide(tmp_path):
    figure = Figure(figsize=(4.0, 3.0), layout="constrained")
    axes = figure.subplots()
    axes.set(xlim=(0, 1), ylim=(0, 1))
    style.label_ends(axes, [(1.0, y, str(y), palette.INK) for y in (0.5, 0.51, 0.1, 0.52)])
    style.save(figure, tmp_path / "labels")
    placed = sorted(axes.texts, key=lambda text: text.get_window_extent().y0)
    assert [text.get_text() for text in placed] == ["0.1", "0.5", "0.51", "0.52"], "in the order of the lines"
    heights = [text.get_window_extent().y0 * 72.0 / figure.dpi for text in placed]
    assert min(np.diff(heights)) > style.SMALL
