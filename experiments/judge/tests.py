"""Summaries, intervals, tests and scores. P values are exact, or of a stated number of permutations.

No test uses a normal approximation: of five pairs, all one way, it says p = 0.04 where the signs can reach no less
than 2 in 32. P is the share of all arrangements of the values that lie as far from what chance gives as those seen,
so it is never below one arrangement in all there are. Where they are too many to count, `PERMUTATIONS` of them are
drawn, always the same ones, and those seen count as one more: p is never below 1 in ``PERMUTATIONS + 1``.
"""

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from experiments.base.streams import stream
from experiments.declare.outcome import is_number
from experiments.store.tables import finite, group

RESAMPLES, PERMUTATIONS = 10_000, 9_999
SEED = 0  # of bootstrap and permutations alone: summaries and tests of equal trials are equal
LEAST_FOR_INTERVAL = 3
"""Values that an interval takes: of two, Student's is 12.7 times their standard error wide to either side, and says
nothing."""
LEAST_FOR_BOOTSTRAP = 5
"""Values that a bootstrap takes: no resample's mean lies beyond them, and of four all lie on one side of the middle of
their distribution once in 8 times."""
EXACT_PAIRS, EXACT_VALUES, EXACT_STATES = 200, 60, 128
"""Largest cases in which p is exact and not drawn: some 0.1 s at most. 30 values against 30, or three groups of 10."""

Floats = npt.NDArray[np.float64]
Whole = npt.NDArray[np.int64]


PLACES = 4
"""Decimal places that are shown: a gain of 0.00001 is 0 to anybody who reads it."""


@dataclass(frozen=True, slots=True)
class Score:
    """A measured value and its 95 % interval; NaN where there is nothing to tell.

    Attributes
    ----------
    value, low, high
        The value, and the ends of its interval.
    n
        Number of trials, clips, episodes or timed rounds that it is from.
    """

    value: float
    low: float
    high: float
    n: int

    def __str__(self) -> str:
        if math.isnan(self.value) or math.isnan(self.low):
            return written(self.value)
        if math.isinf(self.value):
            return f"without a bound, at least {written(self.low)}"
        if math.isinf(self.high):
            return f"{written(self.value)} [{written(self.low)}, no upper bound]"
        return f"{written(self.value)} [{written(self.low)}, {written(self.high)}]"


LEVEL = 0.05
"""A p value is told where a test of so many values could reach this, or less; otherwise it could tell nothing."""


@dataclass(frozen=True, slots=True)
class Test:
    """A test of an order, or of pairs.

    Parameters
    ----------
    name, effect_name
        Names of the test and of its effect size.
    effect, p
        The effect size, and the two-sided p value; NaN of what is no number.
    least
        The least p value that the test could reach with so many values, and as many equal ones.
    """

    name: str
    effect_name: str
    effect: float
    p: float
    least: float = 0.0

    def __str__(self) -> str:
        """The effect size, p and the test's name."""
        return f"{self.effect_name} {self.effect:+.2f}, {p_text(self.p, self.least)} ({self.name})"


def p_text(p: float, least: float) -> str:
    """Return a p value in words: where so few values cannot carry one, the ``least`` that they could reach."""
    if least > LEVEL:
        return f"too few for p < {least:.2g}"
    return "p < 0.001" if p < 0.001 else f"p = {p:.3f}"


def summarise(values: Sequence[float], lowest: float = -math.inf, highest: float = math.inf) -> Score:
    """Return the mean of at least one value, with its interval: NaN of fewer than three.

    The interval is the bootstrap's, its percentiles widened for the sample's size as Student's t widens a normal
    interval: the plain ones of ten values cover the mean in 90 % of samples, not in 95 %. Of fewer than
    `LEAST_FOR_BOOTSTRAP` values it is Student's own, which is wide, and of fewer than `LEAST_FOR_INTERVAL` there is
    none. Equal values give a point: nothing in them tells how far from the mean it may be.

    Parameters
    ----------
    values
        One or more numbers.
    lowest, highest
        The least and the largest that a value can be, such as 0 of a count: no interval goes beyond them.

    References
    ----------
    Hesterberg 2015, What teachers should know about the bootstrap, The American Statistician 69: the expanded
    percentile interval.
    """
    sample = np.asarray(values, float)
    n, mean = sample.size, float(sample.mean())
    low = high = mean if n >= LEAST_FOR_INTERVAL else math.nan
    if n >= LEAST_FOR_INTERVAL and np.ptp(sample) > 0:
        from scipy import special  # not before: it takes its time to load, and declarations need this file

        if n < LEAST_FOR_BOOTSTRAP:
            half = float(special.stdtrit(n - 1, 0.975)) * float(sample.std(ddof=1)) / math.sqrt(n)
            low, high = mean - half, mean + half
        else:
            # As scipy.stats.bootstrap has it: that module takes longer to load than most runs take to be summed up.
            tail = float(special.ndtr(math.sqrt(n / (n - 1)) * special.stdtrit(n - 1, 0.025)))
            drawn = sample[stream("bootstrap.mean", SEED).integers(0, n, (RESAMPLES, n))].mean(axis=1)
            low, high = map(float, np.quantile(drawn, (tail, 1 - tail)))
    if not math.isnan(low):
        low, high = max(low, lowest), min(high, highest)
    return Score(mean, low, high, n)


def proportion_interval(count: float, of: float) -> tuple[float, float]:
    """The exact 95 % interval of the share ``count`` of ``of`` independent trials (Clopper and Pearson 1934).

    Trials that come in clusters may be given as fewer: their effective number, and the same share of it.
    """
    from scipy import special

    low = float(special.betaincinv(count, of - count + 1, 0.025)) if count > 0 else 0.0
    high = float(special.betaincinv(count + 1, of - count, 0.975)) if count < of else 1.0
    return low, high


def mcnemar(first_only: int, second_only: int) -> float:
    """Return the exact two-sided p of McNemar's test, of the pairs that differ, one or more.

    References
    ----------
    McNemar 1947, Note on the sampling error of the difference between correlated proportions, Psychometrika 12.
    """
    from scipy import stats

    return float(stats.binomtest(first_only, first_only + second_only).pvalue)


def poisson_interval(count: float) -> tuple[float, float]:
    """Return the exact 95 % interval of the expectation of a Poisson count.

    References
    ----------
    Garwood 1936, Fiducial limits for the Poisson distribution, Biometrika 28.
    """
    from scipy import special  # not before: it takes its time to load

    low = float(special.gammaincinv(count, 0.025)) if count else 0.0
    return low, float(special.gammaincinv(count + 1, 0.975))


def trend(groups: Sequence[tuple[float, Sequence[float]]]) -> Test:
    """Test whether the value rises (or falls) over the ordered groups, given as (level, values).

    Kendall's tau-b between level and value: the Jonckheere-Terpstra test for independent samples with ties,
    and its effect size, -1 (always falls) to +1. Without variation the effect is 0 and p is 1.
    """
    name = "Jonckheere-Terpstra"
    levels = [level for level, values in groups for _ in values]
    pooled = [value for _, values in groups for value in values]
    if np.isnan(pooled).any():
        return Test(name, "tau", math.nan, math.nan)
    if len(set(levels)) < 2 or len(set(pooled)) < 2:
        return Test(name, "tau", 0.0, 1.0, least=1.0)
    table = _counted(levels, pooled)
    how, p, least = _of_arrangements(table)
    pairs = [(len(pooled) ** 2 - int((counts**2).sum())) / 2 for counts in (table.sum(axis=1), table.sum(axis=0))]
    return Test(f"{name}, {how}", "tau", int(_rising(table)) / math.sqrt(math.prod(pairs)), p, least)


def contrast(first: Sequence[float], second: Sequence[float]) -> Test:
    """Test whether ``first`` is larger than ``second``: Mann-Whitney, Cliff's delta from -1 to +1; neither is empty."""
    if np.isnan([*first, *second]).any():
        return Test("Mann-Whitney", "delta", math.nan, math.nan)
    how, p, least = _of_arrangements(_counted([1.0] * len(first) + [0.0] * len(second), [*first, *second]))
    delta = float(np.sign(np.subtract.outer(np.asarray(first, float), np.asarray(second, float))).mean())
    return Test(f"Mann-Whitney, {how}", "delta", delta, p, least)


def paired(first: Sequence[float], second: Sequence[float]) -> Test:
    """Test whether ``first`` is larger than ``second``, pair by pair, by Wilcoxon's signed ranks.

    The effect is the rank-biserial correlation, from -1 (``second`` larger in every pair) to +1; equal pairs count for
    neither, differences of equal size share their ranks. Without a difference anywhere the effect is 0 and p is 1.
    """
    name, difference = "Wilcoxon signed-rank", np.subtract(first, second)
    if np.isnan(difference).any():
        return Test(name, "rank-biserial", math.nan, math.nan)
    difference = difference[difference != 0]
    if difference.size == 0:
        return Test(name, "rank-biserial", 0.0, 1.0, least=1.0)
    _, place, alike = np.unique(np.abs(difference), return_inverse=True, return_counts=True)
    doubled = (2 * np.cumsum(alike) - alike + 1)[place]  # shared ranks are halves
    seen, whole = int((doubled * np.sign(difference)).sum()), int(doubled.sum())
    if difference.size <= EXACT_PAIRS:
        how, p = "exact", _share_beyond(_signed_sums(doubled), abs(seen))
    else:
        how, p = _drawn(_drawn_sums(doubled), abs(seen))
    return Test(f"{name}, {how}", "rank-biserial", seen / whole, p, least_of_pairs(difference.size))


def least_of_pairs(n: int) -> float:
    """Return the least p that signed ranks of so many pairs can reach: all differ one way."""
    return 2.0 ** (1 - n)


def holm(p_values: Sequence[float]) -> list[float]:
    """P values corrected for their number by Holm's step-down method, in the order given."""
    order = np.argsort(p_values)
    scaled = np.asarray(p_values)[order] * np.arange(len(order), 0, -1)
    corrected = np.empty(len(order))
    corrected[order] = np.minimum(np.maximum.accumulate(scaled), 1.0)
    return [float(p) for p in corrected]


def _of_arrangements(table: Whole) -> tuple[str, float, float]:
    """Return how p was computed, p, and the least that it could be, which is 0 where arrangements are drawn.

    P is taken over all arrangements of the values over the levels, which the ``table`` of `_counted` has, with as many
    at each as there are. The statistic is the number of pairs at different levels in rising order less those in
    falling order.
    """
    sizes, ties = table.sum(axis=1), table.sum(axis=0)
    seen = abs(int(_rising(table)))
    if sizes.sum() <= EXACT_VALUES and np.prod(np.sort(sizes)[:-1] + 1) <= EXACT_STATES:
        chances = _rises(sizes.tolist(), ties.tolist())
        farthest = int(np.abs(np.flatnonzero(chances) - chances.size // 2).max())
        return "exact", _share_beyond(chances, seen), _share_beyond(chances, farthest)
    return *_drawn(_drawn_rises(sizes, ties), seen), 0.0


def _counted(levels: Sequence[float], values: Sequence[float]) -> Whole:
    """Count how often each value (columns) is there at each level (rows), both in rising order."""
    rows, columns = (np.unique(each, return_inverse=True)[1] for each in (levels, values))
    table = np.zeros((rows.max() + 1, columns.max() + 1), np.int64)
    np.add.at(table, (rows, columns), 1)
    return table


def _rising(tables: Whole) -> Whole:
    """Pairs in rising order less pairs in falling order of tables (..., levels, values) of counts."""
    below = np.cumsum(tables, axis=-1) - tables
    rises = np.zeros(tables.shape[:-2], dtype=np.int64)
    for high in range(tables.shape[-2]):
        for low in range(high):
            rises += (tables[..., high, :] * below[..., low, :] - tables[..., low, :] * below[..., high, :]).sum(-1)
    return rises


def _rises(sizes: Sequence[int], ties: Sequence[int]) -> Floats:
    """Chances of `_rising` from its least value to its greatest, of groups of ``sizes`` with ``ties`` of each value.

    Values are dealt out in rising order. A state is how many each group has by then, with the chances of the count
    so far.
    """
    most = sum(a * b for i, a in enumerate(sizes) for b in sizes[:i])
    start = np.zeros(2 * most + 1)
    start[most] = 1.0
    states = {(0,) * len(sizes): start}
    for count in ties:
        dealt: dict[tuple[int, ...], Floats] = {}
        for held, chances in states.items():
            room = [size - part for size, part in zip(sizes, held, strict=True)]
            whole = math.comb(sum(room), count)
            for taken in _splits(count, room):
                rise = sum(held[i] * taken[j] - taken[i] * held[j] for j in range(len(sizes)) for i in range(j))
                chance = math.prod(map(math.comb, room, taken)) / whole
                now = tuple(part + more for part, more in zip(held, taken, strict=True))
                # No rise goes beyond the ends: what rolls round is 0.
                dealt[now] = dealt.get(now, 0.0) + chance * np.roll(chances, rise)
        states = dealt
    (chances,) = states.values()
    return chances


def _splits(count: int, room: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Every way to deal ``count`` to groups with ``room`` for so many each."""
    if len(room) == 1:
        yield (count,)
        return
    for first in range(max(0, count - sum(room[1:])), min(count, room[0]) + 1):
        for others in _splits(count - first, room[1:]):
            yield (first, *others)


def _drawn_rises(sizes: Whole, ties: Whole) -> Whole:
    """`_rising` of `PERMUTATIONS` arrangements; some at a time, for memory's sake."""
    from scipy import stats

    rng, tables = stream("permutations.order", SEED), stats.random_table(sizes, ties)
    some = max(1, 2_000_000 // (sizes.size * ties.size))
    parts = [min(some, PERMUTATIONS - done) for done in range(0, PERMUTATIONS, some)]
    return np.concatenate([_rising(np.asarray(tables.rvs(part, random_state=rng), np.int64)) for part in parts])


def _signed_sums(doubled: Whole) -> Floats:
    """Chances of the sum of so many ranks with signs by chance, from its least value to its greatest."""
    whole = int(doubled.sum())
    chances = np.zeros(2 * whole + 1)
    chances[whole] = 1.0
    for rank in doubled.tolist():
        chances = (np.roll(chances, rank) + np.roll(chances, -rank)) / 2
    return chances


def _drawn_sums(doubled: Whole) -> Whole:
    """Sums of the ranks with `PERMUTATIONS` drawings of their signs."""
    rank, count = np.unique(doubled, return_counts=True)
    positive = stream("permutations.signs", SEED).binomial(count, 0.5, (PERMUTATIONS, rank.size))
    return np.asarray((rank * (2 * positive - count)).sum(axis=1))


def _share_beyond(chances: Floats, seen: int) -> float:
    """The chance of a value as far from 0, the middle of ``chances``, as ``seen`` or farther."""
    middle = chances.size // 2
    far = np.abs(np.arange(chances.size) - middle) >= seen
    return min(float(chances[far].sum()), 1.0)


def _drawn(rises: Whole, seen: int) -> tuple[str, float]:
    """Return how p was computed, and p: the share of values as far from 0 as ``seen`` or farther, ``seen`` included."""
    return f"{PERMUTATIONS} permutations", (int((np.abs(rises) >= seen).sum()) + 1) / (PERMUTATIONS + 1)


SUMMARY = {"n": int, **dict.fromkeys(("mean", "sd", "median", "ci_low", "ci_high"), float)}
"""Columns of numbers in ``summary.csv``."""


def summary_rows(
    rows: Iterable[Mapping[str, Any]], keys: Sequence[str], quantities: Iterable[str], signed: Collection[str]
) -> list[dict[str, Any]]:
    """Summarise quantities of trials in groups: n, mean, sd, median, 95 % interval of the mean.

    Parameters
    ----------
    rows
        Of ``trials.parquet``.
    keys
        Columns by whose values the rows are grouped.
    quantities
        Columns to summarise. A group in which one has no number has no row of it.
    signed
        Those that can be negative: of the others no interval goes below 0.

    Returns
    -------
    list of dict
        A row per group and quantity: ``keys``, ``quantity`` and `SUMMARY`; of one value no ``sd``.
    """
    table = []
    for values_of_keys, chosen in group(rows, *keys).items():
        for quantity in quantities:
            values = [row[quantity] for row in chosen if is_number(row.get(quantity))]
            if values:
                score = summarise(values, -math.inf if quantity in signed else 0.0)
                table.append({
                    **dict(zip(keys, values_of_keys, strict=True)), "quantity": quantity, "n": score.n,
                    "mean": score.value, "sd": float(np.std(values, ddof=1)) if score.n > 1 else None,
                    "median": float(np.median(values)), "ci_low": finite(score.low), "ci_high": finite(score.high),
                })  # fmt: skip
    return table


def written(value: float) -> str:
    """Return a number for people, to three digits and four decimal places; a dash for NaN."""
    if math.isnan(value):
        return "-"
    if abs(value) >= 1000.0:
        return f"{value:.0f}"
    # Rounded once: 0.64753 has four places of 0.6475, and three digits of that would be 0.647.
    places = min(2 - math.floor(math.log10(abs(value))), PLACES) if value and math.isfinite(value) else PLACES
    return f"{round(value, places):z.3g}"


def first_alarm_s(spikes: npt.NDArray[np.integer], contact_s: npt.NDArray[np.float64]) -> float | None:
    """Return the time to contact at the first spike of an approach.

    Parameters
    ----------
    spikes
        A detector's spikes by frame, (T,).
    contact_s
        Time to contact by frame, s, (T,); NaN before the approach begins. Spikes after contact do not count.

    Returns
    -------
    float or None
        Seconds; ``None`` where nothing spikes between the approach's begin and contact.
    """
    fired = np.flatnonzero((np.asarray(spikes) != 0) & (np.nan_to_num(contact_s, nan=-1.0) > 0.0))
    return float(contact_s[fired[0]]) if fired.size else None
