"""What a map is: claims and measures, axes, every trial of its grid, and which trials are of which point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from experiments.bench.clips.experiment import Showing
from experiments.bench.engine.models import ConfiguredModel
from experiments.bench.judging.claim import Claim
from experiments.bench.maps.axes import Axis
from experiments.bench.maps.measures import Measure
from experiments.bench.robot.experiment import TrialSpec
from experiments.bench.robot.sweep.grid import Point
from experiments.bench.store.parameters import Parameters


@dataclass(frozen=True, slots=True)
class Asked:
    """What a person asked for, beside the experiments.

    Parameters
    ----------
    over
        ``KEY=V1,V2`` texts, one for each axis.
    claims, measures
        Ids of claims, names of measures. With neither: all claims that the experiments declare and that are about the
        model.
    model
        The model judged, as ``--model`` has it.
    assignments
        ``KEY=VALUE`` texts that hold at every point.
    repeats
        Trials of each condition in a replicate; ``None``: the experiment's own number. Clips have none.
    replicates
        Number of replicates. Replicate k has the seed ``seed`` + k.
    seed
        Seed of replicate 0.
    """

    over: Sequence[str]
    claims: Sequence[str] = ()
    measures: Sequence[str] = ()
    model: str = "dsnn"
    assignments: Sequence[str] = ()
    repeats: int | None = None
    replicates: int = 1
    seed: int = 0


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
    """

    label: str
    name: str
    threshold: float | None


@dataclass(frozen=True, slots=True)
class Share:
    """The trials that answer for some points in one replicate of one experiment.

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
class MapPlan:
    """A map to make, checked.

    Parameters
    ----------
    claims, measures
        Claims and measures, each with the name of the experiment whose trials answer for it.
    axes, points
        The grid. The points are in the order of the axes' levels, the last axis fastest.
    model
        The model judged, without the grid's values.
    seed, replicates
        Seed of replicate 0, and the number of replicates.
    repeats
        Trials of each condition in a replicate, of each experiment.
    specs
        Every trial, or every clip to show, a whole replicate of the map before the next.
    shares
        Which trials are of which point: (point, experiment, replicate) -> its trials.
    description
        What ``experiment.json`` holds: every parameter, the grid, claims and measures, and what computes it.
    parameters
        The grid's values as columns of the table of trials.
    """

    claims: tuple[tuple[Claim, str], ...]
    measures: tuple[tuple[Measure, str], ...]
    axes: tuple[Axis, ...]
    points: tuple[Point, ...]
    model: ConfiguredModel
    seed: int
    replicates: int
    repeats: tuple[int, ...]
    specs: tuple[TrialSpec, ...] | tuple[Showing, ...]
    shares: Mapping[tuple[Point, str, int], Share]
    description: Mapping[str, Any]
    parameters: Parameters

    @property
    def things(self) -> str:
        """What it runs, in a word."""
        return "clips" if isinstance(self.specs[0], Showing) else "trials"

    def share(self, point: Point, experiment: str, replicate: int) -> Share:
        """The trials of a point."""
        return self.shares[point, experiment, replicate]
