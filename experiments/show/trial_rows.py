"""The tables of trials with the robot, and what a model responded, in the whole trial and in parts of it.

A count of a whole crossing mixes two things: how strongly the model responds, and for how long the stimulus is in view.
Three parts of the trial tell them apart.

- *In view*: the stimulus's centre is within the camera's horizontal field. Its length goes with distance over speed.
- *Near the axis*: the stimulus's centre is within `NEAR_AXIS_CM` of the optical axis. It is the same stretch of path
  at every speed and distance: at 5 cm, the nearest distance of the paper's, it is all of the view.
- *The common window*: one and the same time at every speed, centred on the axis, as the paper's "nearly identical
  translating time window". It is as long as the paper's fastest crossing takes, from the stimulus's first edge in view
  to its last edge out of it. *The inner window* reads that crossing from its centre in to its centre out.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt
import polars as pl

from colias_sim.config import CameraConfig
from colias_sim.truth import COLUMNS
from experiments.declare.conditions import CONDITION_COLUMNS, Condition
from experiments.declare.experiment import Drawing
from experiments.declare.outcome import is_number
from experiments.settings.models import ConfiguredModel
from experiments.show.course import ROBOT_RADIUS_CM, half_crossing
from experiments.show.play import ERRORS
from experiments.store.tables import COUNTS, FRAME, JOB, PEAKS, RESPONSES, columns_of, is_imported, peaks

RESPONDED: Mapping[str, type] = {
    "phase": int,  # number of the first camera frame that the model took: 0 where it takes all
    **COUNTS,
    "firing_rate_hz": float,
    **PEAKS,
    "achieved_speed_cm_s": float,  # mean of the stimulus where it was to be constant; null where it stopped before that
    "path_error_mm": float,  # largest distance of the stimulus from its line there
    "drift_mm": float,  # distance of the stimulus from its line at the end, left of its way positive
    "drive": str,  # of the stimulus: by ``feedback`` of its pose, or ``open`` loop
    "closest_cm": float,  # shortest distance from the lens to the stimulus's centre
    "seconds_in_view": float,  # time for which the stimulus's centre is in the camera's field
    "spikes_in_view": int,  # this and the other counts are null where the model does not spike
    "rate_in_view_hz": float,
    "mean_hs_in_view": float,  # null where it is never in view
    "mean_hs_near_axis": float,  # within 3.5 cm of the optical axis; null where it does not cross that
    "spikes_in_window": int,  # in a time about the axis that is the same at every speed
    "spikes_in_inner_window": int,  # in a shorter time about it: see `window_s`
    "darkest": int,  # lowest grey level in the frames that the model was shown, 0 to 255
    "brightest": int,
    "frames": int,
    "wall_s": float,  # time that the trial took to compute
}
"""Columns of ``trials.parquet`` after those of the trial's condition: what one model responded."""
POSES = (
    "stimulus_bearing_deg", "stimulus_x_cm", "stimulus_y_cm", "stimulus_heading_deg", "observer_x_cm", "observer_y_cm",
    "observer_heading_deg",
)  # fmt: skip
"""Poses of both robots at the end of a frame's exposure; the bearing is from the observer's axis, right positive."""

TRIAL_SCHEMA = pl.Schema({**JOB, "robot": str, **columns_of(Condition), **RESPONDED})
FRAME_SCHEMA = pl.Schema({**FRAME, "robot": str, "time_s": float, **RESPONSES, **dict.fromkeys(POSES, float)})
AGREEMENT = ("true_hs_flow_r", "true_hs_view_r", "true_vs_flow_r", "true_vs_view_r", "true_sign", "true_gain")
"""Columns of ``trials.parquet`` of a run with truth: see `agreement`."""
TRUE_TRIALS = pl.Schema({**TRIAL_SCHEMA, **dict.fromkeys(AGREEMENT, pl.Float64())})
TRUE_FRAMES = pl.Schema({**FRAME_SCHEMA, **dict.fromkeys((*COLUMNS, *ERRORS), pl.Float64())})
"""Columns of ``frames.parquet`` of a run with truth."""


def varying(rows: Sequence[Mapping[str, Any]], varies: str) -> list[str]:
    """``varies``, and the other columns that tell the conditions apart, model included."""
    implied = {"motion": {"angle_deg", "distance_cm", "far_cm", "acceleration_cm_s2"}, "angle_deg": {"direction"}}
    others = [
        name
        for name in ("model", *CONDITION_COLUMNS)
        if name != varies and name not in implied.get(varies, ()) and len({row[name] for row in rows}) > 1
    ]
    return [*(["model"] if "model" in others else []), varies, *(name for name in others if name != "model")]


def drawable(figure: Drawing, rows: Sequence[Mapping[str, Any]]) -> Drawing:
    """Return ``figure``, or ``spikes`` where rows of a log have no number in a column that a mechanism is drawn by."""
    columns = ("seconds_in_view", "rate_in_view_hz", "mean_hs_near_axis") if figure == "mechanism" else ()
    lacking = any(not is_number(row.get(name)) for row in rows if is_imported(row) for name in columns)
    return "spikes" if lacking else figure


LEAST_FLOW = 0.1
"""Flow of the stimulus to a side, px a frame, from which on it moves."""
NEAR_AXIS_CM = 3.5
"""Half the stretch of path about the optical axis."""

FASTEST_CM_S = 10.0
"""The fastest crossing of the paper's speed tests: it sets how long the common window is."""

Windows = Mapping[str, npt.NDArray[np.bool_]]
"""Part of a trial -> its frames, a mask of shape (T,). An approach or recession, which crosses no axis, is ``in_view``
alone; without poses there are none.
"""


def away_cm(frames: pl.DataFrame, forward_cm: float) -> npt.NDArray[np.float64]:
    """Return how far the stimulus's centre is from the lens in every frame, (T,), wherever the observer is by then.

    Parameters
    ----------
    frames
        A row per frame, with the poses of both robots.
    forward_cm
        From the observer's middle to its lens.
    """
    heading = np.radians(frames["observer_heading_deg"].to_numpy())
    lens_x = frames["observer_x_cm"].to_numpy() + forward_cm * np.cos(heading)
    lens_y = frames["observer_y_cm"].to_numpy() + forward_cm * np.sin(heading)
    x, y = (frames[name].to_numpy() for name in ("stimulus_x_cm", "stimulus_y_cm"))
    return np.asarray(np.hypot(x - lens_x, y - lens_y))


def window_s(distance_cm: float, hfov_deg: float, radius_cm: float = ROBOT_RADIUS_CM) -> float:
    """Length of the window that is the same at every speed.

    Parameters
    ----------
    distance_cm
        Camera to the path of the crossing.
    hfov_deg
        The camera's horizontal field of view.
    radius_cm
        Radius of the stimulus; 0 is for its centre alone.

    Returns
    -------
    float
        Seconds in which a stimulus at `FASTEST_CM_S` crosses the view, from its first edge in to its last edge out.
    """
    return 2.0 * half_crossing(distance_cm, radius_cm, math.radians(hfov_deg)) / FASTEST_CM_S


def windows(condition: Condition, camera: CameraConfig, frames: pl.DataFrame) -> Windows:
    """Find the parts of a trial.

    Parameters
    ----------
    condition
        What the trial sets.
    camera
        Pose of the observer.
    frames
        A row per frame, with its time and the poses of both robots.
    """
    bearing_deg, time_s = frames["stimulus_bearing_deg"].to_numpy(), frames["time_s"].to_numpy()
    in_view = np.abs(bearing_deg) <= camera.hfov_deg / 2
    if condition.motion != "translation":
        return {"in_view": in_view}
    aside_cm = np.abs(away_cm(frames, camera.forward_cm) * np.sin(np.radians(bearing_deg)))
    off_s = np.abs(time_s - time_s[int(np.argmin(np.abs(bearing_deg)))])
    lengths = {"window": ROBOT_RADIUS_CM, "inner_window": 0.0}
    about_axis = {
        name: off_s <= window_s(condition.distance_cm, camera.hfov_deg, radius) / 2 for name, radius in lengths.items()
    }
    return {"in_view": in_view, "near_axis": aside_cm <= NEAR_AXIS_CM, **about_axis}


def responses(model: ConfiguredModel, frames: pl.DataFrame, parts: Windows, fps: float) -> dict[str, Any]:
    """Measure a model's responses, as columns of ``trials.parquet``.

    Parameters
    ----------
    model
        The model. Where it does not spike, counts and rates are ``None``.
    frames
        A row per frame, with the fields of `dsnn.ResponseSeries`.
    parts
        The parts of the trial.
    fps
        Frames per second that the model takes.

    Returns
    -------
    dict of str to float, int or None
        Rates, peaks and troughs of the whole trial; counts and mean HS in its parts, ``None`` of a part it lacks.
    """
    spikes = None if model.threshold is None else np.abs(frames[f"{model.counted}_spikes"].to_numpy())
    hs = frames["hs"].to_numpy()

    def count(part: str) -> int | None:
        return int(spikes[parts[part]].sum()) if spikes is not None and part in parts else None

    def mean(part: str) -> float | None:
        return float(hs[parts[part]].mean()) if part in parts and parts[part].any() else None

    seen, seen_s = count("in_view"), float(parts["in_view"].sum()) / fps if parts else 0.0
    return {
        "firing_rate_hz": None if spikes is None else int(spikes.sum()) / (len(hs) / fps),
        **peaks(frames),
        "spikes_in_view": seen,
        "rate_in_view_hz": seen / seen_s if seen is not None and seen_s else None,
        "mean_hs_in_view": mean("in_view"),
        "mean_hs_near_axis": mean("near_axis"),
        "spikes_in_window": count("window"),
        "spikes_in_inner_window": count("inner_window"),
    }


def agreement(frames: pl.DataFrame) -> dict[str, float | None]:
    """Compare a model's potentials with what truly moved.

    Parameters
    ----------
    frames
        A row per frame: ``hs``, ``vs`` and the columns of the truth.

    Returns
    -------
    dict of str to float or None
        The columns `AGREEMENT`. Correlations of HS with rightward and of VS with downward flow, of the stimulus and of
        the whole view; no flow is 0, and there is no correlation with what is always equal. Of the frames in which the
        stimulus moves by `LEAST_FLOW` or more to a side: the share with HS of its sign, and HS per px by least squares.
    """
    found: dict[str, float | None] = {}
    for (channel, way), over in product((("hs", "x"), ("vs", "y")), ("flow", "view")):
        both = frames.select(channel, f"true_{over}_{way}").cast(pl.Float64).fill_null(0.0).to_numpy().T
        differ = (np.ptp(both, axis=1) > (LEAST_FLOW / 100, LEAST_FLOW / 10)).all()
        found[f"true_{channel}_{over}_r"] = float(np.corrcoef(both)[0, 1]) if differ else None
    both = frames.select("hs", "true_flow_x").cast(pl.Float64).drop_nulls().to_numpy().T
    hs, flow = both[:, np.abs(both[1]) >= LEAST_FLOW]
    if not flow.size:
        return found | {"true_sign": None, "true_gain": None}
    return found | {"true_sign": float((hs * flow > 0).mean()), "true_gain": float(hs @ flow / (flow @ flow))}
