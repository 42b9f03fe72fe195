"""Number of episodes that a comparison of two behaviours' collisions takes: power, from the rates of a pilot. Pure.

Judged is `experiments.bench.closed_loop.scores.rate_ratio`: two counts of collisions, each over the metres driven, and
the exact interval of their ratio given the sum of the counts. The pilot is of other seeds than those that are judged.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import special

from experiments.bench.run.errors import UsageError

TARGET = 0.8
"""The usual least chance of showing an effect that is there."""
TAIL = 0.025
"""Beyond either end of a 95 % interval."""
MOST_EPISODES = 2_000
"""Up to which a number of episodes is looked for."""
NEGLIGIBLE = 1e-12
"""The chance of counts beyond those that are summed over."""

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Pilot:
    """Results of the pilot episodes of one behaviour.

    Parameters
    ----------
    collisions
        Episodes that ended by touching something; 0 or more.
    metres
        Driven in all episodes together; above 0.
    episodes
        Their number; 1 or more.

    Raises
    ------
    ValueError
        A number is not legal.
    """

    collisions: int
    metres: float
    episodes: int

    def __post_init__(self) -> None:
        if self.episodes < 1 or not 0 <= self.collisions <= self.episodes or not 0.0 < self.metres < np.inf:
            raise ValueError(f"{self}: legal are 1 episode or more, no more collisions than these, metres above 0")

    @property
    def rate(self) -> float:
        """Collisions per metre."""
        return self.collisions / self.metres

    @property
    def hits(self) -> float:
        """Collisions expected per episode."""
        return self.collisions / self.episodes

    @property
    def length(self) -> float:
        """Metres per episode."""
        return self.metres / self.episodes


def pilot(rows: Sequence[Mapping[str, Any]]) -> Pilot:
    """Return the sums over the rows of one behaviour's episodes; ``ValueError`` where nothing was driven."""
    return Pilot(sum(bool(row["touched"]) for row in rows), sum(row["driven_m"] for row in rows), len(rows))


def power(rarer: Pilot, other: Pilot, bound: float, episodes: int) -> float:
    """Return the chance that the whole 95 % interval of the ratio of two rates lies above ``bound``.

    Both counts are Poisson, with the pilot's rates and metres per episode, and all pairs of counts are summed over.
    An episode ends with its first collision, so a count is no Poisson number but the time to an event, cut at the
    episode's end. The logarithm of its rate has the same variance, 1 over the expected count
    (`tests/bench/closed_loop/test_power.py` compares both).

    Parameters
    ----------
    rarer, other
        The behaviour that is claimed to collide less often, and the one it is compared with.
    bound
        Of the ratio of their rates, ``other`` to ``rarer``; above 0.
    episodes
        Of each behaviour; 1 or more.

    Returns
    -------
    float
        From 0 to 1.

    References
    ----------
    Przyborowski and Wilenski 1940, Homogeneity of results in testing samples from Poisson series, Biometrika 31: the
    conditional test. Its interval is that of a binomial share (Clopper and Pearson 1934).
    """
    rows, columns = _most(other, episodes), _most(rarer, episodes)
    return _power(rarer, other, episodes, _clears(rarer, other, bound, rows, columns))


def episodes_needed(rarer: Pilot, other: Pilot, bound: float, target: float = TARGET) -> int | None:
    """Find the least number of episodes of each behaviour with which, and with any more, the power is ``target``.

    Parameters
    ----------
    rarer, other, bound
        As of `power`.
    target
        The power that is wanted, above 0 and below 1.

    Returns
    -------
    int or None
        ``None`` where not even `MOST_EPISODES` have that power.
    """
    clears = _clears(rarer, other, bound, _most(other, MOST_EPISODES), _most(rarer, MOST_EPISODES))
    least, enough = 1, MOST_EPISODES
    if _power(rarer, other, enough, clears) < target:
        return None
    # The sum over random totals smooths the steps of the exact test: power rises with the number of episodes.
    while least < enough:
        middle = (least + enough) // 2
        if _power(rarer, other, middle, clears) < target:
            least = middle + 1
        else:
            enough = middle
    return enough


def shares_needed(first: float, second: float) -> int:
    """Return the number of trials of each of two kinds to tell two shares apart, by a two-sided test at 5 %.

    The power is `TARGET`.

    Parameters
    ----------
    first, second
        The shares, both above 0 and below 1, not equal.

    References
    ----------
    Fleiss, Levin and Paik 2003, Statistical Methods for Rates and Proportions, equation 4.14 (without correction for
    continuity).
    """
    middle = (first + second) / 2
    apart = special.ndtri(1.0 - TAIL) * np.sqrt(2 * middle * (1 - middle))
    apart += special.ndtri(TARGET) * np.sqrt(first * (1 - first) + second * (1 - second))
    return int(np.ceil((apart / (first - second)) ** 2))


def check_pilot(name: str, pilot: Pilot) -> None:
    """Raise `UsageError` for a pilot in which ``name``, which is to collide more often, touched nothing."""
    if not pilot.collisions:
        raise UsageError(
            f"--power {name}: it touched nothing in {pilot.episodes} episodes, so nothing can collide less often;"
            " more --episodes may tell"
        )


def _power(rarer: Pilot, other: Pilot, episodes: int, clears: npt.NDArray[np.bool_]) -> float:
    rows, columns = clears.shape
    return float(_chances(other.hits * episodes, rows) @ clears @ _chances(rarer.hits * episodes, columns))


def _clears(rarer: Pilot, other: Pilot, bound: float, rows: int, columns: int) -> npt.NDArray[np.bool_]:
    """(rows, columns): whether the interval clears the bound at so many collisions of ``other`` and of ``rarer``.

    Given the sum, the count of ``other`` is binomial. Its share is that of the bound at the chance ``edge``. The lower
    end of the interval lies above that where so many or more would be rarer than `TAIL`.
    """
    edge = bound * other.length / (rarer.length + bound * other.length)
    more, fewer = np.arange(rows)[1:, None], np.arange(columns)[None, :]
    some = special.betainc(more, fewer + 1.0, edge) < TAIL
    return np.concatenate([np.zeros((1, columns), bool), some])


def _most(behaviour: Pilot, episodes: int) -> int:
    """Return one more than the greatest count that is summed over."""
    from scipy import stats

    return int(stats.poisson.isf(NEGLIGIBLE, behaviour.hits * episodes)) + 1


def _chances(expected: float, size: int) -> Floats:
    """Return the chances of 0, 1, ... collisions, (size,)."""
    from scipy import stats

    return np.asarray(stats.poisson.pmf(np.arange(size), expected), float)
