"""What episodes come to: the measures of each env, with their 95 % intervals. Pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from scipy import stats

from experiments.bench.episodes import Episode
from experiments.bench.results import Finished
from experiments.bench.statistics import summarise

Row = Mapping[str, Any]
GAIN_PLACES = 12
PLACES = 4
"""Decimal places that are shown: a gain of 0.00001 is 0 to anybody who reads it."""

EPISODE_SCHEMA = pa.schema(
    {
        "experiment": pa.string(),
        "trial": pa.int64(),
        "repeat": pa.int64(),
        "seed": pa.int64(),
        "model": pa.string(),  # the behaviour: the column's name is that of every run's table
        "env": pa.string(),
        "frames": pa.int64(),
        "seconds": pa.float64(),
        "touched": pa.bool_(),
        "driven_m": pa.float64(),
        "reward": pa.float64(),
        "optomotor_gain": pa.float64(),
        "in_view": pa.float64(),
        "off_axis_deg": pa.float64(),
        "gap_error_cm": pa.float64(),
        "code": pa.string(),
    }
)
STEP_SCHEMA = pa.schema(
    {
        "trial": pa.int64(),
        "model": pa.string(),
        "frame": pa.int64(),
        "sim_time_s": pa.float64(),
        **dict.fromkeys(("x_cm", "y_cm", "heading_deg", "left_wheel", "right_wheel", "reward"), pa.float64()),
        **dict.fromkeys(("hs", "vs", "looming", "azimuth"), pa.float64()),
        **dict.fromkeys(("hs_spikes", "vs_spikes", "looming_spikes"), pa.int64()),
    }
)


@dataclass(frozen=True, slots=True)
class Score:
    """A measure with its 95 % interval; NaN where there is nothing to tell."""

    value: float
    low: float
    high: float
    n: int

    def __str__(self) -> str:
        if math.isnan(self.value) or math.isnan(self.low):
            return written(self.value)
        return f"{written(self.value)} [{written(self.low)}, {written(self.high)}]"

    def interval(self) -> str:
        """``low .. high``, or a dash where there is none: one episode has no spread."""
        return "-" if math.isnan(self.low) else f"{written(self.low)} .. {written(self.high)}"


def written(value: float) -> str:
    """A number for people, to three digits and four decimal places; a dash for NaN."""
    return "-" if math.isnan(value) else f"{round(value, PLACES):z.3g}"


def finished(episode: Episode, index: int, repeat: int, wanted_cm: float, recording: bytes | None) -> Finished:
    """An episode as a row of `EPISODE_SCHEMA` and rows of `STEP_SCHEMA`; ``wanted_cm`` is the gap to be kept."""
    infos = episode.infos
    row = {
        "experiment": "behave",
        "trial": index,
        "repeat": repeat,
        "seed": episode.seed,
        "model": episode.name,
        "env": episode.env,
        "frames": episode.steps,
        "seconds": float(episode.time_s[-1]),
        "touched": episode.touched,
        "driven_m": float(infos["driven_cm"].sum()) / 100,
        "reward": float(episode.rewards.sum()),
        "optomotor_gain": optomotor_gain(infos["slip_deg_s"], infos["drift_deg_s"]),
        "in_view": float(infos["in_view"].mean()) if "in_view" in infos else None,
        "off_axis_deg": float(np.abs(infos["bearing_deg"]).mean()) if "bearing_deg" in infos else None,
        "gap_error_cm": float(np.abs(infos["gap_cm"] - wanted_cm).mean()) if "gap_cm" in infos else None,
    }
    return Finished(index, (row,), _steps(episode, index), recording)


def optomotor_gain(slip_deg_s: Sequence[float] | Any, drift_deg_s: Sequence[float] | Any) -> float | None:
    """1 - sum(slip sign(drift)) / sum |drift|: 0 for a robot that does nothing, 1 for one whose view never turns.

    ``None`` where nothing disturbed it.
    """
    slip, drift = np.asarray(slip_deg_s, float), np.asarray(drift_deg_s, float)
    whole = float(np.abs(drift).sum())
    # The difference of two sums that are alike has their rounding errors: what does nothing has a gain of 0.
    return None if whole == 0.0 else round(1.0 - float((slip * np.sign(drift)).sum()) / whole, GAIN_PLACES) + 0.0


def mean(rows: Sequence[Row], column: str) -> Score | None:
    """The mean over episodes, with its interval; ``None`` where the env has no such measure."""
    values = [row[column] for row in rows if row[column] is not None]
    if not values:
        return None
    found = summarise(values)
    return Score(found.mean, found.ci_low, found.ci_high, found.n)


def rate(rows: Sequence[Row], per: str, unit: float = 1.0) -> Score:
    """Collisions per ``unit`` of a column's sum, with the exact interval of a Poisson rate (Garwood 1936).

    Every episode ends with its first collision, so they come one by one out of a stretch that is as long as it took.
    """
    count, stretch = sum(bool(row["touched"]) for row in rows), sum(row[per] for row in rows) / unit
    if not stretch > 0.0:  # or no number
        return Score(math.nan, math.nan, math.nan, len(rows))
    low = float(stats.chi2.ppf(0.025, 2 * count)) / 2 if count else 0.0
    high = float(stats.chi2.ppf(0.975, 2 * count + 2)) / 2
    return Score(count / stretch, low / stretch, high / stretch, len(rows))


def free_distance(rows: Sequence[Row]) -> Score:
    """Metres driven per collision: the rate's reciprocal, without an upper end where nothing was touched."""
    per_metre = rate(rows, "driven_m")
    value, low, high = (
        math.inf if end == 0.0 else 1.0 / end for end in (per_metre.value, per_metre.high, per_metre.low)
    )
    return Score(value, low, high, per_metre.n)


def rate_ratio(first: Sequence[Row], second: Sequence[Row], per: str = "driven_m") -> Score:
    """How many times more often the ``first`` collide than the ``second``, with the exact conditional interval.

    Given their sum, the count of the first is binomial, its chance set by the ratio and the two stretches.
    """
    counts = [sum(bool(row["touched"]) for row in rows) for rows in (first, second)]
    stretches = [sum(row[per] for row in rows) for rows in (first, second)]
    total = sum(counts)
    if total == 0 or not all(stretch > 0.0 for stretch in stretches):  # or no number
        return Score(math.nan, math.nan, math.nan, len(first) + len(second))
    scale = stretches[1] / stretches[0]
    interval = stats.binomtest(counts[0], total).proportion_ci(method="exact")
    ends = (counts[0] / total, float(interval.low), float(interval.high))
    value, low, high = (math.inf if end == 1.0 else scale * end / (1.0 - end) for end in ends)
    return Score(value, low, high, total)


MEASURES: Mapping[str, Mapping[str, Callable[[Sequence[Row]], Score | None]]] = {
    "colias_sim/Avoidance-v0": {
        "collisions/min": lambda rows: rate(rows, "seconds", 60.0),
        "collisions/m": lambda rows: rate(rows, "driven_m"),
        "free distance (m)": free_distance,
    },
    "colias_sim/Fixation-v0": {
        "time on target": lambda rows: mean(rows, "in_view"),
        "off axis (deg)": lambda rows: mean(rows, "off_axis_deg"),
    },
    "colias_sim/Optomotor-v0": {"optomotor gain": lambda rows: mean(rows, "optomotor_gain")},
    "colias_sim/Pursuit-v0": {
        "time on target": lambda rows: mean(rows, "in_view"),
        "gap error (cm)": lambda rows: mean(rows, "gap_error_cm"),
        "collisions/min": lambda rows: rate(rows, "seconds", 60.0),
    },
}
"""Env -> its measures by name, each a `Score` of one behaviour's rows."""


def scores(rows: Sequence[Row], env: str) -> dict[str, Score]:
    """Every measure of an env, and the return, of one behaviour's episodes."""
    found = {name: measure(rows) for name, measure in MEASURES.get(env, {}).items()}
    found["return"] = mean(rows, "reward")
    return {name: score for name, score in found.items() if score is not None}


def _steps(episode: Episode, index: int) -> pa.Table:
    observer = next(iter(episode.paths.values()))
    count, series = episode.steps, episode.series
    columns: dict[str, Any] = {
        "trial": [index] * count,
        "model": [episode.name] * count,
        "frame": range(count),
        "sim_time_s": episode.time_s,
        "x_cm": observer[:, 0],
        "y_cm": observer[:, 1],
        "heading_deg": observer[:, 2],
        "left_wheel": episode.wheels[:, 0],
        "right_wheel": episode.wheels[:, 1],
        "reward": episode.rewards,
    }
    for name in ("hs", "vs", "looming", "azimuth", "hs_spikes", "vs_spikes", "looming_spikes"):
        columns[name] = [None] * count if series is None else getattr(series, name)
    return pa.table(columns).select(STEP_SCHEMA.names).cast(STEP_SCHEMA)
