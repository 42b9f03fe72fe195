"""Measures of an env's episodes, from the ``info`` of their steps."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.float64]

ANY, SIZE, SHARE = (-math.inf, math.inf), (0.0, math.inf), (0.0, 1.0)
"""The least and the largest possible value of a column, which bound its intervals."""
GAIN_PLACES = 12
"""Decimals of an optomotor gain, beyond which are rounding errors of its sums."""

COLLISIONS = PER_MINUTE, PER_METRE, FREE_DISTANCE = "collisions/min", "collisions/m", "free distance (m)"
"""Measures of collisions: their rates, and the distance per collision."""
RETURN = "return"
"""The mean sum of an episode's rewards, in the column ``reward``. Every env has it, as its last measure."""


def rms(values: Values) -> float:
    """Compute the root of the mean square, in which opposite signs do not cancel."""
    return float(np.sqrt(np.square(values).mean()))


def optomotor_gain(slip_deg_s: Values, drift_deg_s: Values) -> float | None:
    """Compute 1 - sum(slip sign(drift)) / sum |drift|.

    It is 0 for a robot that does nothing, 1 for one whose view never turns, and ``None`` where nothing disturbed it.
    """
    whole = float(np.abs(drift_deg_s).sum())
    # The difference of two sums that are alike has their rounding errors: what does nothing has a gain of 0.
    slipped = float((slip_deg_s * np.sign(drift_deg_s)).sum())
    return round(1.0 - slipped / whole, GAIN_PLACES) + 0.0 if whole else None
