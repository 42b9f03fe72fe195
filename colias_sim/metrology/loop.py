"""The loop that controls the exposure time: its step and its control zone, from pictures that settle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from colias_sim.metrology.errors import MetrologyError

Images = npt.NDArray[np.uint8]

SATURATED = 0.005
"""Share of clipped pixels from which a picture's mean does not go with its exposure."""
REST = 0.002
"""Share by which the mean of a picture may change while the exposure rests."""


@dataclass(frozen=True, slots=True)
class ExposureLoop:
    """What settling pictures tell of the loop that controls the exposure time.

    Parameters
    ----------
    step
        One step of the exposure, as a share of it; the most steps a frame is ``steps``.
    low, high
        The ends of the control zone, the dead band, as intervals of mean grey; ``None`` where no sequence came from
        below, or from above.
    """

    step: float
    steps: int
    low: tuple[float, float] | None
    high: tuple[float, float] | None

    @property
    def target(self) -> float | None:
        """The middle of the zone, grey; ``None`` where only one end is known."""
        return None if self.low is None or self.high is None else (sum(self.low) + sum(self.high)) / 4.0

    @property
    def zone(self) -> float | None:
        """Half the width of the zone, in grey levels."""
        return None if self.low is None or self.high is None else (sum(self.high) - sum(self.low)) / 4.0


def exposure_loop(sequences: Sequence[Images]) -> ExposureLoop:
    """Measure the loop that controls the exposure from pictures of still scenes on which it settles.

    Between two frames the loop changes the exposure by whole steps, and the mean of the picture with it. It ends the
    first time that the mean is in its zone: a step earlier the mean was still outside. So each sequence gives an
    interval for one end of the zone, and several sequences a narrow one.

    Parameters
    ----------
    sequences
        Each (T, R, C): from any moment after the light has changed until the picture rests, by one still light.

    Raises
    ------
    MetrologyError
        No sequence changes and comes to rest, or the steps cannot be told apart.
    """
    jumps: list[float] = []
    rests: list[tuple[float, float]] = []
    for frames in sequences:
        own, rest = _settling(frames)
        jumps += own
        if own and rest is not None:
            rests.append((own[-1], rest))
    if not rests:
        raise MetrologyError("no sequence of frames settles: the mean grey should change, and then rest for 2 frames")
    step, steps = _steps(jumps)
    low = [(rest / (1.0 + step), rest) for last, rest in rests if last > 0]
    high = [(rest, rest / (1.0 - step)) for last, rest in rests if last < 0]
    return ExposureLoop(step, steps, _common(low), _common(high))


def _settling(frames: Images) -> tuple[list[float], float | None]:
    """The ratios, as logarithms, by which the mean changes from frame to frame, and the mean at rest."""
    stack = frames.astype(np.float64)
    means = stack.mean((1, 2))
    clipped = [float(np.isin(frame, (0, 255)).mean()) for frame in frames]
    jumps = [
        math.log(after / before)
        for (before, after), bad in zip(pairwise(means), pairwise(clipped), strict=True)
        if abs(after / before - 1.0) > REST and max(bad) <= SATURATED
    ]
    rests = len(means) > 2 and np.ptp(means[-3:]) <= REST * means[-1] and clipped[-1] <= SATURATED
    return jumps, float(means[-2:].mean()) if rests else None


def _steps(jumps: Sequence[float]) -> tuple[float, int]:
    """One step as a share, and the most steps in a frame: the fewest of which all jumps are whole multiples."""
    up, down = ([abs(jump) for jump in jumps if (jump > 0) == way] for way in (True, False))
    most = max([*(jump for jump in up), *(jump for jump in down)])
    for steps in range(1, 101):
        # Of a step s up the logarithm is log(1 + s), of one down log(1 - s).
        unit = most / steps
        share = math.expm1(unit) if most in up else -math.expm1(-unit)
        if share >= 1.0:
            continue
        units = (math.log1p(share), -math.log1p(-share))
        counts = [(jump, jump / own) for own, side in zip(units, (up, down), strict=True) for jump in side]
        if all(abs(count - round(count)) <= 0.06 and round(count) >= 1 for _, count in counts):
            return share, max(round(count) for _, count in counts)
    raise MetrologyError("the exposure changes by no whole multiples of a step: does the light stay the same?")


def _common(intervals: Sequence[tuple[float, float]]) -> tuple[float, float] | None:
    """What intervals have in common; where noise leaves nothing, its middle twice."""
    if not intervals:
        return None
    low, high = max(own[0] for own in intervals), min(own[1] for own in intervals)
    return (low, high) if low <= high else ((low + high) / 2,) * 2
