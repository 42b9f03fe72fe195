"""Areas under the ROC and shares of clustered trials, with intervals at small n; alarms; medians of times."""

import math

import numpy as np
import polars as pl
import pytest
from scipy import stats

from experiments.judge.judge import SIGNED
from experiments.judge.roc import alarm_count, area_under_roc, effective_number, median_interval, share
from experiments.judge.tests import proportion_interval


@pytest.mark.parametrize("n", [1, 3, 10])
def test_complete_separation_is_no_certainty(n):
    area, low, high = area_under_roc(range(n, 2 * n), range(n))
    assert (area, high) == (1.0, 1.0)
    assert 0.5 * n / (n + 2) < low < 1 - 1 / (n + 3)
    assert area_under_roc(range(n), range(n, 2 * n)) == pytest.approx((0.0, 0.0, 1 - low))


def test_the_area_s_interval_covers_at_small_n():
    rng = np.random.default_rng(0)
    true = stats.norm.cdf(2 / math.sqrt(2))
    areas = [area_under_roc(rng.normal(2, 1, 5), rng.normal(0, 1, 8)) for _ in range(300)]
    assert 0.92 < np.mean([low <= true <= high for _, low, high in areas]) < 0.995


def test_the_interval_of_clusters_covers_where_that_of_single_values_does_not():
    """Ten conditions of eight repeats each; the share of hits is a condition's own, 60 % on average."""
    rng, clusters = np.random.default_rng(0), np.repeat(np.arange(10), 8)
    covered = [0, 0]
    for _ in range(300):
        hits = rng.random(80) < rng.beta(0.9, 0.6, 10).repeat(8)
        number = effective_number(hits, clusters.tolist())
        assert 0 < number <= 80
        for place, of in enumerate((number, 80)):
            low, high = proportion_interval(hits.mean() * of, of)
            covered[place] += low <= 0.6 <= high
    assert covered[0] >= 0.92 * 300 and covered[1] < 0.85 * 300


def test_values_that_are_clusters_of_their_own_count_in_full():
    assert effective_number([0, 1, 1, 0, 1], list(range(5))) == 5
    assert effective_number([1, 1, 1, 1], ["a", "a", "b", "b"]) == 2, "nothing tells how alike they are"
    assert effective_number([0, 1, 1], ["a"] * 3) == 1


def test_clusters_that_differ_as_their_values_do_cost_degrees_of_freedom_alone():
    """Korn and Graubard: the design effect is 1 here; two clusters have one degree of freedom, four values three."""
    cost = (stats.t.ppf(0.975, 3) / stats.t.ppf(0.975, 1)) ** 2
    assert effective_number([0, 1, 1, 1], ["a", "a", "b", "b"]) == pytest.approx(4 * cost)


def test_repeats_of_a_condition_are_no_independent_trials():
    """Four clips, five repeats each: where repeats agree they tell no more than four clips do."""
    once = pl.DataFrame([{"condition": f"c{i}", "right": True} for i in range(len(SIGNED))])
    agree = share(pl.concat([once] * 5), "right")
    assert (agree.value, agree.low, agree.high, agree.n) == (1.0, share(once, "right").low, 1.0, 20)


def test_an_alarm_is_a_spike_after_half_a_second_of_silence():
    """At 30 frames/s: 15 frames apart are one alarm, 16 are two."""
    spikes = np.zeros(60, int)
    assert alarm_count(spikes, 30.0) == 0
    spikes[[10, 11, 12, 27]] = 1
    assert alarm_count(spikes, 30.0) == 1
    spikes[43] = 2
    assert alarm_count(spikes, 30.0) == 2 and alarm_count(np.ones(300, int), 30.0) == 1


def test_a_median_has_the_interval_of_order_statistics():
    assert median_interval(range(1, 41)) == (14.0, 27.0)  # binomial(40, 1/2): ranks 14 and 27
