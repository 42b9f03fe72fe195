"""The tables of trials with the robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import polars as pl

from experiments.bench.run.rows import COUNTS, FRAME, JOB, RESPONSES, columns_of, is_imported
from experiments.bench.sources.conditions import CONDITION_COLUMNS, Condition
from experiments.bench.sources.experiment import Drawing
from experiments.bench.stats.checks import is_number

RESPONDED: Mapping[str, type] = {
    **COUNTS,
    "firing_rate_hz": float,
    **dict.fromkeys(("peak_hs", "trough_hs", "peak_vs", "trough_vs", "peak_looming"), float),
    "achieved_speed_cm_s": float,  # mean of the stimulus where it was to be constant; null where it stopped before that
    "path_error_mm": float,  # largest distance of the stimulus from its line there
    "drift_mm": float,  # distance of the stimulus from its line at the end, left of its way positive
    "drive": str,  # of the stimulus: by ``feedback`` of its pose, or ``open`` loop
    "closest_cm": float,  # shortest distance between the robots
    "seconds_in_view": float,  # time for which the stimulus's centre is in the camera's field
    "spikes_in_view": int,  # this and the other counts are null where the model does not spike
    "rate_in_view_hz": float,
    "mean_hs_in_view": float,  # null where it is never in view
    "mean_hs_near_axis": float,  # within 3.5 cm of the optical axis; null where it does not cross that
    "spikes_in_window": int,  # in a time about the axis that is the same at every speed
    "spikes_in_inner_window": int,  # in a shorter time about it: see `experiments.bench.sources.measures`
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
FRAME_SCHEMA = pl.Schema({**FRAME, "robot": str, "sim_time_s": float, **RESPONSES, **dict.fromkeys(POSES, float)})


def varying(rows: Sequence[Mapping[str, Any]], varies: str) -> list[str]:
    """``varies``, and the other columns that tell the conditions apart, model included."""
    implied = {"motion": {"angle_deg", "distance_cm", "far_cm", "acceleration_cm_s2"}, "angle_deg": {"direction"}}
    others = [
        name
        for name in ("model", *CONDITION_COLUMNS)
        if name != varies and name not in implied.get(varies, ()) and len({row[name] for row in rows}) > 1
    ]
    return [*(["model"] if "model" in others else []), varies, *(name for name in others if name != "model")]


NEEDED_TO_DRAW: Mapping[Drawing, tuple[str, ...]] = {
    "mechanism": ("seconds_in_view", "rate_in_view_hz", "mean_hs_near_axis"),
    "excitation": (),
    "spikes": (),
}
"""Figure -> the columns that it cannot do without, and that the rows of a log may lack."""


def drawable(figure: Drawing, rows: Sequence[Mapping[str, Any]]) -> Drawing:
    """Return ``figure``, or ``spikes`` where rows of a log have no number in a column that it draws."""
    needed = NEEDED_TO_DRAW[figure]
    lacking = any(not is_number(row.get(name)) for row in rows if is_imported(row) for name in needed)
    return "spikes" if lacking else figure
