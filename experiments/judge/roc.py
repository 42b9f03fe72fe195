"""Scores over the responses of models: shares, areas under ROC curves, alarms a minute, with 95 % intervals.

Repeats of one condition are a cluster: an interval is that of the effective number of independent values.
"""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import polars as pl

from experiments.judge.tests import Score, poisson_interval, proportion_interval

APART_S = 0.5
"""Silence that ends an alarm, s: a detector spikes several times in a row, and an animal begins one escape. A reflex of
this bench turns away for 0.4 s.
"""


def effective_number(values: Sequence[float], clusters: Sequence[object]) -> float:
    """Return how many independent values tell as much of a mean as these do, which come in clusters.

    It is the number of values over the design effect, the variance of the mean by clusters over that of independent
    values, and brought to the clusters' degrees of freedom. Where all values are equal nothing tells how alike those
    of a cluster are: then each cluster counts as one.

    Parameters
    ----------
    values
        One or more numbers.
    clusters
        The cluster that each is of: repeats of one condition are one cluster.

    Returns
    -------
    float
        From above 0 to the number of values; of values that are each a cluster of their own it is their number.

    References
    ----------
    Korn and Graubard 1998, Confidence intervals for proportions with small expected number of positive counts
    estimated from survey data, Survey Methodology 24.
    """
    sample, n = np.asarray(values, float), len(values)
    names = {cluster: place for place, cluster in enumerate(dict.fromkeys(clusters))}
    count = len(names)
    if count in (1, n):
        return float(count)
    away = sample - sample.mean()
    independent = float((away**2).sum()) * n / (n - 1)
    if independent <= 0.0:
        return float(count)
    sums = np.bincount([names[cluster] for cluster in clusters], weights=away, minlength=count)
    clustered = float((sums**2).sum()) * count / (count - 1)
    if clustered <= 0.0:
        return float(n)
    from scipy import special

    freedom = (special.stdtrit(n - 1, 0.975) / special.stdtrit(count - 1, 0.975)) ** 2
    return float(min(n * independent / clustered * freedom, n))


def median_interval(values: Sequence[float]) -> tuple[float, float]:
    """The 95 % interval of a median by order statistics, which assumes no shape; NaN where the values are too few."""
    from scipy import stats

    interval = stats.quantile_test(np.asarray(values, float), q=0, p=0.5).confidence_interval(0.95)
    return float(interval.low), float(interval.high)


def area_under_roc(
    positives: Sequence[float],
    negatives: Sequence[float],
    clusters: tuple[Sequence[object], Sequence[object]] | None = None,
) -> tuple[float, float, float]:
    """Return the area under the ROC curve of a score for ``positives`` and ``negatives``, and its 95 % interval.

    The area is the chance that a positive scores above a negative, a tie counting half: 1 perfect, 0.5 none, 0
    reversed. The interval has the areas from which the one seen is no more than 1.96 of their own standard errors
    away. So complete separation leaves an interval too, the wider the fewer trials there are: from 0.50 up of 3 and 3.
    Of values in ``clusters``, a name for each positive and each negative, the interval is that of their
    `effective_number`, by the share of the other side that each of them is above or below.

    References
    ----------
    Obuchowski 1997, Nonparametric analysis of clustered ROC curve data, Biometrics 53.

    Newcombe 2006, Confidence intervals for an effect size measure based on the Mann-Whitney statistic, part 2,
    Statistics in Medicine 25: method 5.
    """
    from scipy import optimize, special

    m, n = float(len(positives)), float(len(negatives))
    above = np.sign(np.subtract.outer(np.asarray(positives, float), np.asarray(negatives, float))) / 2 + 0.5
    area, z = float(above.mean()), float(special.ndtri(0.975))
    if math.isnan(area):
        return area, area, area
    if clusters:
        m, n = effective_number(above.mean(axis=1), clusters[0]), effective_number(above.mean(axis=0), clusters[1])
    size = max((m + n) / 2 - 1, 0.0)

    def beyond(true: float) -> float:
        """Return the squared distance of the area seen from a ``true`` one, less the largest allowed."""
        variance = true * (1 - true) * (1 + size * ((1 - true) / (2 - true) + true / (1 + true))) / (m * n)
        return (area - true) ** 2 - z * z * variance

    # At 0 and 1 themselves nothing varies: the ends looked for lie inside.
    inside = min(max(area, 1e-12), 1 - 1e-12)
    low = 0.0 if area <= 0 else float(optimize.brentq(beyond, 0.0, inside))
    high = 1.0 if area >= 1 else float(optimize.brentq(beyond, inside, 1.0))
    return area, low, high


def alarm_count(spikes: npt.NDArray[np.integer], fps: float) -> int:
    """Return the number of alarms in a clip: spikes with none in the `APART_S` before them.

    Parameters
    ----------
    spikes
        A detector's spikes by frame, (T,).
    fps
        Frames per second.
    """
    fired = np.flatnonzero(spikes)
    return int(fired.size and 1 + (np.diff(fired) > APART_S * fps).sum())


def share(table: pl.DataFrame, column: str) -> Score | None:
    """Return the share of rows that are true in a column, with Clopper and Pearson's interval; ``None`` of no rows.

    The repeats of a condition are a cluster: the interval is that of their effective number.
    """
    table = table.drop_nulls(column)
    if table.is_empty():
        return None
    hits = table[column].to_list()
    number, value = effective_number(hits, table["condition"].to_list()), sum(hits) / len(hits)
    return Score(value, *proportion_interval(value * number, number), len(hits))


def area(table: pl.DataFrame, column: str, positives: Sequence[str], negatives: Sequence[str]) -> Score | None:
    """Return the area under the ROC curve, by a column, for what showed ``positives`` against ``negatives``.

    Its interval is Newcombe's, with the repeats of a condition as a cluster; ``None`` where either were not shown.
    """
    sides = [table.filter(pl.col("shown").is_in(kinds)) for kinds in (positives, negatives)]
    if any(side.is_empty() for side in sides):
        return None
    above, below = (side[column].to_list() for side in sides)
    clusters = (sides[0]["condition"].to_list(), sides[1]["condition"].to_list())
    return Score(*area_under_roc(above, below, clusters), len(above) + len(below))


def alarm_rate(table: pl.DataFrame) -> Score | None:
    """Return the alarms a minute of all rows, with the exact interval of a Poisson rate; ``None`` of no rows.

    The repeats of a condition are a cluster: alarms and minutes are scaled to their effective number.
    """
    table = table.drop_nulls("alarms")
    if table.is_empty():
        return None
    minutes, alarms = float(table["seconds"].sum()) / 60.0, int(table["alarms"].sum())
    rates = (table["alarms"] / table["seconds"]).to_list()
    scale = effective_number(rates, table["condition"].to_list()) / table.height
    low, high = (end / (minutes * scale) for end in poisson_interval(alarms * scale))
    return Score(alarms / minutes, low, high, table.height)
