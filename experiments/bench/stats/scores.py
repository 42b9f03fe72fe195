"""Scores with their intervals: what leaderboards and behaviours are told by."""

from __future__ import annotations

import math
from dataclasses import dataclass

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


def written(value: float) -> str:
    """Return a number for people, to three digits and four decimal places; a dash for NaN."""
    if math.isnan(value):
        return "-"
    if abs(value) >= 1000.0:
        return f"{value:.0f}"
    # Rounded once: 0.64753 has four places of 0.6475, and three digits of that would be 0.647.
    places = min(2 - math.floor(math.log10(abs(value))), PLACES) if value and math.isfinite(value) else PLACES
    return f"{round(value, places):z.3g}"
