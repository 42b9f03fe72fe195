"""Bearings are right positive wherever a user reads one: in tables and on the axes of figures, as HS and the image."""

from tests.helpers.condition_figures import drawn


def test_a_figure_has_the_bearings_of_its_table():
    figure = drawn([("rightward", speed, 8.0) for speed in (2.0, 4.0)])
    _, traces = figure.axes
    bearings = [list(line.get_xdata()) for line in traces.get_lines() if len(line.get_xdata()) == 4]
    assert bearings == [[-20.0, -5.0, 5.0, 20.0]] * len(bearings) and bearings
    low, high = traces.get_xlim()
    assert low < -20 and high > 20, "the left is on the left, as in the image"
