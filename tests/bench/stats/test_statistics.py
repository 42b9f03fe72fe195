"""The statistics against textbook values and against what they must never do."""

import numpy as np
import pytest
from scipy.stats import rankdata

from experiments.bench.stats.tests import contrast, holm, paired, summarise, trend


def test_summary_of_known_numbers():
    summary = summarise([2, 4, 4, 4, 5, 5, 7, 9])
    assert (summary.n, summary.mean, summary.median) == (8, 5.0, 4.5)
    assert summary.sd == pytest.approx(np.sqrt(32 / 7))
    assert summary.ci_low < 5 < summary.ci_high


def test_bootstrap_interval_covers_the_mean_as_often_as_it_says():
    """A 95 % percentile interval of 20 normal values covers a little less than 95 %; far from 80, far from 100."""
    rng = np.random.default_rng(0)
    samples = (rng.normal(3.0, 2.0, 20) for _ in range(200))
    covered = np.mean([s.ci_low < 3.0 < s.ci_high for s in map(summarise, samples)])
    assert 0.87 < covered < 0.99


def test_equal_values_have_a_point_for_an_interval():
    summary = summarise([3, 3, 3])
    assert summary.ci_low == summary.mean == summary.ci_high == 3
    assert summary.sd == 0


def test_one_value_tells_nothing_of_spread():
    summary = summarise([5.0])
    assert (summary.n, summary.mean, summary.median) == (1, 5.0, 5.0)
    assert np.isnan([summary.sd, summary.ci_low, summary.ci_high]).all()


@pytest.mark.parametrize("values", [[0, 117], [5.0, 5.0]])
def test_two_values_have_no_interval(values):
    """Student's interval of 0 and 117 spikes would go from -685 to 802."""
    summary = summarise(values)
    assert np.isnan([summary.ci_low, summary.ci_high]).all() and not np.isnan(summary.sd)


@pytest.mark.parametrize("values", [[0, 0, 9], [0, 1, 9, 0], [0, 0, 0, 0, 0, 1]])
def test_an_interval_of_counts_does_not_go_below_none(values):
    bounded, free = summarise(values, lowest=0.0), summarise(values)
    assert bounded.ci_low >= 0.0 and bounded.ci_high == free.ci_high
    assert free.ci_low < 0.0 or bounded == free
    mirrored = summarise([-value for value in values], highest=0.0)
    assert mirrored.ci_high <= 0.0


def in_order(levels, values):
    """The Jonckheere-Terpstra statistic: pairs of different groups in rising order less those in falling order."""
    rise = np.sign(np.subtract.outer(values, values))
    return np.sum(rise * np.sign(np.subtract.outer(levels, levels))) / 2


def test_trend_is_the_jonckheere_terpstra_test():
    """Its effect is the statistic over its greatest possible value; its p that of shuffled levels."""
    groups = [(1, [1, 2, 3]), (2, [2, 4, 5]), (3, [5, 6, 9])]
    levels, values = np.repeat([1, 2, 3], 3), np.concatenate([v for _, v in groups])
    pairs = 9 * 8 / 2
    tied = [sum(c * (c - 1) / 2 for c in np.unique(x, return_counts=True)[1]) for x in (levels, values)]
    test = trend(groups)
    wins = in_order(levels, values)
    assert test.effect == pytest.approx(wins / np.sqrt((pairs - tied[0]) * (pairs - tied[1])))
    assert trend([(-level, values) for level, values in groups]).effect == pytest.approx(-test.effect)


def test_the_trend_s_p_is_that_of_shuffled_levels():
    rng = np.random.default_rng(0)
    levels = np.repeat([1, 2, 3], 8)
    values = rng.integers(0, 12, 24) + levels
    seen = in_order(levels, values)
    shuffled = [abs(in_order(rng.permutation(levels), values)) >= abs(seen) for _ in range(4000)]
    test = trend([(level, values[levels == level]) for level in (1, 2, 3)])
    assert 0.005 < np.mean(shuffled) < 0.5
    assert test.p == pytest.approx(np.mean(shuffled), abs=0.03)


def test_trend_without_variation_claims_nothing():
    assert trend([(1, [4, 4]), (2, [4, 4])]).p == 1.0
    assert trend([(1, [4, 5])]).effect == 0.0


def test_contrast_is_cliff_s_delta():
    assert contrast([4, 5, 6], [1, 2, 3]).effect == pytest.approx(1.0)
    assert contrast([1, 2, 3], [4, 5, 6]).effect == pytest.approx(-1.0)
    assert contrast([1, 4], [2, 3]).effect == pytest.approx(0.0)


def test_paired_test_counts_signs_and_sizes():
    assert paired([5, 6, 7, 9], [1, 2, 3, 4]).effect == pytest.approx(1.0)
    assert paired([1, 2], [1, 2]) == paired([4], [4])
    assert paired([1, 2], [1, 2]).p == 1.0
    # ranks of |difference| 1, 2, 3, 4: (1 + 2 + 4 - 3) / 10
    assert paired([1, 2, 0, 4], [0, 0, 3, 0]).effect == pytest.approx(0.4)


def test_paired_p_is_near_that_of_flipped_signs():
    rng = np.random.default_rng(1)
    difference = rng.integers(-3, 8, 12)
    ranks = rankdata(np.abs(difference[difference != 0]))
    signs = np.sign(difference[difference != 0])
    flipped = rng.choice([-1, 1], (20000, len(ranks))) @ ranks
    assert paired(difference, np.zeros(12)).p == pytest.approx(np.mean(np.abs(flipped) >= abs(signs @ ranks)), abs=0.03)


def test_holm_by_hand():
    """Smallest times 4, next times 3, ...; never falling; at most 1."""
    assert holm([0.01, 0.04, 0.03, 0.5]) == pytest.approx([0.04, 0.09, 0.09, 0.5])
    assert holm([0.6, 0.7]) == pytest.approx([1.0, 1.0])
