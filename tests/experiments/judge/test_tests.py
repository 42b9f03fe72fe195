"""P values at small n: against every arrangement counted by hand, against published tables; intervals at small n."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as some
from scipy import stats

from dsnn.stimuli import stimulus
from experiments.judge.tests import (
    LEVEL,
    PERMUTATIONS,
    contrast,
    first_alarm_s,
    holm,
    paired,
    proportion_interval,
    summarise,
    summary_rows,
    trend,
    written,
)
from experiments.kinds.trials import NEGATIVE, QUANTITIES

few = some.integers(-3, 3)
QUICK = settings(max_examples=40, deadline=None)


def rises(levels, values):
    """Pairs at different levels in rising order less those in falling order."""
    pairs = itertools.combinations(zip(levels, values, strict=True), 2)
    return sum(int(np.sign(a[0] - b[0]) * np.sign(a[1] - b[1])) for a, b in pairs)


def by_hand(levels, values):
    """The share of all arrangements with as many pairs in order, either way, as these."""
    seen = abs(rises(levels, values))
    extreme = [abs(rises(levels, shuffled)) >= seen for shuffled in itertools.permutations(values)]
    return np.mean(extreme)


@QUICK
@given(some.lists(few, min_size=1, max_size=9))
def test_the_paired_p_counts_every_choice_of_signs(difference):
    kept = [value for value in difference if value]
    ranks = stats.rankdata(np.abs(kept)) if kept else []
    seen = abs(sum(np.sign(kept) * ranks))
    sums = [abs(sum(np.multiply(signs, ranks))) for signs in itertools.product((-1, 1), repeat=len(kept))]
    test = paired(difference, [0] * len(difference))
    assert test.p == pytest.approx(np.mean(np.array(sums) >= seen - 1e-9))
    assert "Wilcoxon signed-rank" in test.name


@QUICK
@given(some.lists(few, min_size=1, max_size=3), some.lists(few, min_size=1, max_size=4))
def test_the_contrast_s_p_counts_every_arrangement(first, second):
    levels = [1] * len(first) + [0] * len(second)
    assert contrast(first, second).p == pytest.approx(by_hand(levels, first + second))


@QUICK
@given(some.lists(some.tuples(some.sampled_from([0, 15, 30]), few), min_size=2, max_size=7))
def test_the_trend_s_p_counts_every_arrangement(pairs):
    levels, values = zip(*pairs, strict=True)
    groups = [(level, [v for pair_level, v in pairs if pair_level == level]) for level in sorted(set(levels))]
    assert trend(groups).p == pytest.approx(by_hand(levels, values))


@QUICK
@given(some.lists(few, min_size=1, max_size=2), some.lists(few, min_size=1, max_size=3))
def test_the_least_p_is_that_of_the_farthest_arrangement(first, second):
    """So that no p is told where n can carry none: of 3 against 3 values the least is 2 in 20."""
    levels, values = [1] * len(first) + [0] * len(second), first + second
    test = contrast(first, second)
    assert test.least == pytest.approx(min(by_hand(levels, order) for order in itertools.permutations(values)))
    assert ("p =" in str(test)) == (test.least <= LEVEL) and ("too few" in str(test)) == (test.least > LEVEL)


@pytest.mark.parametrize("n", range(1, 9))
def test_pairs_that_can_carry_no_p_have_none(n):
    test = paired(range(2, n + 2), [1] * n)
    assert test.least == test.p == 2.0 ** (1 - n)
    assert ("p = " in str(test)) == (n >= 6)
    assert "too few for p < 1" in str(paired([1] * 20, [1] * 20)), "no pair differs"


def test_many_values_are_shuffled_as_often_as_the_name_says():
    """Close to the exact p, the same every time, and never 0."""
    rng = np.random.default_rng(3)
    groups = [(level, (rng.integers(0, 30, 20) + 3 * level).tolist()) for level in range(3)]
    test = trend(groups)
    assert str(PERMUTATIONS) in test.name and test == trend(groups)
    tau = stats.kendalltau(
        [level for level, values in groups for _ in values], [v for _, values in groups for v in values]
    )
    assert test.effect == pytest.approx(tau.statistic) and test.p == pytest.approx(tau.pvalue, abs=0.01)
    first, second = rng.normal(0.4, 1, 60), rng.normal(0, 1, 50)
    normal = stats.mannwhitneyu(first, second, method="asymptotic").pvalue
    assert contrast(first, second).p == pytest.approx(normal, abs=0.01)
    difference = rng.normal(0.1, 1, 300)
    near = stats.wilcoxon(difference, method="asymptotic").pvalue
    assert paired(difference, np.zeros(300)).p == pytest.approx(near, abs=0.01)
    for certain in (
        contrast([1.0] * 60, [0.0] * 60),
        trend([(i, [i] * 40) for i in range(3)]),
        paired([1] * 300, [0] * 300),
    ):
        assert certain.p == 1 / (PERMUTATIONS + 1) and certain.effect == pytest.approx(1.0)


def test_drawings_as_extreme_as_what_was_seen_count():
    """Of 300 differences of one size the rank sum is a binomial's: what equals 165 to 135 is a fifth of its p."""
    exact = stats.binomtest(165, 300).pvalue
    assert paired([1] * 165 + [-1] * 135, [0] * 300).p == pytest.approx(exact, abs=0.01)


def test_what_is_no_number_has_no_p():
    for test in (contrast([1.0, math.nan], [2.0]), trend([(1, [math.nan]), (2, [3.0])]), paired([math.nan], [1.0])):
        assert math.isnan(test.p) and math.isnan(test.effect)


# Intervals.


@pytest.mark.parametrize("n", [3, 4, 5, 10])
def test_an_interval_of_few_values_covers_the_mean_as_often_as_it_says(n):
    """Plain percentiles, which cannot leave the sample's range, cover it in 75 % of samples of three."""
    rng = np.random.default_rng(0)
    summaries = [summarise(rng.normal(3.0, 2.0, n)) for _ in range(300)]
    assert 0.9 < np.mean([s.low <= 3.0 <= s.high for s in summaries]) < 0.99


@pytest.mark.parametrize("n", [3, 6, 12])
def test_equal_values_give_a_point(n):
    """To the bit: the mean of three times 0.1 is none of them, so that their deviation is not 0."""
    summary = summarise([0.1] * n)
    assert summary.low == summary.value == summary.high


@pytest.mark.parametrize(
    ("count", "of", "low", "high"),
    [(0, 10, 0.0, 0.3085), (1, 10, 0.0025, 0.4450), (5, 10, 0.1871, 0.8129), (10, 10, 0.6915, 1.0),
     (0, 3, 0.0, 0.7076)],
)  # fmt: skip
def test_shares_have_clopper_and_pearson_s_intervals(count, of, low, high):
    assert proportion_interval(count, of) == pytest.approx((low, high), abs=5e-5)


# Effects, and summaries of known numbers.


@pytest.mark.parametrize("values", [[0, 0, 9], [0, 1, 9, 0], [0, 0, 0, 0, 0, 1]])
def test_an_interval_of_counts_does_not_go_below_none(values):
    assert {*NEGATIVE} == {name for name in QUANTITIES if name.startswith(("peak", "trough", "mean_hs", "drift"))}
    bounded, free = summarise(values, lowest=0.0), summarise(values)
    assert bounded.low >= 0.0 and bounded.high == free.high
    assert free.low < 0.0 or bounded == free
    mirrored = summarise([-value for value in values], highest=0.0)
    assert mirrored.high <= 0.0


@pytest.mark.parametrize(
    ("values", "mean", "median", "sd"),
    [([2, 4, 4, 4, 5, 5, 7, 9], 5.0, 4.5, (32 / 7) ** 0.5), ([1, 2, 3], 2.0, 2.0, 1.0), ([0, 117], 58.5, 58.5, 82.73),
     ([5.0], 5.0, 5.0, None)],
)  # fmt: skip
def test_a_summary_of_known_numbers(values, mean, median, sd):
    """Two values have no interval: Student's of 0 and 117 spikes would go from -685 to 802."""
    (row,) = summary_rows([{"spikes": value} for value in values], (), ["spikes"], ())
    assert (row["n"], row["mean"], row["median"]) == (len(values), mean, median)
    assert row["sd"] == (sd and pytest.approx(sd, abs=0.01))
    assert (row["ci_low"] is None) == (len(values) < 3)
    if len(values) == 3:  # t of 2 degrees of freedom is 4.303 at 97.5 %; what can be negative is not cut at 0
        half, (signed,) = 4.303 / 3**0.5, summary_rows([{"spikes": v} for v in values], (), ["spikes"], ["spikes"])
        assert (row["ci_low"], row["ci_high"]) == pytest.approx((0.0, mean + half), abs=1e-3)
        assert (signed["ci_low"], signed["ci_high"]) == pytest.approx((mean - half, mean + half), abs=1e-3)


@pytest.mark.parametrize(
    ("test", "effect"),
    [(contrast([4, 5, 6], [1, 2, 3]), 1.0), (contrast([1, 2, 3], [4, 5, 6]), -1.0), (contrast([1, 4], [2, 3]), 0.0),
     (paired([5, 6, 7, 9], [1, 2, 3, 4]), 1.0), (paired([1, 2, 0, 4], [0, 0, 3, 0]), (1 + 2 + 4 - 3) / 10),
     (paired([1, 2], [1, 2]), 0.0), (trend([(1, [4, 4]), (2, [4, 4])]), 0.0), (trend([(1, [4, 5])]), 0.0)],
)  # fmt: skip
def test_effects_of_known_numbers(test, effect):
    assert test.effect == pytest.approx(effect) and (test.p == pytest.approx(1.0) or effect)


def test_holm_by_hand():
    """Smallest times 4, next times 3, ...; never falling; at most 1."""
    assert holm([0.01, 0.04, 0.03, 0.5]) == pytest.approx([0.04, 0.09, 0.09, 0.5])
    assert holm([0.6, 0.7]) == pytest.approx([1.0, 1.0])


def test_a_number_is_rounded_once():
    """So no text is farther from its number than half of the last place that it may have."""
    values = np.random.default_rng(0).uniform(-3, 3, 2000)
    for value in np.sign(values) * 10.0 ** np.abs(values) / 100:
        last = max(10.0 ** (math.floor(math.log10(abs(value))) - 2), 1e-4)
        assert abs(float(written(value)) - value) <= last / 2 * (1 + 1e-9), value


# Alarms.


def test_the_first_alarm_is_the_first_spike_of_an_approach():
    contact = np.array([math.nan, 0.3, 0.2, 0.1, 0.0, -0.1])
    assert first_alarm_s(np.array([1, 0, 1, 1, 0, 0]), contact) == 0.2, "before the approach it is none"
    assert first_alarm_s(np.array([0, 0, 0, 0, 1, 1]), contact) is None, "after contact it is too late"


def test_a_detector_of_an_angle_fires_when_the_square_spans_it(l_over_v=0.16):
    """What fires at a full angle of 40 degrees does so at (l / v) / tan(20 deg) before contact."""
    clip = stimulus("looming", l_over_v_s=l_over_v, fps=300)
    sizes = np.array([0.0 if f.truth.box is None else f.truth.box.width for f in clip])
    fired = (2 * np.degrees(np.arctan(sizes / 2 / 70.7)) >= 40.0).astype(int)
    assert first_alarm_s(fired, clip.contact_s()) == pytest.approx(l_over_v / math.tan(math.radians(20.0)), abs=1 / 300)
