"""The tables of trials with the robot."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypedDict, get_type_hints

import pyarrow as pa

from dsnn import ResponseSeries
from experiments.bench.sources.conditions import CONDITION_COLUMNS, Condition
from experiments.bench.sources.experiment import Drawing
from experiments.bench.sources.robot import FrameColumns, TrialAnswer, TrialResult
from experiments.bench.sources.windows import InWindows
from experiments.bench.stats.checks import is_number
from experiments.bench.store.origin import is_imported
from experiments.bench.store.rows import (
    OBSERVER,
    Failure,
    FrameRow,
    JobRow,
    ModelRow,
    ResponseRow,
    TrialRecord,
    schema_of,
)


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
    """Number of spikes in a shorter time about the axis: see `experiments.bench.sources.windows`."""
    frames: int
    wall_s: float
    """Time that the trial took to compute."""
    code: str
    """Digest of the code that computed the row: see `experiments.bench.store.provenance`."""


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


OF_TRIAL = (
    "achieved_speed_cm_s", "path_error_mm", "drift_mm", "drive", "closest_cm", "seconds_in_view", "frames", "wall_s",
)  # fmt: skip
"""Columns that are fields of `TrialResult`: the same for every model."""
OF_PARTS = tuple(field.name for field in dataclasses.fields(InWindows))
"""Columns that are about parts of a trial."""
OF_ANSWER = (
    "model", *get_type_hints(ModelRow), "firing_rate_hz", "peak_hs", "trough_hs", "peak_vs", "trough_vs",
    "peak_looming",
)  # fmt: skip
"""Columns that are fields of `TrialAnswer`."""

TRIAL_SCHEMA = schema_of(RobotRow, Condition, TrialRow)
FRAME_SCHEMA = schema_of(SeenRow, ResponseRow, PoseRow)


def finished(result: TrialResult, recording: bytes | str | None, *, frames: bool = True) -> TrialRecord:
    """A trial's result as table rows, one per model, and frame rows if wanted."""
    table = _frame_table(result) if frames else FRAME_SCHEMA.empty_table()
    spec = result.spec
    broken = tuple(
        Failure(spec.index, label, spec.condition.label(), spec.seed, reason) for label, reason in result.broken.items()
    )
    return TrialRecord(spec.index, tuple(_rows(result)), table, recording, broken)


def _rows(result: TrialResult) -> Iterable[dict[str, Any]]:
    spec = result.spec
    shared = {
        "experiment": spec.experiment,
        "trial": spec.index,
        "repeat": spec.repeat,
        "seed": spec.seed,
        "robot": OBSERVER,
        **spec.condition.columns(),
        **{name: getattr(result, name) for name in OF_TRIAL},
    }
    for answer in result.answers:
        yield {**shared, **answer_columns(answer)}


def answer_columns(answer: TrialAnswer) -> dict[str, Any]:
    """Return what one model made of a trial, as columns of ``trials.parquet``; without a tracker the parts are null."""
    parts = {name: getattr(answer.parts, name) if answer.parts else None for name in OF_PARTS}
    return {**{name: getattr(answer, name) for name in OF_ANSWER}, **parts}


def _frame_table(result: TrialResult) -> pa.Table:
    columns = {field.name: getattr(result.columns, field.name) for field in dataclasses.fields(FrameColumns)}
    tables = []
    for answer in result.answers:
        series = {field.name: getattr(answer.series, field.name) for field in dataclasses.fields(ResponseSeries)}
        index = {
            "trial": [result.spec.index] * result.frames,
            "model": [answer.model] * result.frames,
            "frame": range(result.frames),
            "robot": [OBSERVER] * result.frames,
        }
        tables.append(pa.table({**index, **columns, **series}).select(FRAME_SCHEMA.names).cast(FRAME_SCHEMA))
    return pa.concat_tables(tables)


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
