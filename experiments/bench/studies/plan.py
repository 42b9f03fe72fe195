"""A study to run, checked: claims and measures, points and models, every trial, and which trials are of which point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.play import Trial
from experiments.bench.sources.robot import RobotTrial
from experiments.bench.stats.claim import Claim
from experiments.bench.store.parameters import Parameters
from experiments.bench.studies.grid import Point
from experiments.bench.studies.measures import Measure
from experiments.bench.studies.study import Axis, Study

EVERY_MODEL = ""
"""The name under which all models of a study are judged that judges each claim on the models that it is about."""


@dataclass(frozen=True, slots=True)
class Watcher:
    """A model in the trials of a point.

    Parameters
    ----------
    label
        Its label in these trials, which tells the points apart.
    name
        What it is called without the grid's values: what claims know it by.
    threshold
        Its spiking threshold.
    looming
        That of its looming detector; ``None`` where it has none.
    """

    label: str
    name: str
    threshold: float | None
    looming: float | None = None

    @staticmethod
    def of(model: ConfiguredModel, name: str) -> Watcher:
        """Return a model as one that is called ``name`` without the grid's values."""
        return Watcher(model.label, name, model.threshold, model.thresholds.get("looming"))


@dataclass(frozen=True, slots=True)
class Share:
    """The trials that answer for some points and one model in one replicate of one experiment.

    Parameters
    ----------
    experiment
        The experiment's name.
    replicate
        From 0.
    trials
        Their numbers in the run.
    watchers
        The models that see them at these points, the one judged first.
    """

    experiment: str
    replicate: int
    trials: range
    watchers: tuple[Watcher, ...]


@dataclass(frozen=True, slots=True)
class StudyPlan:
    """A study to run, checked.

    Parameters
    ----------
    study
        The study.
    claims, measures
        Claims and measures, each with the name of the experiment whose trials answer for it.
    axes, points
        The grid. The points are in the order of the axes' levels, the last axis fastest.
    models
        The models judged, without the grid's values.
    judged
        Points, each with the name of a model that is judged there, in order.
    seed, replicates
        Seed of replicate 0, and the number of replicates.
    repeats
        Trials of each condition in a replicate, of each experiment.
    specs
        Every trial, or every clip to show, a whole replicate of the study before the next.
    shares
        Which trials are of which point: (point, model, experiment, replicate) -> its trials.
    description
        What ``run.json`` holds: every parameter, the grid, claims and measures, and what computes it.
    parameters
        The grid's values as columns of the table of trials.
    """

    study: Study
    claims: tuple[tuple[Claim, str], ...]
    measures: tuple[tuple[Measure, str], ...]
    axes: tuple[Axis, ...]
    points: tuple[Point, ...]
    models: tuple[ConfiguredModel, ...]
    judged: tuple[tuple[Point, str], ...]
    seed: int
    replicates: int
    repeats: tuple[int, ...]
    specs: tuple[RobotTrial, ...] | tuple[Trial, ...]
    shares: Mapping[tuple[Point, str, str, int], Share]
    description: Mapping[str, Any]
    parameters: Parameters

    @property
    def things(self) -> str:
        """Return what it runs, in a word."""
        return "trials" if isinstance(self.specs[0], RobotTrial) else "clips"

    @property
    def experiments(self) -> tuple[str, ...]:
        """The names of the experiments whose trials it runs."""
        return tuple(dict.fromkeys(experiment for _, _, experiment, _ in self.shares))


def shown_at(point: Point, axes: Sequence[Axis], models: Sequence[str]) -> list[str]:
    """Return those of the models that are shown at a point."""
    limits = [axis.level(label).models for axis, (_, label) in zip(axes, point.values, strict=True)]
    return [model for model in models if all(not limit or model in limit for limit in limits)]


def study_description(
    plan: Mapping[str, Any], axes: Sequence[Axis], claims: Sequence[tuple[Claim, str]],
    measures: Sequence[tuple[Measure, str]], replicates: int,
) -> dict[str, Any]:  # fmt: skip
    """Return what ``run.json`` says of a study beside ``plan``: the grid, claims and measures."""
    levels = {
        axis.name: axis.labels if axis.of_keys else {level.label: level.settings for level in axis.levels}
        for axis in axes
    }
    return {
        **plan,
        "replicates": replicates,
        "axes": levels,
        "claims": [{**claim.described(), "experiment": name} for claim, name in claims],
        "measures": [{**measure.described(), "experiment": name} for measure, name in measures],
    }
