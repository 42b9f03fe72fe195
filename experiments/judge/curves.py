"""Tuning curves: the response to a clip, and what a curve of responses prefers, unless that is within the noise.

The response is steady: of the second half of the frames in which something moves.

- A direction model's is its mean (hs, vs) projected on the direction of the motion, in the model's own unit; negative
  if it responds the other way.
- A looming detector's is its largest potential above the rest of 0.5.

References
----------
Mazurek, Kager and Van Hooser 2014: direction selectivity. Priebe, Cassanello and Lisberger 2003: the slope of preferred
temporal frequency. von Neumann 1941, Annals of Mathematical Statistics 12: the ratio of the mean square successive
difference to the variance. Fisher 1993, Statistical Analysis of Circular Data, 4.4: intervals of a mean direction.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import polars as pl

from dsnn.looming.layers import REST
from experiments.base.streams import stream
from experiments.judge.tests import LEVEL, PERMUTATIONS, SEED, Floats, first_alarm_s

Values = Sequence[float] | pl.Series | Floats

NOTHING = 1e-6
"""A response up to here is rounding."""
PLATEAU = 0.99
"""Share of the largest response from which responses count as equally large."""
ROW_FLOOR = 0.1
"""Share of a map's largest response below which a column prefers nothing."""
SOME_DSI = 0.05
"""The least DSI with which there is a preferred direction to report."""
LEAST_POINTS = 5
"""Of four points one order in twelve is as smooth as a slope."""


def points_schema(axes: Iterable[str]) -> dict[str, Any]:
    """Return the columns of a table of points: a row has a model's `response` to one clip, a point of a curve's line.

    ``x`` and ``y`` are along the curve's axes, and again in the columns of ``axes``, which say what they are.
    ``repeat`` counts clips at the same point that differ in their seed.
    """
    numbers = ("x", "y", *axes, "direction_deg", "response", "hs", "vs", "looming")
    columns = {**dict.fromkeys(("curve", "line", "model"), pl.String), **dict.fromkeys(numbers, pl.Float64)}
    return {**columns, "spikes": pl.Int64, "contact_s": pl.Float64, "repeat": pl.Int64}


def directional(channels: Sequence[str]) -> bool:
    """Tell whether a model with these output channels responds to directions; otherwise it is a looming detector."""
    return "hs" in channels or "vs" in channels


def response(
    series: Mapping[str, Any], moving: npt.NDArray[np.int64], direction_deg: float, channels: Sequence[str],
    *, approach: bool = False, contact_s: Floats | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Return a model's response to a clip.

    Parameters
    ----------
    series
        Its potentials ``hs``, ``vs``, ``looming``, and ``looming_spikes``, each (T,).
    moving
        The frames in which something moves.
    direction_deg
        Direction of the motion: 0 rightward, 90 downward.
    channels
        The model's output channels.
    approach
        Whether the response is that of looming, whatever other channels the model has.
    contact_s
        Time to contact by frame, (T,), s.

    Returns
    -------
    dict
        Columns of `points_schema`; ``contact_s`` is the time to contact at the first spike.
    """
    steady = moving[len(moving) // 2 :]
    hs, vs = (float(series[name][steady].mean()) for name in ("hs", "vs"))
    looming = float(series["looming"][moving].max()) - REST if "looming" in channels else 0.0
    turn = math.radians(direction_deg)
    projected = hs * math.cos(turn) + vs * math.sin(turn)
    return {
        "response": projected if directional(channels) and not approach else looming,
        "hs": hs, "vs": vs, "looming": max(looming, 0.0), "spikes": int(series["looming_spikes"].sum()),
        "contact_s": None if contact_s is None else first_alarm_s(series["looming_spikes"], contact_s),
    }  # fmt: skip


def line(points: pl.DataFrame, curve: str, line: str | None = None, repeat: int = 0) -> pl.DataFrame:
    """Return the points of a line of a curve, of all its lines for ``None``, by rising x."""
    own = points.filter(pl.col("curve") == curve, pl.col("repeat") == repeat)
    return (own if line is None else own.filter(pl.col("line") == line)).sort("x")


def grid(points: pl.DataFrame) -> tuple[Floats, Floats, Floats]:
    """Return x (n,), y (m,) and responses (m, n) of a map's points; NaN where a point is missing."""
    x, y = (points[name].unique().sort().to_numpy() for name in ("x", "y"))
    responses = np.full((len(y), len(x)), np.nan)
    responses[np.searchsorted(y, points["y"]), np.searchsorted(x, points["x"])] = points["response"]
    return x, y, responses


def preferred(x: Values, responses: Values) -> tuple[float, float] | None:
    """Return the ends of the range in which a response is within 1 % of the largest; ``None`` if none is above 0."""
    x, responses = np.asarray(x, float), np.asarray(responses, float)
    largest = responses.max(initial=0.0)
    if not largest > NOTHING:
        return None
    among = x[responses >= PLATEAU * largest]
    return float(among.min()), float(among.max())


def inside(x: Values, best: tuple[float, float]) -> bool:
    """Tell whether a preferred range reaches neither end of x: beyond an end, the response may be larger."""
    return bool(min(x) < best[0] and best[1] < max(x))


def range_text(x: Values, best: tuple[float, float]) -> str:
    """Return a preferred range in a few signs: ``120``, ``60..120``, ``≥340`` up to the end, ``flat``."""
    low, high = best
    if low == min(x) and high == max(x):
        return "flat"
    if not inside(x, best):
        return f"≥{low:.3g}" if high == max(x) else f"≤{high:.3g}"
    return f"{low:.3g}" if low == high else f"{low:.3g}..{high:.3g}"


def half_contrast(x: Values, responses: Values) -> float | None:
    """Return the contrast of half the largest response, between points on a log axis; ``None`` if below the first."""
    x, responses = np.log(np.asarray(x, float)), np.asarray(responses, float)
    half = responses.max(initial=0.0) / 2
    above = int(np.argmax(responses >= half)) if 2 * half > NOTHING else 0
    between = slice(above - 1, above + 1)
    return float(np.exp(np.interp(half, responses[between], x[between]))) if above else None


def best_rows(y: Values, responses: Floats) -> Floats:
    """Return the y that each column of a map (len(y), n) prefers: on a log axis, the middle of its preferred range.

    NaN where a column responds too little, its range reaches an end of y, or it is level over an octave.
    """
    columns = np.nan_to_num(responses, nan=-math.inf).T
    floor = max(ROW_FLOOR * float(columns.max(initial=0.0)), NOTHING)
    ranges = [preferred(y, column) if column.max() >= floor else None for column in columns]
    clear = [best if best and inside(y, best) and best[1] <= 2 * best[0] else (math.nan, math.nan) for best in ranges]
    return np.array([math.sqrt(low * high) for low, high in clear])


def speed_slope(x: Values, best: Floats) -> float | None:
    """Return the slope of log preferred temporal frequency over log spatial frequency; ``None`` of fewer than three.

    It is 0 where the temporal frequency decides, as in a Reichardt detector, and 1 where the speed does.
    """
    known = ~np.isnan(best)
    return float(np.polyfit(np.log(x)[known], np.log(best[known]), 1)[0]) if known.sum() > 2 else None


def selectivity(direction_deg: Values, responses: Values) -> tuple[float, float] | None:
    """Return the direction selectivity index ``|sum r exp(ia)| / sum r`` and the preferred direction, degrees.

    The directions a are evenly spaced; r is rectified, or the sum could vanish. The index is 1 for a response to one
    direction alone, pi / 4 for a half-wave of a cosine, 0 if all directions are alike. ``None`` without a response.
    """
    r = np.maximum(np.asarray(responses, float), 0.0)
    if not r.sum() > NOTHING:
        return None
    whole = complex(r @ np.exp(1j * np.radians(np.asarray(direction_deg, float))) / r.sum())
    return abs(whole), math.degrees(math.atan2(whole.imag, whole.real)) % 360.0


def pointing_error(points: pl.DataFrame) -> float | None:
    """Return the mean absolute angle between (hs, vs) and the motion, degrees; ``None`` if nothing responds."""
    hs, vs, turn = (points[name].to_numpy() for name in ("hs", "vs", "direction_deg"))
    off = np.abs((np.degrees(np.arctan2(vs, hs)) - turn + 180.0) % 360.0 - 180.0)[np.hypot(hs, vs) > NOTHING]
    return float(off.mean()) if off.size else None


def direction_noise(preferred_deg: Values) -> float:
    """Return half the 95 % interval (Student's) of a mean direction, degrees; infinite of fewer than two repeats."""
    from scipy import special  # not before: it takes its time to load

    turns = np.exp(1j * np.radians(np.asarray(preferred_deg, float)))
    if turns.size < 2:
        return math.inf
    off = np.degrees(np.angle(turns / turns.sum()))
    return float(special.stdtrit(turns.size - 1, 0.975) * off.std(ddof=1) / math.sqrt(turns.size))


def undefined_direction(preferred_deg: Values, step_deg: float) -> str:
    """Say why a preferred direction is not defined; empty where it is, or where one phase says nothing of noise.

    No property of direction depends on a grating's phase. So the direction is defined where its 95 % interval over the
    phases, ``preferred_deg``, is no wider than the step between the directions shown.
    """
    half = direction_noise(preferred_deg)
    varies = f"the preferred direction varies by ±{half:.0f}° over {len(preferred_deg)} phases of the grating"
    return f"{varies}, and the directions shown are {step_deg:g}° apart" if step_deg / 2 < half < math.inf else ""


def undefined_peak(responses: Values) -> str:
    """Say why the largest point of a curve (n,), or of a map (m, n), is no preference; empty where it is one.

    It is one where neighbouring points are more alike than in a random order: what scatters has a largest point too.
    """
    points = np.atleast_2d(np.asarray(responses, float))
    if (p := order_p(points)) <= LEVEL:
        return ""
    if points.size < LEAST_POINTS:
        return f"{points.size} points, and fewer than {LEAST_POINTS} cannot be told from a random order"
    return f"neighbouring points are no more alike than points in a random order (p = {p:.2f})"


def order_p(points: Floats) -> float:
    """Return the share of random orders of a map's points (m, n) whose neighbours are as alike as those seen.

    It is 0 for equal points and for maps with missing points: there is nothing to test.
    """
    if points.size < 3 or not np.isfinite(points).all() or np.ptp(points) == 0.0:
        return 0.0
    shuffled = np.tile(points.ravel(), (PERMUTATIONS, 1))
    shuffled = stream("permutations.points", SEED).permuted(shuffled, axis=1).reshape(-1, *points.shape)
    as_smooth = (_roughness(shuffled) <= _roughness(points[None]) * (1 + 1e-9)).sum()
    return (int(as_smooth) + 1) / (PERMUTATIONS + 1)


def _roughness(maps: Floats) -> Floats:
    """Return the sum of squared differences between neighbours, (k,), of maps (k, m, n)."""
    down, across = np.diff(maps, axis=1), np.diff(maps, axis=2)
    return np.asarray((down**2).sum((1, 2)) + (across**2).sum((1, 2)))
