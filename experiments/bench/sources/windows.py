"""Parts of a trial in which potentials and spikes are measured beside the whole of it.

A count of a whole crossing mixes two things: how strongly the model answers, and for how long the stimulus is in view.
Three parts of the trial tell them apart.

- *In view*: the stimulus's centre is within the camera's horizontal field. Its length goes with distance over speed.
- *Near the axis*: the stimulus's centre is within `NEAR_AXIS_CM` of the optical axis. It is the same stretch of path
  at every speed and distance: at 5 cm, the nearest distance of the paper's, it is all of the view.
- *The common window*: one and the same time at every speed, centred on the axis, as the paper's "nearly identical
  translating time window". It is as long as the paper's fastest crossing takes, from the stimulus's first edge in view
  to its last edge out of it. *The inner window* reads that crossing from its centre in to its centre out.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig
from dsnn import ResponseSeries
from dsnn.model import SPIKING
from experiments.bench.sources.conditions import Condition
from experiments.bench.sources.course import ROBOT_RADIUS_CM, half_crossing

NEAR_AXIS_CM = 3.5
"""Half the stretch of path about the optical axis."""

FASTEST_CM_S = 10.0
"""The fastest crossing of the paper's speed tests: it sets how long the common window is."""

Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Windows:
    """Parts of a trial's T frames: masks of shape (T,).

    ``near_axis``, ``common`` and ``inner`` are ``None`` for an approach or recession, which does not cross the axis.
    """

    in_view: Mask
    near_axis: Mask | None
    common: Mask | None
    inner: Mask | None


@dataclass(frozen=True, slots=True)
class InWindows:
    """Answers of one model in the parts of a trial, as columns of ``trials.parquet``."""

    spikes_in_view: int | None
    """Number of spikes in view. This and the other counts, and the rate, are ``None`` where the model does not spike.
    """
    rate_in_view_hz: float | None
    """``None`` where the stimulus is never in view, too."""
    mean_hs_in_view: float | None
    mean_hs_near_axis: float | None
    spikes_in_window: int | None
    spikes_in_inner_window: int | None


def window_s(distance_cm: float, hfov_deg: float, radius_cm: float = ROBOT_RADIUS_CM) -> float:
    """Length of the window that is the same at every speed.

    Parameters
    ----------
    distance_cm
        Camera to the path of the crossing.
    hfov_deg
        The camera's horizontal field of view.
    radius_cm
        Of the stimulus; 0 is for its centre alone.

    Returns
    -------
    float
        Seconds in which a stimulus at `FASTEST_CM_S` crosses the view, from its first edge in to its last edge out.
    """
    half = half_crossing(distance_cm, radius_cm, math.radians(hfov_deg))
    return 2.0 * half / FASTEST_CM_S


def windows(
    condition: Condition,
    camera: CameraConfig,
    time_s: npt.NDArray[np.float64],
    bearing_deg: npt.NDArray[np.float64],
    away_cm: npt.NDArray[np.float64],
) -> Windows:
    """Find the parts of a trial.

    Parameters
    ----------
    condition
        What the trial sets.
    camera
        Of the observer.
    time_s
        Of each frame's end, shape (T,).
    bearing_deg
        Of the stimulus's centre from the optical axis, shape (T,).
    away_cm
        From the lens to the stimulus's centre, shape (T,).
    """
    in_view = np.abs(bearing_deg) <= camera.hfov_deg / 2
    if condition.motion != "translation":
        return Windows(in_view, None, None, None)
    aside_cm = np.abs(away_cm * np.sin(np.radians(bearing_deg)))
    off_s = np.abs(time_s - time_s[int(np.argmin(np.abs(bearing_deg)))])
    common, inner = (off_s <= window_s(condition.distance_cm, camera.hfov_deg, radius) / 2
                     for radius in (ROBOT_RADIUS_CM, 0.0))  # fmt: skip
    return Windows(in_view, aside_cm <= NEAR_AXIS_CM, common, inner)


def measure(series: ResponseSeries, counted: str, parts: Windows, fps: float) -> InWindows:
    """Measure one model's answers in the parts of a trial.

    Parameters
    ----------
    series
        Its answers, T frames long.
    counted
        The channel whose spikes are those of a trial; empty where the model does not spike.
    parts
        The parts of the trial.
    fps
        Frames per second.
    """
    spikes = np.abs(getattr(series, f"{counted}_spikes")) if counted in SPIKING else None
    seen_s, count = float(parts.in_view.sum()) / fps, _count(spikes, parts.in_view)
    return InWindows(
        spikes_in_view=count,
        rate_in_view_hz=count / seen_s if count is not None and seen_s else None,
        mean_hs_in_view=_mean(series.hs, parts.in_view),
        mean_hs_near_axis=_mean(series.hs, parts.near_axis),
        spikes_in_window=_count(spikes, parts.common),
        spikes_in_inner_window=_count(spikes, parts.inner),
    )


def _count(spikes: npt.NDArray[np.int64] | None, part: Mask | None) -> int | None:
    """The spikes in a part of the frames; ``None`` where the trial has no such part, or the model does not spike."""
    return None if spikes is None or part is None else int(spikes[part].sum())


def _mean(values: npt.NDArray[np.float64], part: Mask | None) -> float | None:
    """The mean over a part of the frames; ``None`` where the part has none."""
    return float(values[part].mean()) if part is not None and part.any() else None
