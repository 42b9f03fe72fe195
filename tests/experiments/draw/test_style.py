"""The style of figures: means and intervals of the data, and scales that show all."""

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
