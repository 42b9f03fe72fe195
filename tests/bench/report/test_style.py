"""The style of figures: shades of a quantity, and axes."""

import numpy as np
import polars as pl
import pytest
from matplotlib.figure import Figure

from experiments.bench.report import style
from experiments.bench.report.palette import WHITE
from tests.bench.report.test_palette import contrast

RENDERED = True


@pytest.mark.parametrize("count", [1, 2, 5, 9])
def test_shades_rise_with_the_level(count):
    tints = style.shades(np.random.default_rng(0).permutation(count))
    darkness = [contrast(tints[level], WHITE) for level in range(count)]
    assert darkness == sorted(darkness, reverse=True) and len(set(darkness)) == count


@pytest.mark.parametrize(("values", "scale"), [([0.0, 1.0, 99.0], "linear"), ([0.0, 1.0, 101.0], "symlog")])
def test_an_axis_is_logarithmic_where_its_values_span_more_than_two_decades_and_shows_all(values, scale):
    axes = Figure().subplots()
    axes.plot(values, range(3))
    style.decades(axes, pl.Series(values))
    low, high = axes.get_xlim()
    assert axes.get_xscale() == scale and low <= 0.0 and high > max(values)
