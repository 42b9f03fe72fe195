"""Test whether a preference is defined, or lies within the noise of what measures it. Pure.

Two rules, each for what can be told apart from noise there:

- A **preferred direction** is measured at several phases of the grating, which no property of direction depends on.
  It is defined where its 95 % interval over the phases is no wider than the step between the directions shown.
- A **preferred value** of a curve or map is defined where neighbouring points are more alike than they would be in a
  random order (von Neumann's ratio, by permutations). What scatters from point to point has a largest point too.

References
----------
von Neumann 1941, Distribution of the ratio of the mean square successive difference to the variance, Annals of
Mathematical Statistics 12. Fisher 1993, Statistical Analysis of Circular Data, 4.4: intervals of a mean direction.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy import special

from experiments.bench.run.streams import stream
from experiments.bench.stats.tests import PERMUTATIONS, SEED

LEVEL = 0.05
LEAST_POINTS = 5
"""Of four points one order in twelve is as smooth as a slope."""
SOME = 0.05
"""The least DSI with which there is a preferred direction to tell of."""

Floats = npt.NDArray[np.float64]


def direction_noise(preferred_deg: Sequence[float]) -> float:
    """Half the width of the 95 % interval of a preferred direction over repeats, degrees; infinite of fewer than two.

    Student's interval of the deviations from the circular mean.
    """
    turns = np.radians(np.asarray(preferred_deg, float))
    if turns.size < 2:
        return math.inf
    mean = np.angle(np.exp(1j * turns).sum())
    off = np.degrees(np.angle(np.exp(1j * (turns - mean))))
    return float(special.stdtrit(turns.size - 1, 0.975) * off.std(ddof=1) / math.sqrt(turns.size))


def undefined_direction(preferred_deg: Sequence[float], step_deg: float) -> str:
    """Tell why a preferred direction is not defined, in words; empty where it is.

    Parameters
    ----------
    preferred_deg
        The preferred direction at each phase, degrees.
    step_deg
        Between the directions shown, degrees.
    """
    half = direction_noise(preferred_deg)
    if not math.isfinite(half) or half <= step_deg / 2:
        return ""
    return (
        f"the preferred direction varies by ±{half:.0f}° over {len(preferred_deg)} phases of the grating, and the "
        f"directions shown are {step_deg:g}° apart"
    )


def undefined_peak(response: Sequence[float] | Floats) -> str:
    """Tell why the largest point of a curve (n,), or of a map (m, n), is no preference, in words; empty where it is
    one.
    """
    points = np.atleast_2d(np.asarray(response, float))
    p = order_p(points)
    if p <= LEVEL:
        return ""
    if points.size < LEAST_POINTS:
        return f"{points.size} points, and fewer than {LEAST_POINTS} cannot be told from a random order"
    return f"neighbouring points are no more alike than points in a random order (p = {p:.2f})"


def order_p(response: Floats) -> float:
    """Return the share of random orders of a map's points, (m, n), in which neighbours are as alike as in the one seen.

    Equal points, and maps with missing points, give 0: there is nothing to test.
    """
    if response.size < 3 or not np.isfinite(response).all() or np.ptp(response) == 0.0:
        return 0.0
    shuffled = np.tile(response.ravel(), (PERMUTATIONS, 1))
    shuffled = stream("permutations.points", SEED).permuted(shuffled, axis=1).reshape(-1, *response.shape)
    seen = float(_roughness(response[None])[0])
    as_smooth = int((_roughness(shuffled) <= seen * (1 + 1e-9)).sum())
    return (as_smooth + 1) / (PERMUTATIONS + 1)


def _roughness(maps: Floats) -> Floats:
    """Return the sum of squared differences between neighbours, of maps (k, m, n)."""
    down, across = np.diff(maps, axis=1), np.diff(maps, axis=2)
    return np.asarray((down**2).sum((1, 2)) + (across**2).sum((1, 2)))
