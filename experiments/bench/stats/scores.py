"""Scores with their intervals, and alarms of looming detectors: by what leaderboards and behaviours are told.

A detector answers by spikes, several in a row. An alarm is a spike with no other in the `APART_S` before it: what an
animal, or a robot that escapes, would begin one escape at.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

APART_S = 0.5
"""Silence that ends an alarm, s. A reflex of this bench turns away for 0.4 s."""
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


def poisson_interval(count: float) -> tuple[float, float]:
    """Return the exact 95 % interval of the expectation of a Poisson count.

    References
    ----------
    Garwood 1936, Fiducial limits for the Poisson distribution, Biometrika 28.
    """
    from scipy import special  # not before: it takes its time to load

    low = float(special.gammaincinv(count, 0.025)) if count else 0.0
    return low, float(special.gammaincinv(count + 1, 0.975))
