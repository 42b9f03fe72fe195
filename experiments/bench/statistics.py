"""Pure statistics of trials: intervals, a trend test, a two-sample test. By SciPy throughout."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from experiments.bench.streams import stream

RESAMPLES = 2000
SEED = 0  # of the bootstraps alone: summaries of equal trials are equal


@dataclass(frozen=True, slots=True)
class Summary:
    """Sample size, location, spread and the 95 % bootstrap interval of the mean; of one value, no spread: NaN."""

    n: int
    mean: float
    sd: float
    median: float
    ci_low: float
    ci_high: float


@dataclass(frozen=True, slots=True)
class Test:
    """A test's name, its effect size with the effect's name, and the two-sided p value."""

    name: str
    effect_name: str
    effect: float
    p: float

    def __str__(self) -> str:
        p = "p < 0.0001" if self.p < 1e-4 else f"p = {self.p:.4f}"
        return f"{self.effect_name} {self.effect:+.2f}, {p} ({self.name})"


def summarise(values: Sequence[float]) -> Summary:
    """Summary of at least one value. The interval is the percentile bootstrap's; equal values give a point."""
    sample = np.asarray(values, float)
    mean = float(sample.mean())
    if sample.size == 1:
        return Summary(1, mean, math.nan, mean, math.nan, math.nan)
    low = high = mean
    if np.ptp(sample) > 0:
        interval = stats.bootstrap(
            (sample,), np.mean, n_resamples=RESAMPLES, method="percentile", rng=stream("bootstrap.mean", SEED)
        ).confidence_interval
        low, high = float(interval.low), float(interval.high)
    return Summary(sample.size, mean, float(sample.std(ddof=1)), float(np.median(sample)), low, high)


def proportion_interval(count: int, of: int) -> tuple[float, float]:
    """Wilson's 95 % interval of the share ``count`` of ``of`` independent trials."""
    interval = stats.binomtest(count, of).proportion_ci(method="wilson")
    return float(interval.low), float(interval.high)


def median_interval(values: Sequence[float]) -> tuple[float, float]:
    """The 95 % interval of a median by order statistics, which assumes no shape; NaN where the values are too few."""
    interval = stats.quantile_test(np.asarray(values, float), q=0, p=0.5).confidence_interval(0.95)
    return float(interval.low), float(interval.high)


def area_under_roc(positives: Sequence[float], negatives: Sequence[float]) -> tuple[float, float, float]:
    """How well a score tells ``positives`` from ``negatives``: area under the ROC curve and its 95 % interval.

    The area is the chance that a positive scores above a negative, a tie counting half: 1 perfect, 0.5 none, 0
    reversed. The interval is the percentile bootstrap's, each class resampled; complete separation gives a point.
    """
    above = np.sign(np.subtract.outer(np.asarray(positives, float), np.asarray(negatives, float))) / 2 + 0.5
    rng = stream("bootstrap.area", SEED)
    # How often each trial is drawn: its weight in the resample.
    drawn = [rng.multinomial(n, np.full(n, 1 / n), RESAMPLES) / n for n in above.shape]
    areas = np.einsum("rp,pn,rn->r", drawn[0], above, drawn[1], optimize=True)
    low, high = np.quantile(areas, (0.025, 0.975))
    return float(above.mean()), float(low), float(high)


def trend(groups: Sequence[tuple[float, Sequence[float]]]) -> Test:
    """Does the value rise (or fall) over the ordered groups, given as (level, values)?

    Kendall's tau-b between level and value: the Jonckheere-Terpstra test for independent samples with ties,
    and its effect size, -1 (always falls) to +1. Without variation the effect is 0 and p is 1.
    """
    levels = [level for level, values in groups for _ in values]
    pooled = [value for _, values in groups for value in values]
    if len(set(levels)) < 2 or len(set(pooled)) < 2:
        return Test("Jonckheere-Terpstra", "tau", 0.0, 1.0)
    result = stats.kendalltau(levels, pooled)
    return Test("Jonckheere-Terpstra", "tau", float(result.statistic), float(result.pvalue))


def contrast(first: Sequence[float], second: Sequence[float]) -> Test:
    """Is ``first`` larger than ``second``? Mann-Whitney U with Cliff's delta, -1 to +1."""
    result = stats.mannwhitneyu(first, second)
    delta = 2 * float(result.statistic) / (len(first) * len(second)) - 1
    return Test("Mann-Whitney", "delta", delta, float(result.pvalue))


def paired(first: Sequence[float], second: Sequence[float]) -> Test:
    """Is ``first`` larger than ``second``, pair by pair? Wilcoxon's signed ranks with the rank-biserial correlation.

    P is by the normal approximation, corrected for ties. The effect runs from -1 (``second`` larger in every pair)
    to +1; equal pairs count for neither. Without a difference anywhere the effect is 0 and p is 1.
    """
    difference = np.subtract(first, second)
    difference = difference[difference != 0]
    if difference.size == 0:
        return Test("Wilcoxon signed-rank", "rank-biserial", 0.0, 1.0)
    ranks = stats.rankdata(np.abs(difference))
    effect = float((ranks * np.sign(difference)).sum() / ranks.sum())
    # Spike counts tie, and with ties SciPy would draw permutations, half a second for each test.
    result = stats.wilcoxon(difference, method="asymptotic")
    return Test("Wilcoxon signed-rank", "rank-biserial", effect, float(result.pvalue))


def holm(p_values: Sequence[float]) -> list[float]:
    """P values corrected for their number by Holm's step-down method, in the order given."""
    order = np.argsort(p_values)
    scaled = np.asarray(p_values)[order] * np.arange(len(order), 0, -1)
    corrected = np.empty(len(order))
    corrected[order] = np.minimum(np.maximum.accumulate(scaled), 1.0)
    return [float(p) for p in corrected]
