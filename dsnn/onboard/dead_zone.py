"""Compute the dead zone of a delayed signal D: with few bits and a long delay it changes by less than a step a frame.

A frame changes D by ``alpha (F - D)``, with ``alpha = dt / (dt + tau)``, and D is then rounded to a code. A change of
less than half a step is lost; with truncation, a rise of less than a step. Nothing compensates for it: D stays constant
as long as F does. There are two cases.

- F is 0, and D should fall to 0. A companded code has steps of 1/32 to 1/63 of D. So D falls through all segments if
  ``alpha`` is at least 1/66, which is a delay of up to 65 frames. With a longer delay D stays constant in most of its
  range. Steps of a linear code, or of one with 16 bits, have one size, and the lowest ``1 / (2 alpha)`` codes stay
  constant. With truncation D always falls.
- D is 0, and should rise to F. It does not if F is at most ``1 / (2 alpha)`` steps; with truncation, if F is less than
  ``1 / alpha`` steps.
"""

from __future__ import annotations

import math
from bisect import bisect_left

import numpy as np

from dsnn.filters import alpha
from dsnn.onboard.codes import EXTRA, Ints, coded, decoded
from dsnn.onboard.numpy_form import rounded
from dsnn.onboard.params import OnboardParams

SMALL = 1 / 64
"""A dead zone up to this share of D's range is negligible: companded codes have equal, small steps there."""


def dead_zone(params: OnboardParams) -> tuple[float, float]:
    """Compute the dead zone of a network's longest delay, by trying its arithmetic.

    Parameters
    ----------
    params
        The parameters of the on-board network.

    Returns
    -------
    falling, rising : float
        The largest D that stays constant while F is 0, and the largest F to which D does not rise from 0, as shares of
        the range of D, which equals the range of F. Up to `SMALL` they are negligible.

    Examples
    --------
    >>> from dsnn import OnboardParams
    >>> from dsnn.onboard.dead_zone import SMALL, dead_zone
    >>> max(dead_zone(OnboardParams(tau_s=(10.0, 200.0)))) <= SMALL
    True
    >>> max(dead_zone(OnboardParams(tau_s=(10.0, 3000.0)))) <= SMALL
    False
    """
    return _zone(params, math.floor(alpha(max(params.delays()), params.dt) * 32768.0 + 0.5))


def longest_delay(params: OnboardParams) -> float:
    """Compute the longest delay without a dead zone above `SMALL`, for a format and a frame rate.

    Parameters
    ----------
    params
        The parameters of the on-board network. Their delays do not matter.

    Returns
    -------
    float
        The delay, in ms.
    """
    # The dead zone grows as the gain falls, so bisection finds the least gain without one.
    least = 1 + bisect_left(range(1, 32769), True, key=lambda gain: max(_zone(params, gain)) <= SMALL)
    return params.dt * (32768.0 / (least - 0.5) - 1.0)


def _zone(params: OnboardParams, gain: int) -> tuple[float, float]:
    """Find both shares, falling and rising, for a gain in Q15, by trying every D with F = 0, and every F with D = 0."""
    codes = np.arange(32768 if params.state_bits == 16 else 256)
    values = codes if params.state_bits == 16 else decoded(codes, params.companding)
    most = int(values[-1])
    stuck = values[_coded(values * (32768 - gain), params) == codes]
    fields = np.arange(most + 1)
    unmoved = fields[_coded(fields * gain, params) == 0]
    return float(stuck.max()) / most, float(unmoved.max()) / most


def _coded(values: Ints, params: OnboardParams) -> Ints:
    """Find the code of D, given with `EXTRA` more fractional bits than F."""
    truncate = params.rounding == "truncate"
    if params.state_bits == 16:
        codes: Ints = rounded(values, EXTRA, truncate)
        return codes
    return coded(values, params.companding, truncate)
