"""Changes that a delayed signal D of few bits cannot follow: long delays change it by less than a step a frame.

A frame changes D by ``alpha (F - D)``, with ``alpha = dt / (dt + tau)``, and D is then rounded to a code. A change of
less than half a step is lost, with truncation a rise of less than a step. Nothing makes up for it: D stands still as
long as F does. There are two cases.

- F is 0, and D should fall to 0. A companded code is D in steps of 1/32 to 1/63 of its size, so D falls through all
  segments if ``alpha`` is at least 1/66: up to a delay of 65 frames. With a longer one D stands still wherever it is
  in most of its range. A step of a linear code, or one of 16 bits, has one size, and the lowest ``1 / (2 alpha)`` codes
  stand still. Truncation always falls.
- D is 0, and should rise to F. It does not where F is no more than ``1 / (2 alpha)`` steps, with truncation where it is
  less than ``1 / alpha``.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from dataclasses import dataclass

import numpy as np

from dsnn.filters import alpha
from dsnn.onboard.codes import EXTRA, Ints, coded, decoded
from dsnn.onboard.numpy_form import rounded
from dsnn.onboard.params import OnboardParams

SMALL = 1 / 64
"""A dead zone up to this share of D's range is none: companded codes have equal steps there, of 1/4032 of the range."""


@dataclass(frozen=True, slots=True)
class DeadZone:
    """Changes that the delay of the most frames cannot follow. Shares are of the range of D, which is that of F.

    Parameters
    ----------
    tau_ms
        That delay, ms.
    falling
        The largest D that stands still while F is 0.
    rising
        The largest F to which D does not rise from 0.
    longest_ms
        The longest delay with which both are `SMALL` or less in this format, at this number of frames a second.
    """

    tau_ms: float
    falling: float
    rising: float
    longest_ms: float

    @property
    def matters(self) -> bool:
        """Tell whether it is more than `SMALL`."""
        return max(self.falling, self.rising) > SMALL


def dead_zone(params: OnboardParams) -> DeadZone:
    """Return the dead zone of a network's longest delay, as its arithmetic has it.

    Parameters
    ----------
    params
        What is set.

    Returns
    -------
    DeadZone
        Of the longest of ``params.delays()``.

    Examples
    --------
    >>> from dsnn import OnboardParams
    >>> from dsnn.onboard.dead_zone import dead_zone
    >>> dead_zone(OnboardParams(tau_s=(10.0, 200.0))).matters
    False
    >>> dead_zone(OnboardParams(tau_s=(10.0, 3000.0))).matters
    True
    """
    tau = max(params.delays())
    falling, rising = _zone(params, math.floor(alpha(tau, params.dt) * 32768.0 + 0.5))
    # The dead zone grows as the gain falls, so the least gain without one is found by halving.
    least = 1 + bisect_left(range(1, 32769), True, key=lambda gain: max(_zone(params, gain)) <= SMALL)
    return DeadZone(tau, falling, rising, params.dt * (32768.0 / (least - 0.5) - 1.0))


def _zone(params: OnboardParams, gain: int) -> tuple[float, float]:
    """Return the two shares, with a gain in Q15: every D is tried with F = 0, and every F with D = 0."""
    codes = np.arange(32768 if params.state_bits == 16 else 256)
    values = codes if params.state_bits == 16 else decoded(codes, params.companding)
    most = int(values[-1])
    stuck = values[_coded(values * (32768 - gain), params) == codes]
    fields = np.arange(most + 1)
    unmoved = fields[_coded(fields * gain, params) == 0]
    return float(stuck.max()) / most, float(unmoved.max()) / most


def _coded(values: Ints, params: OnboardParams) -> Ints:
    """Return the code of D, which is given with `EXTRA` more fractional bits than F has."""
    truncate = params.rounding == "truncate"
    if params.state_bits == 16:
        codes: Ints = rounded(values, EXTRA, truncate)
        return codes
    return coded(values, params.companding, truncate)
