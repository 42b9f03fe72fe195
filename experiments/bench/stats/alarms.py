"""Alarms of a looming detector: how long before contact the first one is, and how many there are in a minute.

A detector answers by spikes, several in a row. An alarm is a spike with no other in the `APART_S` before it: what an
animal, or a robot that escapes, would begin one escape at.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

APART_S = 0.5
"""Silence that ends an alarm, s. A reflex of this bench turns away for 0.4 s."""

Floats = npt.NDArray[np.float64]


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


def first_alarm_s(spikes: npt.NDArray[np.integer], contact_s: Floats) -> float | None:
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
