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
MOST_STEPS = 100
OFF_WHOLE, OFF_SHARE = 0.05, 0.01
"""Steps by which a change of the mean may miss a whole number n of steps: 0.05 + 0.01 n, as rounding bends it."""


@dataclass(frozen=True, slots=True)
class ExposureLoop:
    """What settling pictures tell of the loop that controls the exposure time.

    Parameters
    ----------
    step
        One step of the exposure, as a share of it.
    steps
        The most steps that were seen in a frame.
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

    Returns
    -------
    ExposureLoop
        The step of the exposure, and the ends of the zone that the sequences show.

    Raises
    ------
    MetrologyError
        No sequence changes and comes to rest, or the steps cannot be told apart.
    """
    settled = [own for own in map(_settling, sequences) if own.jumps and own.rest is not None]
    if not settled:
        raise MetrologyError("no sequence of frames settles: the mean grey should change, and then rest for 2 frames")
    step, steps = _steps([jump for own in settled for jump in own.jumps])
    ends = []
    for way, factor in ((1.0, 1.0 + step), (-1.0, 1.0 - step)):
        side = [own for own in settled if own.jumps[-1] * way > 0]
        # The loop reckons from a picture before its last change: where that is its only one, it is this picture.
        side = [own for own in side if len(own.jumps) == 1] or side
        counts = [round(own.jumps[-1] / math.log(factor)) for own in side]
        ends.append(_common([
            (own.before * factor ** (count - 1), own.before * factor**count)
            for own, count in zip(side, counts, strict=True)
        ]))  # fmt: skip
    return ExposureLoop(step, steps, ends[0], ends[1])


@dataclass(frozen=True, slots=True)
class _Settling:
    """A sequence: the logarithms of its changes of the mean, the mean before the last of them, and the mean at rest."""

    jumps: tuple[float, ...]
    before: float
    rest: float | None


def _settling(frames: Images) -> _Settling:
    means = frames.astype(np.float64).mean((1, 2))
    clipped = [float(np.isin(frame, (0, 255)).mean()) for frame in frames]
    jumps = [
        (math.log(after / before), float(before))
        for (before, after), bad in zip(pairwise(means), pairwise(clipped), strict=True)
        if abs(after / max(before, 1e-9) - 1.0) > REST and max(bad) <= SATURATED
    ]
    rests = len(means) > 2 and np.ptp(means[-3:]) <= REST * means[-1] and clipped[-1] <= SATURATED
    last = jumps[-1][1] if jumps else 0.0
    return _Settling(tuple(jump for jump, _ in jumps), last, float(means[-2:].mean()) if rests else None)


def _steps(jumps: Sequence[float]) -> tuple[float, int]:
    """One step as a share, and the most steps in a frame: the fewest of which all jumps are whole multiples."""
    sizes, up = np.abs(jumps), np.asarray(jumps) > 0
    for steps in range(1, MOST_STEPS + 1):
        largest = int(np.argmax(sizes))
        share = math.expm1(sizes[largest] / steps) if up[largest] else -math.expm1(-sizes[largest] / steps)
        # Of a step s up the logarithm is log(1 + s), of one down -log(1 - s).
        if 0.0 < share < 1.0:
            counts = np.rint(sizes / np.where(up, math.log1p(share), -math.log1p(-share)))
            if counts.min() < 1.0:
                continue
            means = [float((counts * sizes)[way].sum() / (counts[way] ** 2).sum()) if way.any() else 0.0
                     for way in (up, ~up)]  # fmt: skip
            shares = [math.expm1(means[0]), -math.expm1(-means[1])]
            share = float(np.average(shares, weights=[counts[up].sum(), counts[~up].sum()]))
            off = np.abs(sizes / np.where(up, math.log1p(share), -math.log1p(-share)) - counts)
            if np.all(off <= OFF_WHOLE + OFF_SHARE * counts):
                return share, int(counts.max())
    raise MetrologyError("the exposure changes by no whole multiples of a step: does the light stay the same?")


def _common(intervals: Sequence[tuple[float, float]]) -> tuple[float, float] | None:
    """What intervals have in common; where noise leaves nothing, its middle twice."""
    if not intervals:
        return None
    low, high = max(min(own) for own in intervals), min(max(own) for own in intervals)
    return (low, high) if low <= high else ((low + high) / 2,) * 2
