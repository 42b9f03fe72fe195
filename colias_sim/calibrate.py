"""Calibrate a camera from its frames, the simulated eye's or a real one's: noise, edges, tone and exposure.

Each function takes frames, (T, R, C) or (R, C), as any camera gives them, and needs no simulator. The numbers that it
finds are settings of `colias_sim.CameraConfig`. The tests hold the simulated eye to its own settings by them.

References
----------
EMVA 1288, Release 4.0: photon transfer, and the correction of spatial variance for temporal noise. ISO 12233: the
slanted edge.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from colias_sim.registers import CONTRAS_CENTER_RESET, GAMMA_INPUTS, UNIT_CONTRAS

__all__ = [
    "CalibrationError", "ExposureLoop", "NoiseLevels", "PhotonTransfer", "contrast_and_brightness", "edge_columns",
    "edge_rows", "exposure_loop", "falloff_exponent", "fixed_pattern", "gamma_points", "lean", "noise_levels",
    "photon_transfer", "row_time_us", "transfer", "unsteadiness",
]  # fmt: skip

Floats = npt.NDArray[np.float64]
Images = npt.NDArray[np.uint8]
Whole = npt.NDArray[np.int64]

QUANTISATION = 1.0 / 12.0
"""Variance of rounding to whole grey levels."""
CLIP_SDS = 4.0
"""A pixel counts where its mean is this many sd away from 0 and from 255: clipping makes noise look smaller."""
SCATTER_SDS = 4.0
"""Bound on the scatter of `unsteadiness` where all is noise, about one over the root of the number of values."""
LEAST_PIXELS = 30
"""The fewest pixels of a bin of grey levels."""
LEAST_ROWS = 8
"""The fewest rows from which the lean of an edge is measured."""
MARGIN = 2.0
"""A step of a chart counts where its luma is this many grey levels from 0 and from 255: clipping bends the line."""

SATURATED = 0.005
"""Share of clipped pixels from which a picture's mean does not go with its exposure."""
REST = 0.002
"""Share by which the mean of a picture may change while the exposure rests."""
ROUNDING = 0.001
"""Share by which rounding to whole grey levels bends a mean that is computed from another."""
MOST_STEPS = 100
"""The most steps of the exposure in a frame that are tried."""
OFF_WHOLE, OFF_SHARE = 0.05, 0.01
"""Steps by which a change of the mean may miss a whole number n of steps: 0.05 + 0.01 n, as rounding bends it."""
MOST_CHANCE = 0.01
"""Number of steps that may fit by chance where the one found is certain."""
MOST_OTHER = 20
"""The most steps in a frame of another fit: a finer one fits anything."""


class CalibrationError(ValueError):
    """Frames that do not show what is to be measured: what they lack, in one line."""


# Noise.


@dataclass(frozen=True, slots=True)
class NoiseLevels:
    """Temporal noise of a still scene by grey level.

    Parameters
    ----------
    mean, variance
        Of each bin of pixels, (N,), in grey levels and their squares. The rounding's variance is taken off.
    pixels
        How many pixels each bin has, (N,).
    """

    mean: Floats
    variance: Floats
    pixels: Whole


@dataclass(frozen=True, slots=True)
class PhotonTransfer:
    """The line ``variance = slope mean + dark_sd^2`` of the photon transfer.

    Parameters
    ----------
    slope
        Grey levels of variance for each of mean.
    dark_sd
        Noise without light, sd in grey levels.
    """

    slope: float
    dark_sd: float

    def shot_noise(self, gain: float) -> float:
        """Compute ``shot_noise`` of `colias_sim.CameraConfig`: slope = gain shot_noise^2 / 255.

        Parameters
        ----------
        gain
            The camera's gain.

        Returns
        -------
        float
            The shot noise, a setting of the camera.
        """
        return math.sqrt(max(self.slope, 0.0) * 255.0 / gain)

    def read_noise(self, gain: float) -> float:
        """Compute ``read_noise`` of `colias_sim.CameraConfig`: dark_sd = gain read_noise.

        Parameters
        ----------
        gain
            The camera's gain.

        Returns
        -------
        float
            The read noise, a setting of the camera.
        """
        return self.dark_sd / gain


def noise_levels(frames: Images, bins: int = 16) -> NoiseLevels:
    """Measure temporal noise by grey level.

    Parameters
    ----------
    frames
        Of a still scene under constant light, (T, R, C), T of at least 8. It should have many grey levels, or be
        taken together with others by `photon_transfer`.
    bins
        Number of bins of pixels of similar grey.

    Returns
    -------
    NoiseLevels
        The bins that have pixels enough.

    Raises
    ------
    CalibrationError
        There are too few frames, or every pixel is clipped.
    """
    if len(frames) < 8:
        raise CalibrationError(f"noise takes 8 or more frames of the still scene (60 are good), got {len(frames)}")
    stack = frames.astype(np.float64)
    mean, variance = stack.mean(0).ravel(), stack.var(0, ddof=1).ravel()
    whole = ((stack.min(0) > 0.0) & (stack.max(0) < 255.0)).ravel()  # of a clipped pixel less noise is seen
    spread = np.sqrt(np.median(variance[whole])) if whole.any() else np.inf
    inside = (mean > CLIP_SDS * spread) & (mean < 255.0 - CLIP_SDS * spread)
    if inside.sum() < LEAST_PIXELS:
        raise CalibrationError("the still scene is clipped at 0 or 255: take it with other light")
    mean, variance = mean[inside], variance[inside]
    edges = np.linspace(mean.min(), mean.max() + 1e-9, bins + 1)
    place = np.digitize(mean, edges) - 1
    used = [place == index for index in range(bins) if (place == index).sum() >= LEAST_PIXELS]
    return NoiseLevels(
        np.array([mean[bin_].mean() for bin_ in used]),
        np.array([variance[bin_].mean() for bin_ in used]) - QUANTISATION,
        np.array([bin_.sum() for bin_ in used], np.int64),
    )


def unsteadiness(frames: Images) -> float:
    """Measure which share of the temporal variance of a still scene is no noise of its pixels: it was not still.

    Parameters
    ----------
    frames
        Of a scene that should be still under constant light, (T, R, C), T of 3 or more.

    Returns
    -------
    float
        A share of the variance, 0 to 1: of slow change, by which frames far apart differ more than neighbours do (von
        Neumann), or of the mean of the whole picture, whichever is more. 0 where it is no more than noise leaves.
    """
    stack = frames.astype(np.float64)
    variance = float(stack.var(0, ddof=1).mean())
    if len(stack) < 3 or variance <= 0.0:
        return 0.0
    slow = 1.0 - float((np.diff(stack, axis=0) ** 2).mean()) / 2.0 / variance
    whole = float(stack.mean((1, 2)).var(ddof=1)) / variance - 1.0 / stack[0].size
    return max(slow, whole, 0.0) if max(slow, whole) > SCATTER_SDS / math.sqrt(stack.size) else 0.0


def photon_transfer(levels: Sequence[NoiseLevels]) -> PhotonTransfer:
    """Fit the photon transfer's line to the noise of one still scene, or of several under different light.

    Parameters
    ----------
    levels
        From `noise_levels`, one or more. Bins count by the precision of their variance: the root of their pixels over
        it.

    Returns
    -------
    PhotonTransfer
        The line.

    Raises
    ------
    CalibrationError
        All grey levels are alike: they span less than 10.

    References
    ----------
    EMVA 1288, Release 4.0.
    """
    mean = np.concatenate([level.mean for level in levels])
    variance = np.concatenate([level.variance for level in levels])
    pixels = np.concatenate([level.pixels for level in levels])
    if np.ptp(mean) < 10.0:
        raise CalibrationError(f"the still scene's grey levels must span 10 or more, got {np.ptp(mean):.1f}")
    slope, dark = np.polyfit(mean, variance, 1, w=np.sqrt(pixels) / np.maximum(variance, 1e-3))
    return PhotonTransfer(float(slope), math.sqrt(max(float(dark), 0.0)))


def fixed_pattern(frames: Images) -> float:
    """Measure the fixed pattern: how unequal the pixels are on an evenly lit patch, apart from temporal noise.

    Parameters
    ----------
    frames
        Of an evenly lit patch, (T, R, C). Shading up to the second order over the patch is taken off.

    Returns
    -------
    float
        Its sd in grey levels: the spatial variance of the mean frame less what temporal noise leaves in it. 0 where
        noise accounts for all of it. The simulated eye has none.

    Raises
    ------
    CalibrationError
        There is one frame alone, which does not tell the pattern from noise.

    References
    ----------
    EMVA 1288, Release 4.0: the correction of spatial variance for temporal noise.
    """
    if len(frames) < 2:
        raise CalibrationError(f"the fixed pattern takes 2 or more frames of the lit patch, got {len(frames)}")
    stack = frames.astype(np.float64)
    mean, temporal = stack.mean(0), float(stack.var(0, ddof=1).mean())
    y, x = (axis.ravel() / max(axis.max(), 1) for axis in np.indices(mean.shape))
    basis = np.stack([np.ones_like(x), x, y, x * y, x * x, y * y], axis=1)
    shading, *_ = np.linalg.lstsq(basis, mean.ravel(), rcond=None)
    left = mean.ravel() - basis @ shading
    spatial = float((left**2).sum()) / (left.size - basis.shape[1])
    return math.sqrt(max(spatial - temporal / len(frames), 0.0))


# Edges: the time between rows, and blur.


def edge_rows(luma: Images, empty: Floats) -> Whole:
    """Find the rows that a dark object crosses.

    Parameters
    ----------
    luma, empty
        The frame, and the scene without the object, (R, C).

    Returns
    -------
    ndarray
        The longest run of rows in which 3 pixels or more are dark, its upper and lower sixth left out: an object's
        rim is seen there, not its side.

    Raises
    ------
    CalibrationError
        There are fewer than `LEAST_ROWS`, or the object is at the left edge of the picture.
    """
    difference = empty - luma.astype(np.float64)
    dark = difference > 0.6 * max(float(difference.max()), 1.0)
    crossed = (dark.sum(1) >= 3) & ~dark[:, 0]
    ends = np.flatnonzero(np.diff(np.concatenate([[0], crossed.astype(np.int8), [0]])))
    begin, end = max(ends.reshape(-1, 2).tolist(), key=lambda run: run[1] - run[0], default=[0, 0])
    trim = max(2, (end - begin) // 6)
    rows = np.arange(begin + trim, end - trim)
    if len(rows) < LEAST_ROWS:
        raise CalibrationError(f"a lean takes {LEAST_ROWS} or more rows that a dark object crosses, got {len(rows)}")
    return rows


def edge_columns(luma: Images, empty: Floats, rows: Whole) -> Floats:
    """Find the column of a dark object's left edge in each row, below the pixel.

    Parameters
    ----------
    luma
        The frame, (R, C).
    empty
        The scene without the object, (R, C).
    rows
        The rows to look at, (N,): the object covers a part of each.

    Returns
    -------
    ndarray
        Columns, (N,): by the share of each pixel that is covered, left of the object's middle.

    Raises
    ------
    CalibrationError
        No pixel of the first row is covered.
    """
    light = luma.astype(np.float64)
    dark = light[int(rows[len(rows) // 2])].min()
    covered = np.clip((empty - light) / np.maximum(empty - dark, 1.0), 0.0, 1.0)[rows]
    inside = np.flatnonzero(covered[0] > 0.9)
    if not inside.size:
        raise CalibrationError("no dark object in the first of the rows: it has to cross them all")
    middle = int(np.median(inside))
    return np.asarray(middle - covered[:, :middle].sum(1))


def lean(columns: Floats, rows: Whole) -> float:
    """Measure how many columns an edge moves over from one row to the row below: the slope of the line through it.

    Parameters
    ----------
    columns
        Where the edge is in each row, px, (N,); from `edge_columns`.
    rows
        The rows, (N,), two or more.

    Returns
    -------
    float
        Columns a row.
    """
    return float(np.polyfit(rows, columns, 1)[0])


def row_time_us(leans: Sequence[float], speeds_px_s: Sequence[float]) -> float:
    """Return the time from a row's read-out to the next row's, from how a moving vertical edge leans.

    Parameters
    ----------
    leans
        Columns a row, of frames in which the edge moves.
    speeds_px_s
        The speed of the edge's image in these frames, rightward positive, px/s.

    Returns
    -------
    float
        Microseconds: the slope of lean against speed. Where the edge moves both ways, a lean that it has at rest
        too (of a tilted camera) is taken off; otherwise the line goes through 0.

    Raises
    ------
    CalibrationError
        The edge does not move.
    """
    lean_px, speed = np.asarray(leans, np.float64), np.asarray(speeds_px_s, np.float64)
    if not np.abs(speed).max(initial=0.0) > 0.0:
        raise CalibrationError("the edge does not move, so that its lean tells nothing")
    if speed.min() < 0.0 < speed.max():
        return 1e6 * float(np.polyfit(speed, lean_px, 1)[0])
    return 1e6 * float((lean_px * speed).sum() / (speed**2).sum())


def transfer(luma: Images, angle_deg: float = 5.0) -> tuple[Floats, Floats]:
    """Measure the modulation transfer at a slanted edge.

    Parameters
    ----------
    luma
        A frame (R, C) of an edge through its middle, dark on the left.
    angle_deg
        Of the edge to the columns.

    Returns
    -------
    tuple of ndarray
        Frequencies in cycles a pixel, and the transfer there: the spectrum of the derivative of the edge's profile,
        which is taken in quarters of a pixel.

    References
    ----------
    ISO 12233.
    """
    rows, columns = np.indices(luma.shape)
    tangent = math.tan(math.radians(angle_deg))
    across = columns - (luma.shape[1] / 2 + tangent * (rows - luma.shape[0] / 2))
    bins = np.floor(4.0 * across * math.cos(math.radians(angle_deg))).astype(int)
    used = (np.abs(bins) < 100) & (rows > 8) & (rows < luma.shape[0] - 8)
    count = np.bincount(bins[used] + 100)
    profile = np.bincount(bins[used] + 100, luma[used].astype(float))[1:] / count[1:]
    spread = np.diff(profile) * np.hanning(len(profile) - 1)
    frequency = np.asarray(np.fft.rfftfreq(len(spread), 0.25), np.float64)
    return frequency, np.abs(np.fft.rfft(spread)) / np.abs(spread.sum())


# Tone and falloff.


def gamma_points(grey: Floats, luma: Floats) -> Floats:
    """Read a gamma curve where its registers have it: ``gamma_points`` of `colias_sim.CameraConfig`.

    Parameters
    ----------
    grey
        Grey of each step of a chart before the curve, (N,): reflectance in proportion to the light, 255 where it
        saturates.
    luma
        Mean luma of each step, (N,), in grey levels.

    Returns
    -------
    ndarray
        GAM1 to GAM15, (15,), in grey levels, by lines between the steps. Without a curve they are its inputs.

    Raises
    ------
    CalibrationError
        The steps do not span the curve's inputs.
    """
    if grey.min() > GAMMA_INPUTS[0] or grey.max() < GAMMA_INPUTS[-1]:
        wanted = f"{GAMMA_INPUTS[0]} to {GAMMA_INPUTS[-1]}"
        raise CalibrationError(f"the chart's steps must span grey {wanted}, got {grey.min():.0f} to {grey.max():.0f}")
    order = np.argsort(grey)
    return np.interp(GAMMA_INPUTS, grey[order], luma[order])


def contrast_and_brightness(grey: Floats, luma: Floats, center: float = CONTRAS_CENTER_RESET) -> tuple[float, float]:
    """Fit contrast and brightness to a chart of grey steps.

    Parameters
    ----------
    grey
        Grey of each step before contrast and brightness, (N,): the chart's luma with both registers as after a reset.
    luma
        Mean luma of each step with the registers in question, (N,).
    center
        The camera's ``contrast_center``, in grey levels. The chart alone does not tell it from brightness.

    Returns
    -------
    contrast : float
        ``contrast`` of `colias_sim.CameraConfig`, register CONTRAS: 64 times the slope of luma against grey.
    brightness : float
        ``brightness`` of `colias_sim.CameraConfig`, register BRIGHT with its sign, in grey levels.

    Raises
    ------
    CalibrationError
        Fewer than 3 steps are not clipped.
    """
    inside = (luma > MARGIN) & (luma < 255.0 - MARGIN) & (grey > MARGIN) & (grey < 255.0 - MARGIN)
    if inside.sum() < 3:
        raise CalibrationError(f"3 or more steps of the chart must not be clipped at 0 or 255, got {inside.sum()}")
    slope, offset = np.polyfit(grey[inside], luma[inside], 1)
    return UNIT_CONTRAS * float(slope), float(offset) - center * (1.0 - float(slope))


def falloff_exponent(flat: Images, focal_px: float) -> float:
    """Measure a lens's falloff: ``vignetting`` of `colias_sim.CameraConfig`.

    Parameters
    ----------
    flat
        Frames of an evenly bright field that fills the view, (T, R, C), without gamma curve.
    focal_px
        Focal length, px.

    Returns
    -------
    float
        The power of the cosine of the angle to the axis by which the light falls: 4 is natural falloff, 0 none.

    Raises
    ------
    CalibrationError
        A pixel is clipped in all frames.
    """
    mean = flat.mean(0, dtype=np.float64)
    if mean.min() <= 0.0 or mean.max() >= 255.0:
        raise CalibrationError("the even field is clipped at 0 or 255: take it with other light")
    y, x = (axis - (size - 1) / 2 for axis, size in zip(np.indices(mean.shape), mean.shape, strict=True))
    cosine = 1.0 / np.hypot(1.0, np.hypot(x, y) / focal_px)
    return float(np.polyfit(np.log(cosine).ravel(), np.log(mean).ravel(), 1)[0])


# The loop that controls the exposure time.


@dataclass(frozen=True, slots=True)
class ExposureLoop:
    """Properties of the loop that controls the exposure time, from pictures that settle.

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
    CalibrationError
        No sequence changes and comes to rest, or the steps cannot be told apart.
    """
    settled = [changes for changes in map(_changes, sequences) if changes]
    if not settled:
        raise CalibrationError("no sequence of frames settles: the mean grey should change, and then rest for 2 frames")
    jumps = [jump for changes in settled for jump, _ in changes]
    fits = (_fit(jumps, steps) for steps in range(1, MOST_STEPS + 1))
    fit = next((fit for fit in fits if fit is not None), None)  # the fewest steps of which all are whole multiples
    if fit is None:
        raise CalibrationError("the exposure changes by no whole multiples of a step: does the light stay the same?")
    step, steps = fit
    low, high = _end_of_zone(settled, 1.0 + step), _end_of_zone(settled, 1.0 - step)
    return ExposureLoop(step, steps, low, high, _is_certain(settled, jumps, steps))


_Changes = list[tuple[float, float]]
"""Of a sequence that comes to rest: the logarithm of each change of the mean, and the mean before it."""


def _changes(frames: Images) -> _Changes:
    """List the changes of a sequence; none where it does not come to rest."""
    means = frames.astype(np.float64).mean((1, 2))
    clipped = [float(np.isin(frame, (0, 255)).mean()) for frame in frames]
    if len(means) < 3 or np.ptp(means[-3:]) > REST * means[-1] or clipped[-1] > SATURATED:
        return []
    return [
        (math.log(after / before), float(before))
        for (before, after), shares in zip(pairwise(means), pairwise(clipped), strict=True)
        if abs(after / max(before, 1e-9) - 1.0) > REST and max(shares) <= SATURATED
    ]


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
    return (share, int(counts.max())) if np.all(off <= OFF_WHOLE + OFF_SHARE * counts) else None


def _end_of_zone(settled: Sequence[_Changes], factor: float) -> tuple[float, float] | None:
    """Return the interval of an end of the zone: what the intervals of all sequences from that side have in common.

    The loop may have computed from the picture before its last change or from the one before that, as its response to a
    picture comes a frame or two later. Rounding makes them differ by some tenths of a grey level. Where noise leaves
    nothing in common, the interval is what lies between.
    """
    side = [changes for changes in settled if (changes[-1][0] > 0) == (factor > 1.0)]
    side = [changes for changes in side if len(changes) == 1] or side  # there the picture is known
    lows, highs = [], []
    for changes in side:
        counts = [round(jump / math.log(factor)) for jump, _ in changes[-2:]]
        pictures = [(changes[-1][1], counts[-1])]
        if len(counts) > 1 and counts[0] > 0:
            pictures.append((changes[-2][1], sum(counts)))
        outside = [mean * factor ** (count - 1) for mean, count in pictures]
        within = [mean * factor**count for mean, count in pictures]
        ends = (min(outside), max(within)) if factor > 1.0 else (min(within), max(outside))
        lows.append(ends[0] * (1.0 - ROUNDING))
        highs.append(ends[1] * (1.0 + ROUNDING))
    return (min(max(lows), min(highs)), max(max(lows), min(highs))) if side else None


def _is_certain(settled: Sequence[_Changes], jumps: Sequence[float], steps: int) -> bool:
    """Tell whether no other step fits the changes, and the one that does would hardly fit changes of any size.

    A change of any size fits by chance with twice the tolerance. Changes of one size tell no more than one of them:
    they come of equal light, or of a loop at its most steps. But the last of several in a sequence could have been of
    any size.
    """
    if any(_fit(jumps, other) for other in range(steps + 1, MOST_OTHER + 1) if other % steps):
        return False
    largest = max(jumps, key=abs)

    def counted(jump: float) -> tuple[bool, int]:
        return jump > 0, max(round(abs(jump / largest) * steps), 1)

    last = [counted(changes[-1][0]) for changes in settled if len(changes) > 1]
    telling = [*last, *({counted(jump) for jump in jumps} - {*last})]
    telling.remove(counted(largest))  # fits whatever the step is
    shares = [2.0 * (OFF_WHOLE + OFF_SHARE * count) for _, count in telling]
    return steps * math.prod(shares) <= MOST_CHANCE
