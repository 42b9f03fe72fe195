"""Speed at which a measure of crossings is largest: of claim C30, and of maps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from experiments.bench.robot.judging import Rows

Curve = Mapping[float, Mapping[int, float]]
"""Speed, cm/s -> trial -> its value."""

POTENTIAL, COUNT = "mean_hs_near_axis", "spikes"
"""Columns: mean HS near the axis, which is the same stretch of path at every speed; spikes of the whole crossing."""


@dataclass(frozen=True, slots=True)
class Peak:
    """Speed where a mean over trials is largest among the speeds shown.

    Parameters
    ----------
    speed
        The speed, cm/s; of equal means the lowest speed.
    mean
        The mean over trials there.
    end
        Whether it is the first or the last speed shown: the true peak may then lie beyond. Otherwise empty.
    """

    speed: float
    mean: float
    end: Literal["", "first", "last"]


def curve(rows: Rows, column: str) -> dict[float, dict[int, float]]:
    """Values of a column by speed and trial, in the order of the rows."""
    by_speed: dict[float, dict[int, float]] = {}
    for row in rows:
        by_speed.setdefault(row["speed_cm_s"], {})[row["trial"]] = float(row[column])
    return by_speed


def mean(values: Mapping[Any, float]) -> float:
    """The mean over trials."""
    return float(np.mean(list(values.values())))


def peak(means: Mapping[float, float]) -> Peak:
    """Find the largest of means over trials.

    Parameters
    ----------
    means
        Speed, cm/s -> mean over trials; at least one speed.
    """
    speeds = sorted(means)
    speed = max(speeds, key=lambda level: means[level])
    return Peak(speed, means[speed], "first" if speed == speeds[0] else "last" if speed == speeds[-1] else "")
