"""When what moved which way: intervals of motion by a model's potentials, and how well HS follows optical flow.

An interval of rightward motion is a series of frames with HS above the model's threshold T, in which no two neighbours
are `GAP_S` and `GAP_FRAMES` or more apart and none is below -T, of at least `LEAST_FRAMES`; likewise leftward below -T,
and downward and upward by VS. It lasts from its first frame over the threshold to its last.

Neighbouring frames are alike. Against the flow seconds are therefore counted, and intervals come from blocks of a
second.
"""

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import polars as pl

from experiments.base.streams import stream
from experiments.judge.tests import SEED, Floats, proportion_interval
from experiments.show.video import TICK_S

GAP_S, GAP_FRAMES, LEAST_FRAMES = 0.25, 3, 3
DIRECTIONS = {"hs": ("rightward", "leftward"), "vs": ("downward", "upward"), "looming": ("looming", "looming")}
"""A spiking channel -> what its potential says above the threshold, and below the negative one."""
MOTIONS = pl.Schema(
    {"model": str, "direction": str, "start_s": float, "end_s": float, "frames": int, "peak": float, "spikes": int}
)
"""Columns of ``summary.csv``: ``frames`` over the threshold, and the potential farthest from 0."""

LEAST_SECONDS = 5
"""Separate seconds in which HS passes the threshold, below which C12 cannot be judged."""
BLOCK_S = 1.0
RESAMPLES = 2000
SMOOTHING_S = 0.5
"""Width of the moving mean that is taken of flow and HS, before they are correlated for `grades`."""
LEVEL = 0.02
"""abs(HS) from which on `grades` reads a direction; an eighth of the off-line threshold."""
GRADES = (
    "flow_r", "flow_r_low", "flow_r_high", "right_sign", "right_sign_low", "right_sign_high", "passing_s",
    "passing_s_low", "passing_s_high",
)  # fmt: skip
"""Columns of `grades`."""


def motions(frames: pl.DataFrame, thresholds: Mapping[str, Mapping[str, float | None]]) -> pl.DataFrame:
    """Return the intervals of motion, a row each, by model and in the order of their beginnings.

    Parameters
    ----------
    frames
        A row per frame and model: ``model``, ``time_s``, potentials and spikes.
    thresholds
        Label of a model -> channel -> spiking threshold.
    """
    found = [pl.DataFrame(schema=MOTIONS)]
    for label, levels in thresholds.items():
        rows = frames.filter(pl.col("model") == label)
        of_model = [
            _intervals(rows.select("time_s", potential=channel, spikes=f"{channel}_spikes"), DIRECTIONS[channel], level)
            for channel, level in levels.items()
            if channel in DIRECTIONS and level is not None
        ]
        if of_model:
            found.append(pl.concat(of_model).sort("start_s", maintain_order=True).select(
                pl.lit(label).alias("model"), *MOTIONS.names()[1:]).cast(MOTIONS))  # fmt: skip
    return pl.concat(found)


def _intervals(frames: pl.DataFrame, ways: tuple[str, str], threshold: float) -> pl.DataFrame:
    """Return the intervals of one channel of one model."""
    times_s = frames["time_s"].to_numpy()
    frame_s = float(np.median(np.diff(times_s))) if len(times_s) > 1 else 0.0
    gap_s = max(GAP_S, GAP_FRAMES * frame_s) - TICK_S
    over, potential = pl.col("potential").abs() > threshold, pl.col("potential")
    direction = pl.when(potential > 0).then(pl.lit(ways[0])).otherwise(pl.lit(ways[1])).alias("direction")
    begins = (pl.col("direction") != pl.col("direction").shift()) | (pl.col("time_s").diff() >= gap_s)
    return (
        frames.filter(over)
        .with_columns(direction)
        .with_columns(begins.fill_null(value=True).cum_sum().alias("interval"))
        .group_by("interval", maintain_order=True)
        .agg(
            pl.col("direction").first(),
            start_s=pl.col("time_s").first(),
            end_s=pl.col("time_s").last(),
            frames=pl.len(),
            peak=potential.get(potential.abs().arg_max()),
            spikes=pl.col("spikes").abs().sum(),
        )
        .filter(pl.col("frames") >= LEAST_FRAMES)
        .drop("interval")
    )


def near_miss(frames: pl.DataFrame, thresholds: Mapping[str, float | None]) -> str:
    """Say how near a model without an interval came to one, by its thresholds; empty if it has none."""
    levels = {channel: level for channel, level in thresholds.items() if channel in DIRECTIONS and level is not None}
    reached = []
    for channel, level in levels.items():
        potential = np.abs(frames[channel].to_numpy())
        few = f" and passed it in {over} frames, too few" if (over := (potential > level).sum()) else ""
        reached.append(f"|{channel.upper()}| reached {potential.max():.2g}{few}")
    highest = ", ".join(dict.fromkeys(f"T = {level:g}" for level in levels.values()))
    return f"no motion passed {highest}; {', '.join(reached)}" if reached else ""


def block_frames(rate: float) -> int:
    """Return how many frames a block of a second has; ``rate`` is in frames per second."""
    return max(round(rate * BLOCK_S), 1)


def separate(frames: npt.NDArray[np.intp], block: int) -> list[int]:
    """Return where stretches of ``block`` frames begin, none overlapping, that hold all of the ``frames``."""
    starts: list[int] = []
    for frame in frames.tolist():
        if not starts or frame >= starts[-1] + block:
            starts.append(frame)
    return starts


def resampled(terms: Floats, block: int) -> Floats:
    """Return sums (`RESAMPLES`, columns) of as many blocks of frames, drawn anywhere, as fill the whole."""
    running = np.vstack([np.zeros(terms.shape[1]), np.cumsum(terms, axis=0)])
    blocks = running[block:] - running[:-block]
    rng, draws = stream("bootstrap.blocks", SEED), round(len(terms) / block)
    return np.stack([blocks[rng.integers(len(blocks), size=draws)].sum(axis=0) for _ in range(RESAMPLES)])


def moments(x: Floats, y: Floats) -> Floats:
    """Return the terms (T, 6) whose sums a correlation is made of: n, x, y, x squared, y squared, x times y."""
    return np.column_stack([np.ones(len(x)), x, y, x**2, y**2, x * y])


def correlation(sums: Floats) -> Floats:
    """Return Pearson's correlation from sums (..., 6 or more) of `moments`; 0 where a column does not vary."""
    n, x, y, xx, yy, xy = (sums[..., i] for i in range(6))
    spread = np.sqrt(np.maximum(n * xx - x * x, 0.0) * np.maximum(n * yy - y * y, 0.0))
    return np.asarray(np.divide(n * xy - x * y, spread, out=np.zeros_like(spread), where=spread > 0))


def columns(frames: pl.DataFrame) -> tuple[Floats, Floats, Floats]:
    """Return flow, HS and VS of one model's frames, (T,) each; the first frame has no flow, and does not count."""
    flow, hs, vs = (frames[name].to_numpy()[1:].astype(np.float64) for name in ("flow", "hs", "vs"))
    return flow, hs, vs


def frame_rate(frames: pl.DataFrame) -> float:
    """Return the mean rate of one model's frames, 1/s."""
    last_s = float(frames["time_s"][-1])
    return (frames.height - 1) / last_s if last_s else 1.0


def grades(frames: pl.DataFrame, threshold: float | None) -> dict[str, float | None]:
    """Grade how well HS follows the flow, with 95 % intervals.

    A claim holds or fails. A model whose HS follows the motion and stays below its threshold fails it as one does that
    follows nothing; these numbers tell the two apart.

    Parameters
    ----------
    frames
        A row per frame: ``time_s``, ``flow``, ``hs``, ``vs``.
    threshold
        The model's threshold of HS.

    Returns
    -------
    dict
        ``flow_r``: correlation of HS with the flow, after a moving mean of `SMOOTHING_S`; its interval is that of a
        moving-block bootstrap. ``right_sign``: share of the frames with abs(HS) over `LEVEL` in which HS has the sign
        of the flow; its interval has one trial for each separate second of these. ``passing_s``: share of the whole
        seconds in which abs(HS) is over the threshold in `LEAST_FRAMES` frames or more. Each with ``_low`` and
        ``_high``. ``None`` of less than two seconds, and of a model without a threshold.
    """
    flow, hs, _ = columns(frames)
    rate = frame_rate(frames)
    block = block_frames(rate)
    seconds = len(hs) // block
    if threshold is None or seconds < 2:
        return dict.fromkeys(GRADES)
    smooth = np.full(max(round(rate * SMOOTHING_S), 1), 1.0)
    terms = moments(*(np.convolve(column, smooth / len(smooth), "valid") for column in (flow, hs)))
    level = np.abs(hs) > LEVEL
    trials = len(separate(np.flatnonzero(level), block))
    share = float((level & (np.sign(flow) == np.sign(hs))).sum() / level.sum()) if trials else None
    over = (np.abs(hs[: seconds * block]) > threshold).reshape(seconds, block).sum(axis=1)
    passing = int((over >= min(LEAST_FRAMES, block)).sum())
    low, high = np.percentile(correlation(resampled(terms, block)), [2.5, 97.5])
    values = (
        float(correlation(terms.sum(axis=0))), float(low), float(high),
        share, *(proportion_interval(share * trials, trials) if share is not None else (None, None)),
        passing / seconds, *proportion_interval(passing, seconds),
    )  # fmt: skip
    return dict(zip(GRADES, values, strict=True))
