"""The loop that controls the exposure time: its step and its control zone, from pictures that settle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from colias_sim.metrology.errors import MetrologyError

Floats = npt.NDArray[np.float64]
Images = npt.NDArray[np.uint8]

SATURATED = 0.005
"""Share of clipped pixels from which a picture's mean does not go with its exposure."""
REST = 0.002
"""Share by which the mean of a picture may change while the exposure rests."""
ROUNDING = 0.001
"""Share by which rounding to whole grey levels bends a mean that is reckoned from another."""
MOST_STEPS = 100
OFF_WHOLE, OFF_SHARE = 0.05, 0.01
"""Steps by which a change of the mean may miss a whole number n of steps: 0.05 + 0.01 n, as rounding bends it."""

MOST_CHANCE = 0.01
"""Number of steps that may fit by chance where the one found is certain."""
MOST_OTHER = 20
"""The most steps in a frame of another fit: a finer one fits anything."""


@dataclass(frozen=True, slots=True)
class ExposureLoop:
    """Properties, told by settling pictures, of the loop that controls the exposure time.

    Parameters
    ----------
    step
        One step of the exposure, as a share of it.
    steps
        The most steps that were seen in a frame.
    low, high
        The ends of the control zone, the dead band, as intervals of mean grey; ``None`` where no sequence came from
        below, or from above.
    certain
        Whether the changes tell this step from others: no other fits them, and they are enough that it does not fit by
        chance. Otherwise the step, and with it the zone, may be quite another: more sequences tell.
    """

    step: float
    steps: int
    low: tuple[float, float] | None
    high: tuple[float, float] | None
    certain: bool = True

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
    settled = [settling for settling in map(_settling, sequences) if settling.jumps and settling.rest is not None]
    if not settled:
        raise MetrologyError("no sequence of frames settles: the mean grey should change, and then rest for 2 frames")
    step, steps = _steps([jump for settling in settled for jump in settling.jumps])
    ends = []
    for way, factor in ((1.0, 1.0 + step), (-1.0, 1.0 - step)):
        side = [settling for settling in settled if settling.jumps[-1] * way > 0]
        # The loop reckons from a picture before its last change: where that is its only one, it is this picture.
        side = [settling for settling in side if len(settling.jumps) == 1] or side
        ends.append(_common([_end(settling, factor) for settling in side]))
    return ExposureLoop(step, steps, ends[0], ends[1], _certain(settled, steps))


def _end(settling: _Settling, factor: float) -> tuple[float, float]:
    """Return the interval of an end of the zone: by the picture before the last change, and by the one before that.

    The loop may have reckoned from either, as its answer to a picture comes a frame or two later. Rounding makes them
    differ by some tenths of a grey level.
    """
    counts = [round(jump / math.log(factor)) for jump in settling.jumps[-2:]]
    reckoned = [(settling.before[-1], counts[-1])]
    if len(counts) > 1 and counts[0] > 0:
        reckoned.append((settling.before[-2], sum(counts)))
    outside = [mean * factor ** (count - 1) for mean, count in reckoned]
    within = [mean * factor**count for mean, count in reckoned]
    ends = (min(outside), max(within)) if factor > 1.0 else (min(within), max(outside))
    return ends[0] * (1.0 - ROUNDING), ends[1] * (1.0 + ROUNDING)


@dataclass(frozen=True, slots=True)
class _Settling:
    """A sequence: the logarithms of its changes of the mean, the means before them, and the mean at rest."""

    jumps: tuple[float, ...]
    before: tuple[float, ...]
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
    rest = float(means[-2:].mean()) if rests else None
    return _Settling(tuple(jump for jump, _ in jumps), tuple(before for _, before in jumps), rest)


def _steps(jumps: Sequence[float]) -> tuple[float, int]:
    """Return one step as a share, and the most steps in a frame: the fewest of which all jumps are whole multiples."""
    for steps in range(1, MOST_STEPS + 1):
        fit = _fit(jumps, steps)
        if fit is not None:
            return fit
    raise MetrologyError("the exposure changes by no whole multiples of a step: does the light stay the same?")


def _fit(jumps: Sequence[float], steps: int) -> tuple[float, int] | None:
    """Find a step as a share where the largest jump is of ``steps``, and the most steps; ``None`` if others misfit.

    Of a step s up the logarithm is log(1 + s), of one down -log(1 - s).
    """
    sizes, up = np.abs(jumps), np.asarray(jumps) > 0
    largest = int(np.argmax(sizes))
    share = math.expm1(sizes[largest] / steps) if up[largest] else -math.expm1(-sizes[largest] / steps)
    if not 0.0 < share < 1.0:
        return None
    counts = np.rint(sizes / np.where(up, math.log1p(share), -math.log1p(-share)))
    if counts.min() < 1.0:
        return None
    means = [float((counts * sizes)[way].sum() / (counts[way] ** 2).sum()) if way.any() else 0.0 for way in (up, ~up)]
    shares = [math.expm1(means[0]), -math.expm1(-means[1])]
    share = float(np.average(shares, weights=[counts[up].sum(), counts[~up].sum()]))
    off = np.abs(sizes / np.where(up, math.log1p(share), -math.log1p(-share)) - counts)
    return (share, int(counts.max())) if np.all(off <= _tolerance(counts)) else None


def _tolerance(counts: Floats) -> Floats:
    """Steps by which a change of ``counts`` steps may miss a whole number."""
    return OFF_WHOLE + OFF_SHARE * counts


def _certain(settled: Sequence[_Settling], steps: int) -> bool:
    """Tell whether no other step fits the changes, and the one that does would hardly fit changes of any size.

    A change of any size fits by chance with twice the tolerance. Changes of one size tell no more than one of them:
    they come of equal light, or of a loop at its most steps. But the last of several in a sequence could have been of
    any size.
    """
    jumps = [jump for settling in settled for jump in settling.jumps]
    if any(_fit(jumps, other) for other in range(steps + 1, MOST_OTHER + 1) if other % steps):
        return False
    largest = max(map(abs, jumps))
    last = [_counted(settling.jumps[-1], largest, steps) for settling in settled if len(settling.jumps) > 1]
    telling = [*last, *({_counted(jump, largest, steps) for jump in jumps} - {*last})]
    telling.remove(_counted(max(jumps, key=abs), largest, steps))  # fits whatever the step is
    shares = 2.0 * _tolerance(np.array([count for _, count in telling], np.float64))
    return float(steps * np.prod(shares)) <= MOST_CHANCE


def _counted(jump: float, largest: float, steps: int) -> tuple[bool, int]:
    """Tell whether a change is one up, and of about how many steps."""
    return jump > 0, max(round(abs(jump) / largest * steps), 1)


def _common(intervals: Sequence[tuple[float, float]]) -> tuple[float, float] | None:
    """Return what intervals have in common; where noise leaves nothing, what is between them."""
    if not intervals:
        return None
    low, high = max(min(interval) for interval in intervals), min(max(interval) for interval in intervals)
    return (min(low, high), max(low, high))
