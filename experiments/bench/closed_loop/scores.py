"""Scores of episodes: the measures of each env, with their 95 % intervals. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl

from colias_sim.envs import ENVS, EpisodeColumn, Measure
from experiments.bench.closed_loop.episode import Episode
from experiments.bench.engine.alarms import poisson_interval
from experiments.bench.stats.scores import Score
from experiments.bench.stats.tests import proportion_interval, summarise
from experiments.bench.store.rows import OBSERVER, FrameRow, JobRow, TrialRecord, schema_of

Row = Mapping[str, Any]
GAIN_PLACES = 12
UNBOUNDED = (-math.inf, math.inf)


class EpisodeRow(JobRow):
    """A row of ``trials.parquet``: one episode. ``model`` is the behaviour.

    It also has the columns that the envs declare (`colias_sim.envs.EpisodeColumn`), null where an env has none.
    """

    robot: str
    env: str
    frames: int
    seconds: float
    touched: bool
    """Whether the episode ended by touching something."""
    driven_m: float
    reward: float
    code: str
    """Digest of the code that computed the row: see `experiments.bench.store.provenance`."""


class StepRow(FrameRow):
    """A row of ``frames.parquet``: one frame of an episode. What the network says is null where nothing is seen."""

    robot: str
    sim_time_s: float
    x_cm: float
    y_cm: float
    heading_deg: float
    left_wheel: float
    right_wheel: float
    reward: float
    hs: float | None
    vs: float | None
    looming: float | None
    azimuth: float | None
    hs_spikes: int | None
    vs_spikes: int | None
    looming_spikes: int | None


COLUMNS: Mapping[str, EpisodeColumn] = {column.name: column for entry in ENVS.values() for column in entry.columns}
"""Every column that an env declares, by name."""
EPISODE_SCHEMA = schema_of(EpisodeRow) | pl.Schema(dict.fromkeys(COLUMNS, float))
STEP_SCHEMA = schema_of(StepRow)


def finished(episode: Episode, index: int, repeat: int, recording: bytes | str | None) -> TrialRecord:
    """Return an episode as a row of `EPISODE_SCHEMA` and rows of `STEP_SCHEMA`.

    Parameters
    ----------
    episode
        What happened.
    index, repeat
        Its number in the run, and among those of its behaviour.
    recording
        The bytes of its recording, if there is one.
    """
    infos = episode.infos
    columns = {column.name for column in ENVS[episode.env].columns}
    row = {
        "experiment": "behave",
        "trial": index,
        "repeat": repeat,
        "seed": episode.seed,
        "model": episode.name,
        "robot": OBSERVER,
        "env": episode.env,
        "frames": episode.steps,
        "seconds": float(episode.time_s[-1]),
        "touched": episode.touched,
        "driven_m": float(infos["driven_cm"].sum()) / 100,
        "reward": float(episode.rewards.sum()),
        **{name: _value(column, episode) if name in columns else None for name, column in COLUMNS.items()},
    }
    return TrialRecord(index, (row,), _steps(episode, index), recording)


def _value(column: EpisodeColumn, episode: Episode) -> float | None:
    """Return the column's number for one episode."""
    values = episode.infos[column.info]
    if column.kind == "optomotor_gain":
        return optomotor_gain(values, episode.infos[column.target])
    if column.kind == "rms":
        return float(np.sqrt(np.square(values).mean()))
    if column.kind == "mean_abs_error":
        values = values - float(getattr(episode.options, column.target))
    return float((values if column.kind in ("mean", "share") else np.abs(values)).mean())


def optomotor_gain(slip_deg_s: Sequence[float] | Any, drift_deg_s: Sequence[float] | Any) -> float | None:
    """1 - sum(slip sign(drift)) / sum |drift|: 0 for a robot that does nothing, 1 for one whose view never turns.

    ``None`` where nothing disturbed it.
    """
    slip, drift = np.asarray(slip_deg_s, float), np.asarray(drift_deg_s, float)
    whole = float(np.abs(drift).sum())
    # The difference of two sums that are alike has their rounding errors: what does nothing has a gain of 0.
    return None if whole == 0.0 else round(1.0 - float((slip * np.sign(drift)).sum()) / whole, GAIN_PLACES) + 0.0


def mean(rows: Sequence[Row], column: str) -> Score | None:
    """Return the mean over episodes, with its interval; ``None`` where the env has no such measure.

    The interval keeps to what the column can be: the mean of shares is at most 1.
    """
    ends = COLUMNS[column].ends if column in COLUMNS else UNBOUNDED
    return _mean([row[column] for row in rows if row[column] is not None], ends)


def _mean(values: Sequence[float], ends: tuple[float, float]) -> Score | None:
    if not values:
        return None
    summary = summarise(values, *ends)
    return Score(summary.mean, summary.ci_low, summary.ci_high, summary.n)


def mean_difference(first: Sequence[Row], second: Sequence[Row], column: str) -> Score | None:
    """Return by how much a column of the ``first`` exceeds that of the ``second``, a mean over the seeds of both.

    Episodes of equal seed are in equal worlds, so what differs between worlds cancels in their difference. ``None``
    where no seed has both.
    """
    values, others = ({row["seed"]: row[column] for row in rows if row[column] is not None} for rows in (first, second))
    return _mean([values[seed] - others[seed] for seed in sorted(values.keys() & others.keys())], UNBOUNDED)


def rate(rows: Sequence[Row], per: str, unit: float = 1.0) -> Score:
    """Collisions per ``unit`` of a column's sum, with the exact interval of a Poisson rate (Garwood 1936).

    Every episode ends with its first collision, so they come one by one out of a stretch that is as long as it took.
    """
    count, stretch = sum(bool(row["touched"]) for row in rows), sum(row[per] for row in rows) / unit
    if not stretch > 0.0:  # or no number
        return Score(math.nan, math.nan, math.nan, len(rows))
    low, high = poisson_interval(count)
    return Score(count / stretch, low / stretch, high / stretch, len(rows))


def free_distance(rows: Sequence[Row]) -> Score:
    """Metres driven per collision: the rate's reciprocal, without an upper end where nothing was touched."""
    per_metre = rate(rows, "driven_m")
    value, low, high = (
        math.inf if end == 0.0 else 1.0 / end for end in (per_metre.value, per_metre.high, per_metre.low)
    )
    return Score(value, low, high, per_metre.n)


def rate_ratio(first: Sequence[Row], second: Sequence[Row], per: str = "driven_m") -> Score:
    """Tell how many times more often the ``first`` collide than the ``second``, with the exact conditional interval.

    Given their sum, the count of the first is binomial, its chance set by the ratio and the two stretches.
    """
    counts = [sum(bool(row["touched"]) for row in rows) for rows in (first, second)]
    stretches = [sum(row[per] for row in rows) for rows in (first, second)]
    total = sum(counts)
    if total == 0 or not all(stretch > 0.0 for stretch in stretches):  # or no number
        return Score(math.nan, math.nan, math.nan, len(first) + len(second))
    scale = stretches[1] / stretches[0]
    ends = (counts[0] / total, *proportion_interval(counts[0], total))
    value, low, high = (math.inf if end == 1.0 else scale * end / (1.0 - end) for end in ends)
    return Score(value, low, high, total)


def score(measure: Measure, rows: Sequence[Row]) -> Score | None:
    """Return one measure of one behaviour's episodes."""
    if measure.kind == "mean":
        return mean(rows, measure.column)
    return rate(rows, measure.column, measure.per) if measure.kind == "collision_rate" else free_distance(rows)


def scores(rows: Sequence[Row], env: str) -> dict[str, Score | None]:
    """Return every measure that an env declares, and the return, of one behaviour's episodes."""
    values = {measure.name: score(measure, rows) for measure in ENVS[env].all_measures}
    return {name: value for name, value in values.items() if value is not None}


def _steps(episode: Episode, index: int) -> pl.DataFrame:
    observer = next(iter(episode.paths.values()))
    columns: dict[str, Any] = {
        "trial": index,
        "model": episode.name,
        "frame": range(episode.steps),
        "robot": OBSERVER,
        "sim_time_s": episode.time_s,
        "x_cm": observer[:, 0],
        "y_cm": observer[:, 1],
        "heading_deg": observer[:, 2],
        "left_wheel": episode.wheels[:, 0],
        "right_wheel": episode.wheels[:, 1],
        "reward": episode.rewards,
    }
    for name in ("hs", "vs", "looming", "azimuth", "hs_spikes", "vs_spikes", "looming_spikes"):
        columns[name] = None if episode.series is None else getattr(episode.series, name)
    return pl.DataFrame(columns).select(STEP_SCHEMA.names()).cast(STEP_SCHEMA)
