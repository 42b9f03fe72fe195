"""Trials of which some models' potentials and spikes of every frame are kept, in their rows."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
import pyarrow as pa

from experiments.bench.robot.experiment import TrialSpec
from experiments.bench.robot.rows import TRIAL_SCHEMA, finished
from experiments.bench.robot.run import simulated
from experiments.bench.store.contents import Contents
from experiments.bench.store.drawing import drawn_here
from experiments.bench.store.rows import TrialRecord

HS, SPIKES = "hs_series", "hs_spikes_series"
SCHEMA = TRIAL_SCHEMA.append(pa.field(HS, pa.list_(pa.float32()))).append(pa.field(SPIKES, pa.list_(pa.int32())))
"""``trials.parquet``, with HS, in float32, and its spikes in every frame; null of a model whose are not kept."""


def work(spec: TrialSpec, *, labels: Collection[str]) -> TrialRecord:
    """Run one trial in a worker; of the models called ``labels`` the rows have HS and its spikes in every frame."""
    result = simulated(spec, keep_media=False)
    record = finished(result, None, frames=False)
    rows = tuple(
        {
            **row,
            HS: answer.series.hs.astype(np.float32).tolist() if answer.model in labels else None,
            SPIKES: answer.series.hs_spikes.tolist() if answer.model in labels else None,
        }
        for row, answer in zip(record.rows, result.answers, strict=True)
    )
    return drawn_here(replace(record, rows=rows))


def contents(plain: Contents) -> Contents:
    """The contents of a run of such trials: the series may be null."""
    return replace(plain, may_be_null=plain.may_be_null | {HS, SPIKES})
