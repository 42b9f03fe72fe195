"""C21 of every looming detector and preset, in the bright arena and in the dim one, and what it would take to hold."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from dsnn import LGMD1Params
from experiments import Study

if TYPE_CHECKING:
    import polars as pl

CLAIM = "C21"
PANEL = (
    "lgmd1", "lgmd1:preset=firmware", "lgmd1:preset=arena", "lgmd2", "lgmd2:preset=firmware", "si-lgmd1",
    "si-lgmd1:preset=firmware", "si-lgmd1:preset=arena", "si-lgmd1:preset=firmware,beta_3=0", "si-lgmd2",
    "si-lgmd2:preset=paper", "lplc2", "mlplc2", "lplc2-gf", "pon-lgmd", "hybrid",
)  # fmt: skip
"""Detectors, as ``--model`` takes them; with ``beta_3=0`` there is no self-inhibition. A model's page says where its
threshold comes from; that of ``pon-lgmd`` is assumed, as Fu and Li 2022 give none."""

EDGE = 15
"""Grey levels from one frame to the next, above which a cell counts as moving edge. In both arenas camera noise stays
below 10, and the cells that the robot's edge passes change by more than 20."""
THRESHOLDS = tuple(round(0.52 + 0.02 * step, 2) for step in range(24))
"""Thresholds on the potential, 0.52 to 0.98, at which frames are counted."""
COLUMNS = {"collision_frames": int, "edge_cells": int, "frames_above": list[int]}
"""The frames in which a detector announces a collision; the cells that changed by more than `EDGE`, over the trial; the
frames whose potential reaches each of `THRESHOLDS`."""


def spikes_in_a_row(network: Any) -> int:
    """Return how many spikes without a silent frame between them mean a collision to a detector.

    The hybrid has no such parameter: its LGMD1 has the default.
    """
    return int(getattr(network, "n_sp", LGMD1Params().n_sp))


def columns(showings: Any) -> dict[str, dict[str, Any]]:
    """Return `COLUMNS` for each detector, of what a trial showed."""
    cells = int(moving_edge(np.stack([sample.image for sample in showings[0].samples])).sum())
    return {
        model.label: {
            "collision_frames": collisions(found.looming_spikes, spikes_in_a_row(model.network)), "edge_cells": cells,
            "frames_above": [int((found.looming >= threshold).sum()) for threshold in THRESHOLDS],
        }
        for showing in showings
        for model, found in showing.series()
    }  # fmt: skip


def moving_edge(pictures: npt.NDArray[np.uint8]) -> npt.NDArray[np.int64]:
    """Return how many cells changed by more than `EDGE` since the frame before; (T - 1,), of (T, R, C) grey levels."""
    changes = np.abs(np.diff(pictures.astype(np.int16), axis=0))
    return np.asarray((changes > EDGE).sum(axis=(1, 2)), np.int64)


def collisions(spikes: npt.NDArray[np.int64], in_a_row: int) -> int:
    """Return in how many frames at least ``in_a_row`` spikes have come since the last frame without one; of (T,)."""
    count, frames = 0, 0
    for spike in spikes.tolist():
        count = count + spike if spike else 0
        frames += count >= in_a_row
    return frames


def held(rows: pl.DataFrame, number: pl.Expr) -> int:
    """Return in how many replicates C21 would hold if a number of a trial stood for its spikes: most at 0 degrees."""
    mean = rows.group_by("replicate", "angle_deg").agg(number.mean().alias("mean"))
    most = mean.remove(angle_deg=0.0).group_by("replicate").max()
    both = mean.filter(angle_deg=0.0).join(most, on="replicate", suffix="_aside")
    return int((both["mean"] > both["mean_aside"]).sum())


def means(rows: pl.DataFrame, number: pl.Expr) -> tuple[float, ...]:
    """Return the mean over trials at 0, 15 and 30 degrees to the axis: left and right are taken together."""
    apart = rows.with_columns(rows["angle_deg"].abs())
    return tuple(apart.group_by("angle_deg").agg(number.mean().alias("mean")).sort("angle_deg")["mean"])


def tables(result: Any) -> dict[str, list[dict[str, Any]]]:
    """Return what each detector counts in each arena, and the moving edge counted as if it were a detector.

    "Held by the rule" counts frames of announced collision instead of spikes.
    The best threshold is that at which, counting frames whose potential reaches it, C21 would hold in most replicates.
    """
    import polars as pl  # not before: see `experiments.paper.studies.robot`

    found: list[dict[str, Any]] = []
    edges: dict[str, dict[str, Any]] = {}
    peak, cells = pl.col("peak_looming"), pl.col("edge_cells")
    for point, model in result.judged:
        arena, rows = point[0][1], result.rows(point, model)
        at = [held(rows, pl.col("frames_above").list.get(index)) for index in range(len(THRESHOLDS))]
        first, *_ = result.replicates[point, model]
        found.append({
            "arena": arena, "detector": model, "threshold": first.thresholds[model]["looming"],
            "held": sum(outcome.verdict == "holds" for outcome in result.outcomes[point, model, CLAIM]),
            "held by the rule": held(rows, pl.col("collision_frames")),
            "spikes at 0, 15, 30": means(rows, pl.col("looming_spikes")), "peak potential": means(rows, peak),
            "best threshold": THRESHOLDS[at.index(max(at))], "held there": max(at),
        })  # fmt: skip
        edges[arena] = {"arena": arena, "cells at 0, 15, 30": means(rows, cells), "held": held(rows, cells)}
    return {"Detectors": found, "Moving edge, counted as if it were a detector": list(edges.values())}


STUDY = Study(
    name="detectors",
    summary="C21 of every looming detector and preset, in the bright and the dim arena",
    claims=(CLAIM,),
    experiments=("angular-approach",),
    axes={"arena": {"bright": (), "dim": ("scene.arena=dim",)}},
    models=PANEL,
)
