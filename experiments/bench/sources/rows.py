"""The tables of trials with the robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypedDict

from experiments.bench.run.rows import FrameRow, JobRow, ModelRow, ResponseRow, is_imported, schema_of
from experiments.bench.sources.conditions import CONDITION_COLUMNS, Condition
from experiments.bench.sources.experiment import Drawing
from experiments.bench.stats.checks import is_number


class RobotRow(JobRow):
    """A trial's row begins with what every row does, and the robot that saw."""

    robot: str


class TrialRow(ModelRow):
    """Columns of ``trials.parquet`` after those of the trial's condition: what one model responded."""

    firing_rate_hz: float | None
    peak_hs: float
    trough_hs: float
    peak_vs: float
    trough_vs: float
    peak_looming: float
    achieved_speed_cm_s: float | None
    """Mean speed of the stimulus where it was to be constant; null where it stopped before that."""
    path_error_mm: float | None
    """Largest distance of the stimulus from its line there."""
    drift_mm: float
    """Distance of the stimulus from its line at the end, left of its way positive."""
    drive: str
    """Drive of the stimulus: by ``feedback`` of its pose, or ``open`` loop."""
    closest_cm: float
    """Shortest distance between the robots."""
    seconds_in_view: float
    """Time for which the stimulus's centre is in the camera's field."""
    spikes_in_view: int | None
    """Number of spikes in view. This and the other counts are null where the model does not spike."""
    rate_in_view_hz: float | None
    mean_hs_in_view: float | None
    """Over these frames; null where there are none."""
    mean_hs_near_axis: float | None
    """Over the frames in which it is within 3.5 cm of the optical axis; null where it does not cross that."""
    spikes_in_window: int | None
    """Number of spikes in a time about the axis that is the same at every speed; null where the stimulus does not cross
    it.
    """
    spikes_in_inner_window: int | None
    """Number of spikes in a shorter time about the axis: see `experiments.bench.sources.measures`."""
    darkest: int
    """Lowest grey level in the frames that the model was shown, 0 to 255."""
    brightest: int
    """Highest grey level in them."""
    frames: int
    wall_s: float
    """Time that the trial took to compute."""
    code: str
    """Digest of the code that computed the row: see `experiments.bench.run.provenance`."""


class PoseRow(TypedDict):
    """Poses of both robots at the end of a frame's exposure."""

    stimulus_bearing_deg: float
    """Bearing from the observer's optical axis, right positive."""
    stimulus_x_cm: float
    stimulus_y_cm: float
    stimulus_heading_deg: float
    observer_x_cm: float
    observer_y_cm: float
    observer_heading_deg: float


class SeenRow(FrameRow):
    """A frame's row begins with its number, the robot that saw it, and the time in the trial."""

    robot: str
    sim_time_s: float


TRIAL_SCHEMA = schema_of(RobotRow, Condition, TrialRow)
FRAME_SCHEMA = schema_of(SeenRow, ResponseRow, PoseRow)


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
