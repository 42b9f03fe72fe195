"""Moving edges, whose lean tells the time between rows, and slanted ones (ISO 12233)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from colias_sim.metrology.errors import MetrologyError

Floats = npt.NDArray[np.float64]
Images = npt.NDArray[np.uint8]
Whole = npt.NDArray[np.int64]


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
    MetrologyError
        No pixel of the first row is covered.
    """
    light = luma.astype(np.float64)
    dark = light[int(rows[len(rows) // 2])].min()
    covered = np.clip((empty - light) / np.maximum(empty - dark, 1.0), 0.0, 1.0)[rows]
    inside = np.flatnonzero(covered[0] > 0.9)
    if not inside.size:
        raise MetrologyError("no dark object in the first of the rows: it has to cross them all")
    middle = int(np.median(inside))
    return np.asarray(middle - covered[:, :middle].sum(1))


def edge_rows(luma: Images, empty: Floats, least: int = 8) -> Whole:
    """Find the rows that a dark object crosses.

    Parameters
    ----------
    luma, empty
        The frame, and the scene without the object, (R, C).
    least
        Number of rows that a lean takes.

    Returns
    -------
    ndarray
        The longest run of rows in which 3 pixels or more are dark, its upper and lower sixth left out: an object's
        rim is seen there, not its side.

    Raises
    ------
    MetrologyError
        There are fewer than ``least``, or the object is at the left edge of the picture.
    """
    light = luma.astype(np.float64)
    difference = empty - light
    dark = difference > 0.6 * max(float(difference.max()), 1.0)
    crossed = (dark.sum(1) >= 3) & ~dark[:, 0]
    ends = np.flatnonzero(np.diff(np.concatenate([[0], crossed.astype(np.int8), [0]])))
    runs = ends.reshape(-1, 2)
    longest = max(runs.tolist(), key=lambda run: run[1] - run[0], default=[0, 0])
    trim = max(2, (longest[1] - longest[0]) // 6)
    rows = np.arange(longest[0] + trim, longest[1] - trim)
    if len(rows) < least:
        raise MetrologyError(f"a dark object crosses {len(rows)} rows: a lean takes {least} or more")
    return rows


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
    MetrologyError
        The edge does not move.
    """
    lean_px, speed = np.asarray(leans, np.float64), np.asarray(speeds_px_s, np.float64)
    if not np.abs(speed).max(initial=0.0) > 0.0:
        raise MetrologyError("the edge does not move: its lean tells nothing")
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
