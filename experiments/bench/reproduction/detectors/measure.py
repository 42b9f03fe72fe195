"""One trial before all detectors: what each answered, by several counts, and how much edge moved before them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from experiments.bench.reproduction.detectors.panel import spikes_in_a_row
from experiments.bench.robot.experiment import TrialSpec
from experiments.bench.robot.rows import FRAME_SCHEMA, TRIAL_SCHEMA, finished
from experiments.bench.robot.run import simulated
from experiments.bench.store.drawing import drawn_here
from experiments.bench.store.rows import TrialRecord

EDGE = 15
"""Grey levels from one frame to the next, above which a cell counts as moving edge. In both arenas camera noise stays
below 10, and the cells that the robot's edge passes change by more than 20."""
EDGE_LEVELS = (10, 20, 40, 80, 160, 320)
"""Cells of moving edge in a frame."""
THRESHOLDS = tuple(round(0.52 + 0.02 * step, 2) for step in range(24))
"""Thresholds on the potential, 0.52 to 0.98, at which frames are counted."""
FRAMES = FRAME_SCHEMA
"""No frames are kept."""
SCHEMA = (
    TRIAL_SCHEMA.append(pa.field("collision_frames", pa.int64()))
    .append(pa.field("edge_cells", pa.int64()))
    .append(pa.field("edge_frames", pa.list_(pa.int64())))
    .append(pa.field("frames_above", pa.list_(pa.int64())))
)
"""A row of ``trials.parquet``, and beside it: the frames in which the detector announces a collision; the cells that
changed by more than `EDGE`, over the trial; the frames with at least each of `EDGE_LEVELS` such cells; the frames whose
potential reaches each of `THRESHOLDS`. Cells are the same for every detector."""


def work(spec: TrialSpec) -> TrialRecord:
    """Run one trial in a worker, and count."""
    result = simulated(spec, keep_media=True)
    assert result.media is not None
    cells = moving_edge(next(iter(result.media.pictures.values())))
    edge = {"edge_cells": int(cells.sum()), "edge_frames": [int((cells >= level).sum()) for level in EDGE_LEVELS]}
    models = {model.label: model for model in spec.settings.models}
    record = finished(result, None, frames=False)
    rows = []
    for row, answer in zip(record.rows, result.answers, strict=True):
        in_a_row = spikes_in_a_row(models[answer.model].network)
        above = [int((answer.series.looming >= threshold).sum()) for threshold in THRESHOLDS]
        count = collisions(answer.series.looming_spikes, in_a_row)
        rows.append({**row, "collision_frames": count, **edge, "frames_above": above})
    return drawn_here(replace(record, rows=tuple(rows)))


def moving_edge(pictures: npt.NDArray[np.uint8]) -> npt.NDArray[np.int64]:
    """Return how many cells changed by more than `EDGE` since the frame before; (T - 1,), of (T, R, C) grey levels."""
    changes = np.abs(np.diff(pictures.astype(np.int16), axis=0))
    return np.asarray((changes > EDGE).sum(axis=(1, 2)), np.int64)


def collisions(spikes: npt.NDArray[np.int64], in_a_row: int) -> int:
    """Return in how many frames at least ``in_a_row`` spikes have come since the last frame without one; of (T,)."""
    count, found = 0, 0
    for spike in spikes.tolist():
        count = count + spike if spike else 0
        found += count >= in_a_row
    return found
