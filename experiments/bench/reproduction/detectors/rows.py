"""What C21 comes to for one detector in one arena, with the numbers that say why."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from experiments.bench.engine.models import ConfiguredModel
from experiments.bench.judging.statistics import proportion_interval
from experiments.bench.judging.verdict import Judged
from experiments.bench.reproduction.detectors.measure import EDGE_LEVELS, THRESHOLDS
from experiments.bench.reproduction.detectors.panel import CLAIM, Detector, spikes_in_a_row
from experiments.bench.robot.claims import outcome
from experiments.bench.robot.judging import ANGLES

AWAY = tuple(sorted({abs(angle) for angle in ANGLES}))
"""Angles to the axis, 0, 15 and 30 degrees: left and right are taken together."""
Rows = Sequence[Mapping[str, Any]]
Triple = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Shown:
    """One replicate's trials in one arena.

    Parameters
    ----------
    rows
        Those of `experiments.bench.reproduction.detectors.measure.SCHEMA`, of all detectors.
    models
        The detectors with their parameters.
    verdicts
        Detector -> what C21 comes to for it here. A replicate is judged once.
    """

    rows: tuple[Mapping[str, Any], ...]
    models: tuple[ConfiguredModel, ...]
    verdicts: Mapping[str, Judged]

    def of(self, label: str) -> list[Mapping[str, Any]]:
        """Return the rows of one detector; ``spikes`` are those of looming, of one that tells direction too."""
        return [{**row, "spikes": row["looming_spikes"]} for row in self.rows if row["model"] == label]

    def model(self, label: str) -> ConfiguredModel:
        """Return one detector with its parameters."""
        return next(model for model in self.models if model.label == label)


@dataclass(frozen=True, slots=True)
class DetectorRow:
    """What C21 comes to for one detector in one arena. Triples are of 0, 15 and 30 degrees to the axis.

    Parameters
    ----------
    arena, label, preset, source
        The arena, the detector as ``--model`` takes it, what its constants are called, where its threshold is from.
    threshold
        Its spike threshold on the potential.
    in_a_row
        Spikes without a silent frame between them that mean a collision to it.
    held, untested, replicates
        In how many of ``replicates`` C21 held, and in how many it could not be judged.
    low, high
        The exact 95 % interval of the share in which it held.
    spikes, peak, frames
        Mean spikes of a trial, mean highest potential, mean number of frames.
    announced, collision_frames
        Share of trials in which it announces a collision, ``in_a_row`` spikes; mean number of frames in which it does.
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
    in_a_row: int
    held: int
    untested: int
    replicates: int
    low: float
    high: float
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


def shown_in(rows: Rows, trials: int, models: tuple[ConfiguredModel, ...]) -> Shown:
    """Judge C21 for each detector in one replicate and arena; it is untested where one of the ``trials`` failed."""
    bare = Shown(tuple(rows), models, {})
    verdicts: dict[str, Judged] = {}
    for model in models:
        own = bare.of(model.label)
        whole = len(own) == trials
        verdicts[model.label] = outcome(CLAIM, own, model.thresholds["looming"]).verdict if whole else "not shown"
    return replace(bare, verdicts=verdicts)


def detector_row(arena: str, detector: Detector, shown: Sequence[Shown]) -> DetectorRow:
    """Judge C21 for one detector in every replicate; ``cause`` is left empty."""
    model = shown[0].model(detector.label)
    threshold = model.thresholds["looming"]
    assert threshold is not None
    every = [each.of(detector.label) for each in shown]
    judged = [each.verdicts[detector.label] for each in shown]
    held = judged.count("holds")
    low, high = proportion_interval(held, len(judged))
    at = [_held_by(every, _entry("frames_above", index)) for index in range(len(THRESHOLDS))]
    best = max(range(len(THRESHOLDS)), key=lambda index: at[index])
    trials = [row for rows in every for row in rows]
    frames, peak = _column("collision_frames"), _column("peak_looming")
    return DetectorRow(
        arena=arena, label=detector.label, preset=detector.preset, source=detector.source, threshold=threshold,
        in_a_row=spikes_in_a_row(model.network), held=held,
        untested=judged.count("not shown"), replicates=len(judged), low=low, high=high,
        spikes=_means(trials, _column("spikes")), peak=_means(trials, peak), frames=_means(trials, _column("frames")),
        announced=_means(trials, lambda row: float(row["collision_frames"] > 0)),
        collision_frames=_means(trials, frames), held_by_collision=_held_by(every, frames),
        held_by_peak=_held_by(every, peak), best_threshold=THRESHOLDS[best], held_at_best=at[best],
    )  # fmt: skip


def edge_row(arena: str, label: str, shown: Sequence[Shown]) -> EdgeRow:
    """Count the moving edge of all trials; it is the same in the rows of every detector, and read in those of one."""
    every = [each.of(label) for each in shown]
    trials = [row for rows in every for row in rows]
    levels = {level: _entry("edge_frames", index) for index, level in enumerate(EDGE_LEVELS)}
    frames = {level: _means(trials, of) for level, of in levels.items()}
    held = {level: _held_by(every, of) for level, of in levels.items()}
    cells = _column("edge_cells")
    return EdgeRow(arena, _means(trials, cells), frames, _held_by(every, cells), held, len(every))


def _held_by(every: Sequence[Rows], count: Callable[[Mapping[str, Any]], float]) -> int:
    """In how many replicates C21 would hold if ``count`` of a trial stood for its spikes: most at 0 degrees."""
    found = 0
    for rows in every:
        means = {angle: _mean([count(row) for row in rows if row["angle_deg"] == angle]) for angle in ANGLES}
        found += all(means[0.0] > mean for angle, mean in means.items() if angle)
    return found


def _mean(values: Sequence[float]) -> float:
    """A mean; NaN of nothing, which is more than nothing."""
    return sum(values) / len(values) if values else math.nan


def _means(rows: Rows, value: Callable[[Mapping[str, Any]], float]) -> Triple:
    """The mean over trials at each of `AWAY`; NaN where there is no trial."""
    found = [[value(row) for row in rows if abs(row["angle_deg"]) == angle] for angle in AWAY]
    straight, middle, far = map(_mean, found)
    return straight, middle, far


def _column(name: str) -> Callable[[Mapping[str, Any]], float]:
    return lambda row: float(row[name])


def _entry(name: str, index: int) -> Callable[[Mapping[str, Any]], float]:
    return lambda row: float(row[name][index])
