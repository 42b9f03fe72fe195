"""C21 of every looming detector and preset, in the bright arena and in the dim one, and why it fails."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from dsnn import LGMD1Params
from experiments import Axis, Level, Study
from experiments.bench.studies.replicates import Replicate
from experiments.bench.studies.study import Probe, Tables

if TYPE_CHECKING:
    import polars as pl

    from experiments.bench.sources.robot import RobotTrial
    from experiments.bench.store.rows import TrialRecord
    from experiments.bench.studies.counts import Counts

CLAIM = "C21"
ARENA = Axis("arena", (Level("bright"), Level("dim", ("scene.arena=dim",))))
ANGLES = (-30.0, -15.0, 0.0, 15.0, 30.0)
AWAY = (0.0, 15.0, 30.0)
"""Angles to the axis, degrees: left and right are taken together."""
Rows = Sequence[Mapping[str, Any]]
Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Detector:
    """A detector under one set of published constants.

    Parameters
    ----------
    label
        What ``--model`` takes, and tables show.
    preset
        What its constants are called.
    source
        Where its spike threshold is from.
    """

    label: str
    preset: str
    source: str


PANEL = (
    Detector("lgmd1", "paper", "Yue and Rind 2006"),
    Detector("lgmd1:preset=firmware", "firmware", "T_s of the firmware's SI-LGMD1"),
    Detector("lgmd1:preset=arena", "firmware, arena", "its T_s for the arena"),
    Detector("lgmd2", "paper", "Fu, Hu and Yue 2018"),
    Detector("lgmd2:preset=firmware", "firmware", "the ON/OFF-competing LGMD2 on Colias"),
    Detector("si-lgmd1", "paper", "the firmware's T_s"),
    Detector("si-lgmd1:preset=firmware", "firmware", "the firmware's T_s"),
    Detector("si-lgmd1:preset=arena", "firmware, arena", "its T_s for the arena"),
    Detector("si-lgmd1:preset=firmware,beta_3=0", "firmware, no self-inhibition", "the firmware's T_s"),
    Detector("si-lgmd2", "firmware", "the firmware's T_spi"),
    Detector("si-lgmd2:preset=paper", "paper", "the firmware's T_spi"),
    Detector("lplc2", "paper", "Hua and others 2022; the scale of its potential is assumed"),
    Detector("mlplc2", "paper", "Liu and Fu 2025"),
    Detector("lplc2-gf", "robot", "Zhao and others 2023, in the angles of the robot's camera"),
    Detector("pon-lgmd", "paper", "assumed: Fu and Li 2022 give none"),
    Detector("hybrid", "robot", "that of its LGMD1, Yue and Rind 2006"),
)
"""All are shown the same trials."""

EDGE = 15
"""Grey levels from one frame to the next, above which a cell counts as moving edge. In both arenas camera noise stays
below 10, and the cells that the robot's edge passes change by more than 20."""
EDGE_LEVELS = (10, 20, 40, 80, 160, 320)
"""Cells of moving edge in a frame."""
THRESHOLDS = tuple(round(0.52 + 0.02 * step, 2) for step in range(24))
"""Thresholds on the potential, 0.52 to 0.98, at which frames are counted."""


def schema() -> "pl.Schema":
    """Return the columns of a row of ``trials.parquet``, and those that `work` keeps beside them.

    These are the frames in which the detector announces a collision; the cells that changed by more than `EDGE`, over
    the trial; the frames with at least each of `EDGE_LEVELS` such cells; the frames whose potential reaches each of
    `THRESHOLDS`. Cells are the same for every detector.
    """
    import polars as pl

    from experiments.bench.sources.rows import TRIAL_SCHEMA

    lists = pl.List(pl.Int64)
    columns = {"collision_frames": pl.Int64(), "edge_cells": pl.Int64(), "edge_frames": lists, "frames_above": lists}
    return TRIAL_SCHEMA | pl.Schema(columns)


def spikes_in_a_row(network: Any) -> int:
    """Return how many spikes without a silent frame between them mean a collision to a detector.

    The hybrid has no such parameter: its LGMD1 has the default.
    """
    return int(getattr(network, "n_sp", LGMD1Params().n_sp))


def work(spec: "RobotTrial") -> "TrialRecord":
    """Run one trial in a worker, and count."""
    from experiments.bench.run.play import show, tabulate
    from experiments.bench.store.drawing import drawn_here

    began_s = time.perf_counter()
    showings = show(spec)
    record = tabulate(spec, showings, time.perf_counter() - began_s, frames=False)
    cells = moving_edge(np.stack([sample.image for sample in showings[0].samples]))
    edge = {"edge_cells": int(cells.sum()), "edge_frames": [int((cells >= level).sum()) for level in EDGE_LEVELS]}
    answers = {model.label: (model, series) for showing in showings for model, series in showing.series()}
    rows = []
    for row in record.rows:
        model, series = answers[row["model"]]
        above = [int((series.looming >= threshold).sum()) for threshold in THRESHOLDS]
        count = collisions(series.looming_spikes, spikes_in_a_row(model.network))
        rows.append({**row, "collision_frames": count, **edge, "frames_above": above})
    return drawn_here(replace(record, rows=tuple(rows)))


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


@dataclass(frozen=True, slots=True)
class DetectorRow:
    """The result of C21 for one detector in one arena. Triples are of 0, 15 and 30 degrees to the axis.

    Parameters
    ----------
    arena, label, preset, source
        The arena, the detector as ``--model`` takes it, the name of its constants, the source of its threshold.
    threshold
        Its spike threshold on the potential.
    held, replicates
        In how many of ``replicates`` C21 held.
    spikes, peak, frames
        Mean spikes of a trial, mean highest potential, mean number of frames.
    announced, collision_frames
        Share of trials in which it announces a collision; mean number of frames in which it does.
    held_by_collision, held_by_peak
        In how many replicates C21 would hold if frames of announced collision, or the highest potential, were counted
        instead of spikes.
    best_threshold, held_at_best
        The threshold at which, counting frames whose potential reaches it, C21 would hold in most replicates, and in
        how many. It tells whether any constant could make the claim hold; none is fitted.
    cause
        Why it does not hold in all replicates, from these numbers; empty where it does.
    """

    arena: str
    label: str
    preset: str
    source: str
    threshold: float
    held: int
    replicates: int
    spikes: Triple
    peak: Triple
    frames: Triple
    announced: Triple
    collision_frames: Triple
    held_by_collision: int
    held_by_peak: int
    best_threshold: float
    held_at_best: int
    cause: str = ""


@dataclass(frozen=True, slots=True)
class EdgeRow:
    """The moving edge before the camera in one arena, counted as if it were a detector. It is the control.

    Parameters
    ----------
    arena
        The arena.
    cells
        Mean number of cells of moving edge in a trial, at 0, 15 and 30 degrees.
    frames
        Cells in a frame -> mean number of frames of a trial that have at least as many, at these angles.
    held, held_by_frames
        In how many replicates C21 would hold of the cells, and of these frames at each number of cells.
    replicates
        How many there are.
    """

    arena: str
    cells: Triple
    frames: Mapping[int, Triple]
    held: int
    held_by_frames: Mapping[int, int]
    replicates: int


def detector_row(arena: str, detector: Detector, every: Sequence[Replicate], held: int) -> DetectorRow:
    """Measure one detector in every replicate, in ``held`` of which C21 holds; ``cause`` is left empty."""
    threshold = every[0].looming[detector.label]
    assert threshold is not None
    rows = [looming_rows(replicate, detector.label) for replicate in every]
    at = [held_by(rows, _entry("frames_above", index)) for index in range(len(THRESHOLDS))]
    best = max(range(len(THRESHOLDS)), key=lambda index: at[index])
    trials = [row for replicate_rows in rows for row in replicate_rows]
    frames, peak = _column("collision_frames"), _column("peak_looming")
    return DetectorRow(
        arena=arena, label=detector.label, preset=detector.preset, source=detector.source, threshold=threshold,
        held=held, replicates=len(every),
        spikes=means(trials, _column("spikes")), peak=means(trials, peak), frames=means(trials, _column("frames")),
        announced=means(trials, lambda row: float(row["collision_frames"] > 0)),
        collision_frames=means(trials, frames), held_by_collision=held_by(rows, frames),
        held_by_peak=held_by(rows, peak), best_threshold=THRESHOLDS[best], held_at_best=at[best],
    )  # fmt: skip


def edge_row(arena: str, label: str, every: Sequence[Replicate]) -> EdgeRow:
    """Count the moving edge of all trials; it is the same in the rows of every detector, and read in those of one."""
    rows = [looming_rows(replicate, label) for replicate in every]
    trials = [row for replicate_rows in rows for row in replicate_rows]
    levels = {level: _entry("edge_frames", index) for index, level in enumerate(EDGE_LEVELS)}
    cells = _column("edge_cells")
    return EdgeRow(
        arena, means(trials, cells), {level: means(trials, of) for level, of in levels.items()}, held_by(rows, cells),
        {level: held_by(rows, of) for level, of in levels.items()}, len(every),
    )  # fmt: skip


def looming_rows(replicate: Replicate, label: str) -> list[Mapping[str, Any]]:
    """Return the rows of one detector; ``spikes`` are those of looming, of one that tells direction too."""
    return [{**row, "spikes": row["looming_spikes"]} for row in replicate.of(label)]


def held_by(every: Sequence[Rows], count: Callable[[Mapping[str, Any]], float]) -> int:
    """Return in how many replicates C21 would hold if ``count`` of a trial stood for its spikes: most at 0 degrees."""
    held = 0
    for rows in every:
        mean = {angle: _mean([count(row) for row in rows if row["angle_deg"] == angle]) for angle in ANGLES}
        held += all(mean[0.0] > other for angle, other in mean.items() if angle)
    return held


def _mean(values: Sequence[float]) -> float:
    """Return a mean; NaN of nothing, which is more than nothing."""
    return sum(values) / len(values) if values else math.nan


def means(rows: Rows, value: Callable[[Mapping[str, Any]], float]) -> Triple:
    """Return the mean over trials at each of `AWAY`; NaN where there is no trial."""
    straight, middle, far = (_mean([value(row) for row in rows if abs(row["angle_deg"]) == angle]) for angle in AWAY)
    return straight, middle, far


def _column(name: str) -> Callable[[Mapping[str, Any]], float]:
    return lambda row: float(row[name])


def _entry(name: str, index: int) -> Callable[[Mapping[str, Any]], float]:
    return lambda row: float(row[name][index])


EVERY_FRAME = 0.9
"""Share of a trial's frames with spikes, from which a count of spikes is the trial's length."""
CEILING = 0.99
"""Potential from which there is nothing above."""
PERIMETER = 40
"""Cells of moving edge in a frame: about the outline of the robot where an approach begins, 20 cm away."""
MOST = 0.9
"""Share of replicates in which a claim holds that holds in most."""


def explained(row: DetectorRow, edge: EdgeRow) -> DetectorRow:
    """Return the row with its cause."""
    return replace(row, cause="" if row.held == row.replicates else "; ".join(_parts(row, edge)))


def _parts(row: DetectorRow, edge: EdgeRow) -> list[str]:
    if not any(row.spikes):
        silent = f"silent at every angle: its potential peaks at {max(row.peak):.3f}, below {row.threshold:g}"
        return [silent, *_threshold(row)]
    if all(count >= EVERY_FRAME * frames for count, frames in zip(row.spikes, row.frames, strict=True)):
        return ["spikes in nearly every frame, so that the count is how long the trial lasts", *_threshold(row)]
    return [_more(row, edge), *_ceiling(row), *_threshold(row)]


def _more(row: DetectorRow, edge: EdgeRow) -> str:
    """Say which angle it answers more than straight ahead, and how much more edge moves there."""
    most = max(range(1, len(AWAY)), key=lambda index: row.spikes[index])
    cells = edge.cells[most] / edge.cells[0] - 1.0
    frames = edge.frames[PERIMETER][most] - edge.frames[PERIMETER][0]
    return (
        f"{row.spikes[most]:.1f} spikes at {AWAY[most]:g} degrees, {row.spikes[0]:.1f} straight ahead; moving edge "
        f"there {cells:+.1%}, {frames:+.1f} frames with {PERIMETER} cells or more"
    )


def _ceiling(row: DetectorRow) -> list[str]:
    return ["its potential reaches its ceiling at every angle"] if min(row.peak) >= CEILING else []


def _threshold(row: DetectorRow) -> list[str]:
    """Return whether a constant of another camera decides."""
    at = f"{row.held_at_best} of {row.replicates} replicates at {row.best_threshold:g}"
    if row.held_at_best >= MOST * row.replicates:
        return [f"the threshold decides: counting frames, it would hold in {at}"]
    if not row.held_at_best:
        return ["counting frames, no threshold from 0.52 to 0.98 would make it hold"]
    return [f"counting frames, no threshold would make it hold in most replicates (at best in {at})"]


def tabled(counts: "Counts") -> Tables:
    """Say what each detector counts in each arena and why C21 does not hold, and how much edge moves there."""
    edges: dict[str, EdgeRow] = {}
    rows: list[DetectorRow] = []
    panel = {detector.label: detector for detector in PANEL}
    for point, model in counts.plan.judged:
        ((_, arena),) = point.values
        every = counts.replicates(point, model)
        if arena not in edges:
            edges[arena] = edge_row(arena, model, every)
        held = counts.cell(CLAIM, model, arena=arena).count.holds
        rows.append(explained(detector_row(arena, panel[model], every, held), edges[arena]))
    return {
        "Detectors": [
            {
                "arena": row.arena, "detector": row.label, "constants": row.preset, "threshold": row.threshold,
                "held": row.held, "held by the rule": row.held_by_collision, "held by the peak": row.held_by_peak,
                "spikes at 0, 15, 30": row.spikes, "peak potential": row.peak, "frames": row.frames,
                "share announced": row.announced, "frames announced": row.collision_frames,
                "best threshold": row.best_threshold, "held there": row.held_at_best, "why it fails": row.cause,
                "threshold from": row.source,
            }
            for row in rows
        ],
        "Moving edge, counted as if it were a detector": [
            {
                "arena": edge.arena, "cells at 0, 15, 30": edge.cells, "held": edge.held,
                **{f"frames with {level}": numbers for level, numbers in edge.frames.items()},
                **{f"held by {level}": held for level, held in edge.held_by_frames.items()},
            }
            for edge in edges.values()
        ],
    }  # fmt: skip


STUDY = Study(
    name="detectors",
    summary="C21 of every looming detector and preset, in the bright and the dim arena",
    claims=(CLAIM,),
    experiments=("angular-approach",),
    axes=(ARENA,),
    models=tuple(detector.label for detector in PANEL),
    probe=Probe(work, schema),
    tables=tabled,
)
