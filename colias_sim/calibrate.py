"""Calibrate a simulated or a real camera from its frames: noise, edges and exposure.

Each function takes frames of any camera, (T, R, C) or (R, C), and needs no simulator. Its results are settings of
`colias_sim.CameraConfig`. The tests check that it recovers the simulated camera's own settings.

References
----------
EMVA 1288, Release 4.0: photon transfer.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

__all__ = [
    "CalibrationError", "control_zone", "edge_columns", "edge_rows", "exposure", "exposure_loop", "lean", "leaning",
    "noise", "noise_levels", "photon_transfer", "row_time", "row_time_us", "unsteadiness",
]  # fmt: skip

Floats = npt.NDArray[np.float64]
Images = npt.NDArray[np.uint8]
Whole = npt.NDArray[np.int64]
Interval = tuple[float, float]
"""Least and largest mean grey of an end of the control zone."""
Measured = tuple[dict[str, object], list[str]]
"""Parameters of the camera, as ``--set camera.NAME=VALUE`` takes them, and what is doubtful."""
LEAST_SHARE = 0.03
"""Share of the variance over time from which a scene was not still."""
NoiseLevels = tuple[Floats, Floats, Whole]
"""Mean grey, its variance over time and the number of pixels of each bin of pixels, (N,) each."""

QUANTISATION = 1.0 / 12.0
"""Variance of rounding to whole grey levels."""
CLIP_SDS = 4.0
"""A pixel counts if its mean is this many sd away from 0 and from 255, because clipping reduces noise."""
SCATTER_SDS = 4.0
"""Bound on the scatter of `unsteadiness` for pure noise, in units of one over the root of the number of values."""
BAD_SDS = 8.0
"""A pixel is bad if its variance is this many sd of an estimate from T frames above that of pixels of similar grey."""
MOST_BAD = 0.005
"""Share of bad pixels up to which they are the camera's. More are something that moves."""
LEAST_PIXELS = 30
"""Minimum number of pixels in a bin of grey levels."""
LEAST_ROWS = 8
"""Minimum number of rows to measure the lean of an edge."""
SATURATED = 0.005
"""Share of clipped pixels from which on a picture's mean is no longer proportional to its exposure."""
REST = 0.002
"""Largest relative change of a picture's mean while the exposure rests."""
ROUNDING = 0.001
"""Relative error that rounding to whole grey levels causes in a mean that is computed from another."""
MOST_STEPS = 100
"""Largest number of exposure steps in a frame that is tried."""
OFF_WHOLE, OFF_SHARE = 0.05, 0.01
"""Tolerance for a change of n steps, in steps: 0.05 + 0.01 n, because of rounding."""
MOST_CHANCE = 0.01
"""A step is certain if the expected number of steps that fit by chance is at most this."""
MOST_OTHER = 20
"""Largest number of steps in a frame of an alternative fit; finer steps fit anything."""


class CalibrationError(ValueError):
    """The frames do not allow the measurement. The message states what they lack."""


# Noise.


def noise_levels(frames: Images, bins: int = 16) -> NoiseLevels:
    """Measure temporal noise by grey level.

    Changes of light by frame, by row or by column are taken off first, and bad pixels do not count.

    Parameters
    ----------
    frames
        Frames of a still scene, (T, R, C), with T of at least 8. The scene should have many grey levels, or be combined
        with others in `photon_transfer`.
    bins
        Number of bins of pixels of similar grey.

    Returns
    -------
    tuple of ndarray
        Mean (grey levels), variance (their squares, without the variance of rounding) and number of pixels of each bin
        with enough pixels, (N,) each.

    Raises
    ------
    CalibrationError
        There are too few frames, or every pixel is clipped.
    """
    if len(frames) < 8:
        raise CalibrationError(f"noise takes 8 or more frames of the still scene (60 are good), got {len(frames)}")
    stack = frames.astype(np.float64)
    whole = ((stack.min(0) > 0.0) & (stack.max(0) < 255.0)).ravel()  # clipping hides noise
    stack = _without_flicker(stack)
    mean, variance = stack.mean(0).ravel(), stack.var(0, ddof=1).ravel()
    spread = np.sqrt(np.median(variance[whole])) if whole.any() else np.inf
    inside = (mean > CLIP_SDS * spread) & (mean < 255.0 - CLIP_SDS * spread) & ~_bad_pixels(stack).ravel()
    if inside.sum() < LEAST_PIXELS:
        raise CalibrationError("the still scene is clipped at 0 or 255: take it with other light")
    mean, variance = mean[inside], variance[inside]
    low, high = np.quantile(mean, (MOST_BAD, 1.0 - MOST_BAD))  # no single pixel sets the width of the bins
    edges = np.linspace(low, high + 1e-9, bins + 1)
    place = np.digitize(mean, edges) - 1
    used = [place == index for index in range(bins) if (place == index).sum() >= LEAST_PIXELS]
    return (
        np.array([mean[bin_].mean() for bin_ in used]),
        np.array([variance[bin_].mean() for bin_ in used]) - QUANTISATION,
        np.array([bin_.sum() for bin_ in used], np.int64),
    )


def _bad_pixels(stack: Floats) -> npt.NDArray[np.bool_]:
    """Find pixels that vary over time far more than others of similar grey, (R, C), such as ones that blink."""
    mean, variance = stack.mean(0).ravel(), stack.var(0, ddof=1).ravel()
    bad = np.zeros(mean.size, np.bool_)
    for similar in np.array_split(mean.argsort(), 16):
        usual = max(float(np.median(variance[similar])), 3 * QUANTISATION)
        bad[similar] = variance[similar] > usual * (1.0 + BAD_SDS * math.sqrt(2 / (len(stack) - 1)))
    return bad.reshape(stack.shape[1:])


def _without_flicker(stack: Floats) -> Floats:
    """Take off each frame's change of light, by row or by column, whichever change more; keep the pixels' variance.

    Lamps on the mains flicker at twice its frequency. A rolling shutter turns this into stripes.
    """
    mean = stack.mean(0, keepdims=True)
    axis = max((2, 1), key=lambda axis: stack.shape[axis] * float(stack.mean(axis).var(0).mean()))
    weight = np.where(_bad_pixels(stack), 0.0, mean)
    whole = np.maximum((weight * mean).sum(axis, keepdims=True), 1e-9)
    change = ((stack - mean) * weight).sum(axis, keepdims=True) / whole
    of_fit = np.minimum(weight * mean / whole, 0.5)  # share of a pixel's variance that the fit takes off
    return np.asarray(mean + (stack - mean * (1.0 + change)) / np.sqrt(1.0 - of_fit))


def unsteadiness(frames: Images) -> float:
    """Measure the share of temporal variance that is not pixel noise, to detect a scene that was not still.

    Parameters
    ----------
    frames
        Frames of a scene that should be still under constant light, (T, R, C), with T of 3 or more.

    Returns
    -------
    float
        A share of the variance, 0 to 1. It is the largest of these: slow change, where distant frames differ more than
        neighbours (von Neumann), and change of the mean of the whole picture, of its rows and of its columns. The
        stripes of lamps that flicker are in its rows. It is 0 if noise explains all. A few bad pixels do not count.
    """
    stack = frames.astype(np.float64)
    if len(stack) < 3:
        return 0.0
    stack = np.where((bad := _bad_pixels(stack)) & (bad.mean() < MOST_BAD), stack.mean(0), stack)
    variance = float(stack.var(0, ddof=1).mean())
    if variance <= 0.0:
        return 0.0
    slow = 1.0 - float((np.diff(stack, axis=0) ** 2).mean()) / 2.0 / variance
    parts = stack.mean((1, 2)), stack.mean(2), stack.mean(1)
    shares = [float(part.var(0, ddof=1).mean()) / variance - part[0].size / stack[0].size for part in parts]
    share = max(slow, *shares)
    return max(share, 0.0) if share > SCATTER_SDS / math.sqrt(stack.size) else 0.0


def photon_transfer(levels: Sequence[NoiseLevels], gain: float = 1.0) -> tuple[float, float]:
    """Measure shot and read noise, by a line through the noise of one still scene, or of several under different light.

    The line of the photon transfer is ``variance = gain shot_noise^2 / 255 mean + (gain read_noise)^2``.

    Parameters
    ----------
    levels
        Results of `noise_levels`, one or more. Bins are weighted by the precision of their variance.
    gain
        The camera's gain.

    Returns
    -------
    shot_noise, read_noise : float
        Settings of `colias_sim.CameraConfig`.

    Raises
    ------
    CalibrationError
        The grey levels span less than 10.

    References
    ----------
    EMVA 1288, Release 4.0.

    Examples
    --------
    >>> import numpy as np
    >>> from colias_sim.calibrate import noise_levels, photon_transfer
    >>> light = np.linspace(40.0, 200.0, 72 * 99).reshape(72, 99)
    >>> noise = np.random.default_rng(0).normal(size=(60, 72, 99)) * np.sqrt(0.4 + 0.006 * light)
    >>> shot_noise, read_noise = photon_transfer([noise_levels(np.rint(light + noise).astype(np.uint8))])
    >>> round(shot_noise**2 / 255, 3)
    0.006
    """
    mean, variance, pixels = (np.concatenate(parts) for parts in zip(*levels, strict=True))
    if np.ptp(mean) < 10.0:
        raise CalibrationError(f"the still scene's grey levels must span 10 or more, got {np.ptp(mean):.1f}")
    slope, dark = np.polyfit(mean, variance, 1, w=np.sqrt(pixels) / np.maximum(variance, 1e-3))
    return math.sqrt(max(float(slope), 0.0) * 255.0 / gain), math.sqrt(max(float(dark), 0.0)) / gain


# Edges: the time between rows.


def edge_rows(luma: Images, empty: Floats) -> Whole:
    """Find the rows that a dark object crosses.

    Parameters
    ----------
    luma, empty
        The frame, and the scene without the object, (R, C).

    Returns
    -------
    ndarray
        The longest run of rows with 3 dark pixels or more, without its upper and lower sixth, where the object's rim is
        visible instead of its side.

    Raises
    ------
    CalibrationError
        There are fewer than `LEAST_ROWS` rows, or the object is at the left edge of the picture.
    """
    difference = empty - luma.astype(np.float64)
    dark = difference > 0.6 * max(float(np.sort(difference)[:, -3].max()), 1.0)  # of a row's third, as one may be bad
    crossed = (dark.sum(1) >= 3) & ~dark[:, 0]
    ends = np.flatnonzero(np.diff(np.concatenate([[0], crossed.astype(np.int8), [0]])))
    begin, end = max(ends.reshape(-1, 2).tolist(), key=lambda run: run[1] - run[0], default=[0, 0])
    trim = max(2, (end - begin) // 6)
    rows = np.arange(begin + trim, end - trim)
    if len(rows) < LEAST_ROWS:
        raise CalibrationError(f"a lean takes {LEAST_ROWS} or more rows that a dark object crosses, got {len(rows)}")
    return rows


def edge_columns(luma: Images, empty: Floats, rows: Whole) -> Floats:
    """Find the column of a dark object's left edge in each row, with subpixel precision.

    Parameters
    ----------
    luma
        The frame, (R, C).
    empty
        The scene without the object, (R, C).
    rows
        The rows to use, (N,). The object covers a part of each.

    Returns
    -------
    ndarray
        Columns, (N,), from the covered share of each pixel left of the object's middle.

    Raises
    ------
    CalibrationError
        No pixel of the first row is covered.
    """
    light = luma.astype(np.float64)
    dark = np.sort(light[int(rows[len(rows) // 2])])[2]  # one pixel may be bad
    covered = np.clip((empty - light) / np.maximum(empty - dark, 1.0), 0.0, 1.0)[rows]
    inside = np.flatnonzero(covered[0] > 0.9)
    if not inside.size:
        raise CalibrationError("no dark object in the first of the rows: it must cross them all")
    middle = int(np.median(inside))
    return np.asarray(middle - covered[:, :middle].sum(1))


def lean(columns: Floats, rows: Whole) -> float:
    """Measure the lean of an edge: the columns that it shifts from one row to the next, by a linear fit.

    Parameters
    ----------
    columns
        Column of the edge in each row, px, (N,), from `edge_columns`.
    rows
        The rows, (N,), two or more.

    Returns
    -------
    float
        Columns per row.

    Examples
    --------
    >>> import numpy as np
    >>> from colias_sim.calibrate import lean
    >>> rows = np.arange(20, 40)
    >>> round(lean(50.0 + 0.1 * rows, rows), 3)
    0.1
    """
    return float(np.polyfit(rows, columns, 1)[0])


def row_time_us(leans: Sequence[float], speeds_px_s: Sequence[float]) -> float:
    """Compute the time between the read-outs of two rows from the lean of a moving vertical edge.

    Parameters
    ----------
    leans
        Columns per row, for frames in which the edge moves.
    speeds_px_s
        The speed of the edge's image in these frames, rightward positive, px/s.

    Returns
    -------
    float
        Microseconds: the slope of lean against speed. If the edge moves both ways, the lean at rest (of a tilted
        camera) is subtracted; otherwise the line passes through 0.

    Raises
    ------
    CalibrationError
        The edge does not move.

    Examples
    --------
    >>> from colias_sim.calibrate import row_time_us
    >>> round(row_time_us([0.04, -0.04], [100.0, -100.0]))
    400
    """
    lean_px, speed = np.asarray(leans, np.float64), np.asarray(speeds_px_s, np.float64)
    if not np.abs(speed).max(initial=0.0) > 0.0:
        raise CalibrationError("the edge must move to measure the row time")
    if speed.min() < 0.0 < speed.max():
        return 1e6 * float(np.polyfit(speed, lean_px, 1)[0])
    return 1e6 * float((lean_px * speed).sum() / (speed**2).sum())


# The loop that controls the exposure time.


def exposure_loop(sequences: Sequence[Images]) -> tuple[float, int, bool]:
    """Measure the steps of the loop that controls the exposure, from pictures of still scenes on which it settles.

    Between two frames the loop changes the exposure by whole steps, and so the mean of the picture.

    Parameters
    ----------
    sequences
        Frames, each (T, R, C), from any moment after a change of light until the picture rests, under constant light.

    Returns
    -------
    step : float
        One step of the exposure, as a share of the exposure: ``ae_step`` of `colias_sim.CameraConfig`.
    steps : int
        The largest number of steps observed in a frame: ``ae_steps``.
    certain : bool
        Whether the changes determine the step: no other step fits, and a chance fit is unlikely. Otherwise step and
        zone may be wrong, and more sequences are needed.

    Raises
    ------
    CalibrationError
        No sequence changes and comes to rest, or no step fits.
    """
    settled = _settled(sequences)
    if not settled:
        raise CalibrationError("no sequence of frames settles: the mean grey should change, and then rest for 2 frames")
    jumps = [jump for changes in settled for jump, _ in changes]
    fits = (_fit(jumps, steps) for steps in range(1, MOST_STEPS + 1))
    fit = next((fit for fit in fits if fit is not None), None)  # the fewest steps of which all are whole multiples
    if fit is None:
        raise CalibrationError("the exposure changes by no whole multiples of a step: does the light stay the same?")
    step, steps = fit
    return step, steps, _is_certain(settled, jumps, steps)


def control_zone(sequences: Sequence[Images], step: float) -> tuple[Interval | None, Interval | None]:
    """Measure the zone of mean grey in which the loop leaves the exposure as it is: its dead band.

    The loop ends as soon as the mean is in its zone: a step earlier the mean was still outside. So each sequence gives
    an interval for one end of the zone, and several sequences narrow it. The middle of the zone is ``ae_target`` of
    `colias_sim.CameraConfig`, and half its width ``ae_zone``.

    Parameters
    ----------
    sequences
        Frames, as in `exposure_loop`.
    step
        The step that `exposure_loop` found.

    Returns
    -------
    low, high : tuple of float or None
        Least and largest mean grey of the zone's two ends; ``None`` if no sequence came from below, or from above.
    """
    settled = _settled(sequences)
    return _end_of_zone(settled, 1.0 + step), _end_of_zone(settled, 1.0 - step)


_Changes = list[tuple[float, float]]
"""Changes of a sequence that comes to rest: the logarithm of each change of the mean, and the mean before it."""


def _settled(sequences: Sequence[Images]) -> list[_Changes]:
    """List the changes of each sequence that comes to rest."""
    return [changes for changes in map(_changes, sequences) if changes]


def _changes(frames: Images) -> _Changes:
    """List the changes of a sequence; empty if it does not come to rest."""
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
    """Find the step, as a share, if the largest jump has ``steps``, and the most steps; ``None`` if other jumps misfit.

    The logarithm of a step s is log(1 + s) upward, and -log(1 - s) downward.
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
    """Compute the interval of an end of the zone: the intersection over all sequences from that side.

    The loop responds to a picture one or two frames later. So it may have used the picture before its last change or
    the one before that. With rounding these differ by some tenths of a grey level. If noise leaves no intersection, the
    result is the gap between the intervals.
    """
    side = [changes for changes in settled if (changes[-1][0] > 0) == (factor > 1.0)]
    side = [changes for changes in side if len(changes) == 1] or side  # then the picture that the loop used is known
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
    """Check that no other step fits the changes, and that the found step is unlikely to fit by chance.

    A random change fits with a probability of twice the tolerance. Changes of one size count once: they come from equal
    light, or from a loop at its largest number of steps. But the last of several changes in a sequence could have any
    size.
    """
    if any(_fit(jumps, other) for other in range(steps + 1, MOST_OTHER + 1) if other % steps):
        return False
    largest = max(jumps, key=abs)

    def counted(jump: float) -> tuple[bool, int]:
        return jump > 0, max(round(abs(jump / largest) * steps), 1)

    last = [counted(changes[-1][0]) for changes in settled if len(changes) > 1]
    telling = [*last, *({counted(jump) for jump in jumps} - {*last})]
    telling.remove(counted(largest))  # it fits any step
    shares = [2.0 * (OFF_WHOLE + OFF_SHARE * count) for _, count in telling]
    return steps * math.prod(shares) <= MOST_CHANCE


def noise(films: Sequence[Images], gain: float) -> Measured:
    """Measure a camera's noise.

    Parameters
    ----------
    films
        Frames (T, R, C) of still scenes of many greys under constant light.
    gain
        The camera's gain, as ``camera.gain`` has it: noise before it is what the settings hold.

    Returns
    -------
    dict
        Parameter of the camera -> value.
    list of str
        What is doubtful about it.
    """
    shot_noise, read_noise = photon_transfer([noise_levels(frames) for frames in films], gain)
    share = max(map(unsteadiness, films))
    doubt = f"greys drift or flicker, {share:.0%} of their variance: light is corrected, but not what moves"
    values = {"shot_noise": f"{shot_noise:.3f}", "read_noise": f"{read_noise:.3f}"}
    return {"gain": f"{gain:g}", **values}, [doubt] if share >= LEAST_SHARE else []


def row_time(films: Sequence[Images], fps: float) -> Measured:
    """Measure the time from row to row, as `noise` measures noise.

    Parameters
    ----------
    films
        Frames (T, R, C): first the empty scene, then a dark upright object that crosses the view.
    fps
        Frames per second.

    Raises
    ------
    CalibrationError
        No two frames one after the other show the object whole.
    """
    pairs = [pair for frames in films for pair in leaning(frames, fps)]
    if not pairs:
        raise CalibrationError("no two frames one after the other show the object whole")
    leans, speeds = zip(*pairs, strict=True)
    measured = row_time_us(leans, speeds)
    doubt = f"measured {measured:.0f} us a row: rows that are read from the top down cannot lean so; 0 is taken"
    return {"row_time_us": f"{max(measured, 0.0):.0f}"}, [doubt] if measured < 0.0 else []


def leaning(frames: Images, fps: float) -> Iterator[tuple[float, float]]:
    """Yield the lean of a moving object's left edge, px a row, and its speed, px/s, of each frame that shows both.

    Parameters
    ----------
    frames
        (T, R, C): the first is the scene without the object.
    fps
        Frames per second.
    """
    empty, placed = frames[0].astype(np.float64), {}
    for number, frame in enumerate(frames[1:], start=1):
        try:
            rows = edge_rows(frame, empty)
            placed[number] = rows, edge_columns(frame, empty, rows)
        except CalibrationError:
            continue
    for one, other in pairwise(sorted(placed)):
        (rows, columns), (own_rows, own_columns) = placed[one], placed[other]
        both = np.intersect1d(rows, own_rows)
        if other == one + 1 and len(both) >= len(own_rows) // 2:
            moved = own_columns[np.isin(own_rows, both)] - columns[np.isin(rows, both)]
            yield lean(own_columns, own_rows), float(moved.mean()) * fps


def exposure(films: Sequence[Images]) -> Measured:
    """Measure the exposure loop, as `noise` measures noise, from films after the light has changed, until they rest."""
    step, steps, certain = exposure_loop(films)
    if not certain:
        return {}, [f"the exposure's step is uncertain (folders: {len(films)}); take more, from brighter and darker"]
    settings: dict[str, object] = {"auto_exposure": "true", "ae_step": f"{step:.4f}", "ae_steps": steps}
    low, high = control_zone(films, step)
    if low is not None and high is not None:
        target, zone = (sum(low) + sum(high)) / 4, (sum(high) - sum(low)) / 4
        settings |= {"ae_target": f"{target:.1f}", "ae_zone": f"{zone:.1f}"}
    return settings, []
