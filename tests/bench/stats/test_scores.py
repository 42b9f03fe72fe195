"""Numbers for people."""

import math

import numpy as np
import pytest

from experiments.bench.stats.scores import written


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.64753, "0.648"), (0.0, "0"), (-1e-6, "0"), (0.00016, "0.0002"), (0.9996, "1"), (27.35, "27.4"), (441.5, "442"),
     (math.nan, "-"), (math.inf, "inf")],
)  # fmt: skip
def test_a_number_has_three_digits_and_four_places(value, text):
    assert written(value) == text


def test_a_number_is_rounded_once():
    """So no text is farther from its number than half of the last place that it may have."""
    values = np.random.default_rng(0).uniform(-3, 3, 2000)
    for value in np.sign(values) * 10.0 ** np.abs(values) / 100:
        last = max(10.0 ** (math.floor(math.log10(abs(value))) - 2), 1e-4)
        assert abs(float(written(value)) - value) <= last / 2 * (1 + 1e-9), value
