"""What a map is to do: claims, axes, and every trial of its grid; and how ``experiment.json`` tells of it.

Points that differ in the network alone share their frames: they are models of the same trials. A trial that no point
changes, as its experiment lacks what an axis moves, is run once and counts at every point.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from experiments.bench.core.claims.texts import claim_texts
from experiments.bench.core.errors import UsageError
from experiments.bench.core.models import ConfiguredModel, load_model, look_up
from experiments.bench.core.settings import check_counts, collect
from experiments.bench.core.store import provenance
from experiments.bench.core.store.parameters import Parameters
from experiments.bench.robot.claims import RobotClaim, find
from experiments.bench.robot.experiment import Experiment, TrialSpec
from experiments.bench.robot.map.axes import Axis, applying, axes, expanded, knows, moves
from experiments.bench.robot.plan import Plan, describe, plan, sections
from experiments.bench.robot.sweep import grid
from experiments.bench.robot.sweep.grid import Point


@dataclass(frozen=True, slots=True)
class Asked:
    """What a person asked for, beside the experiments.

    Parameters
    ----------
    over
        ``KEY=V1,V2`` texts, one for each axis.
    claims
        Ids of claims; none: all that the experiments declare and that are about the model.
    model
        The model judged, as ``--model`` has it.
    assignments
        ``KEY=VALUE`` texts that hold at every point.
    repeats
        Trials of each condition in a replicate; ``None``: the experiment's own number.
    replicates
        Number of replicates. Replicate k has the seed ``seed`` + k.
    seed
        Seed of replicate 0.
    """

    over: Sequence[str]
    claims: Sequence[str] = ()
    model: str = "dsnn"
    assignments: Sequence[str] = ()
    repeats: int | None = None
    replicates: int = 1
    seed: int = 0


@dataclass(frozen=True, slots=True)
class Share:
    """The trials that answer for some points in one replicate of one experiment.

    Parameters
    ----------
    experiment
        The experiment's name.
    replicate
        From 0.
    model
        The model's label in these trials, which tells the points apart.
    threshold
        Its spiking threshold.
    trials
        Their numbers in the run.
    """

    experiment: str
    replicate: int
    model: str
    threshold: float | None
    trials: range


@dataclass(frozen=True, slots=True)
class MapPlan:
    """A map to make, checked.

    Parameters
    ----------
    plans
        One for each experiment that is run, without the grid's values.
    claims
        The claims, each with the name of the experiment whose trials answer for it.
    axes, points
        The grid. The points are in the order of the axes' levels, the last axis fastest.
    replicates
        Number of replicates.
    specs
        Every trial, a whole replicate of the map before the next.
    shares
        Which trials are of which point: (experiment, label, replicate) -> its trials.
    """

    plans: tuple[Plan, ...]
    claims: tuple[tuple[RobotClaim, str], ...]
    axes: tuple[Axis, ...]
    points: tuple[Point, ...]
    replicates: int
    specs: tuple[TrialSpec, ...]
    shares: Mapping[tuple[str, str, int], Share]

    @property
    def model(self) -> ConfiguredModel:
        """The model judged, without the grid's values."""
        return self.plans[0].settings.models[0]

    @property
    def seed(self) -> int:
        """Seed of replicate 0."""
        return self.plans[0].seed

    def share(self, point: Point, experiment: str, replicate: int) -> Share:
        """The trials of a point."""
        (base,) = [each for each in self.plans if each.experiment.name == experiment]
        return self.shares[experiment, label(point, self.axes, base), replicate]

    def parameters(self) -> Parameters:
        """The grid's values as columns of the table of trials: name of an axis -> label of a model -> value."""
        columns: dict[str, dict[str, Any]] = {axis.name: {} for axis in self.axes}
        for point in self.points:
            for base in self.plans:
                for axis, (_, level) in zip(self.axes, point.values, strict=True):
                    value = axis.values()[axis.levels.index(level)] if moves(axis, base) else None
                    columns[axis.name][label(point, self.axes, base)] = value
        return columns

    def describe(self) -> dict[str, Any]:
        """What ``experiment.json`` holds: every parameter, the grid, the claims, and what computes it."""
        first = self.plans[0]
        files = [path for each in self.plans for path in provenance.of((), each.experiment)["files"]]
        changed = {key: values for each in self.plans for key, values in each.changed().items()}
        return {
            **describe(first),
            "experiment": "map",
            "experiments": [each.experiment for each in self.plans],
            "repeats": [each.repeats for each in self.plans],
            "replicates": self.replicates,
            "trials": len(self.specs),
            "axes": {axis.name: axis.levels for axis in self.axes},
            "claims": [{**claim.described(), "experiment": name} for claim, name in self.claims],
            "changed": {**changed, **self.parameters()},
            **provenance.of((self.model.source, *files), first.experiment),
        }


def label(point: Point, axes_: Sequence[Axis], base: Plan) -> str:
    """What the model is called at a point in the trials of one experiment: by the values that move something there."""
    said = [f"{name}={value}" for axis, (name, value) in zip(axes_, point.values, strict=True) if moves(axis, base)]
    return " ".join(said) or base.settings.models[0].label


def planned(experiments: Sequence[Experiment], asked: Asked) -> MapPlan:
    """Check and list all that a map runs.

    Parameters
    ----------
    experiments
        Those whose trials answer for the claims. One that answers for none of them is not run.
    asked
        The rest of what was asked for.

    Raises
    ------
    UsageError
        A claim, a key, a value or a number is not legal, or a replicate is too small for a claim.
    """
    check_counts(asked.seed, asked.replicates, "--replicates")
    _check_names(experiments)
    claims = _claims(experiments, asked)
    answering = [each for each in experiments if each.name in {name for _, name in claims}]
    _check_assignments(answering, asked)
    plans = tuple(
        plan(each, [asked.model], applying(each, asked.assignments), asked.repeats, asked.seed) for each in answering
    )
    _check_repeats(claims, plans)
    points = grid.grid(asked.over)
    found = axes(points, plans, [asked.model])
    # The order in which values were typed changes neither the numbers of trials nor the tables.
    points.sort(key=lambda point: [axis.levels.index(v) for axis, (_, v) in zip(found, point.values, strict=True)])
    specs: list[TrialSpec] = []
    shares: dict[tuple[str, str, int], Share] = {}
    renderings = [
        (base, part)
        for base, each in zip(plans, answering, strict=True)
        for part in _parts(base, each, found, points, asked)
    ]
    for replicate in range(asked.replicates):
        for base, part in renderings:
            own = _specs(part, replicate, len(specs), claims)
            specs += own
            for model in part.settings.models:
                name, trials = base.experiment.name, range(own[0].index, own[-1].index + 1)
                shares[name, model.label, replicate] = Share(name, replicate, model.label, model.threshold, trials)
    return MapPlan(plans, claims, found, tuple(points), asked.replicates, tuple(specs), shares)


def _parts(
    base: Plan, declared: Experiment, found: Sequence[Axis], points: Sequence[Point], asked: Asked
) -> Iterator[Plan]:
    """The plans of one experiment's renderings in replicate 0, the points that share one as models of it."""
    labels = {Point(expanded(point.values, base)): label(point, found, base) for point in points}
    own = applying(declared, asked.assignments)
    for part in grid.parts(declared, [asked.model], list(labels), own, asked.repeats, asked.seed):
        models = tuple(
            dataclasses.replace(model, label=labels[_point(part.lines[model.label])])
            for model in part.plan.settings.models
        )
        yield dataclasses.replace(part.plan, settings=dataclasses.replace(part.plan.settings, models=models))


def _point(line: grid.Line) -> Point:
    return Point(tuple((key, value) for key, value in line.values.items() if value is not None))


def _specs(part: Plan, replicate: int, first: int, claims: Sequence[tuple[RobotClaim, str]]) -> list[TrialSpec]:
    """The trials of a rendering in one replicate, numbered from ``first``; their seeds are those of a run alone.

    Motions that no claim asked for is judged on are left out. Repeat r of replicate k counts as k times the number of
    repeats, plus r.
    """
    motions = {motion for claim, name in claims if name == part.experiment.name for motion in claim.motions}
    whole = dataclasses.replace(part, seed=part.seed + replicate).specs()
    chosen = [spec for spec in whole if spec.condition.motion in motions]
    return [
        dataclasses.replace(spec, index=first + place, repeat=replicate * part.repeats + spec.repeat)
        for place, spec in enumerate(chosen)
    ]


def _claims(experiments: Sequence[Experiment], asked: Asked) -> tuple[tuple[RobotClaim, str], ...]:
    """The claims with the experiments that answer for them: of those given the first that declares it."""
    declared: dict[str, tuple[RobotClaim, str]] = {}
    for experiment in experiments:
        for claim in map(find, experiment.claims):
            declared.setdefault(claim.id, (claim, experiment.name))
    channels = load_model(look_up([asked.model])[0].chosen.source).channels
    about = [name for name, (claim, _) in declared.items() if claim.concerns(channels)]
    for name in asked.claims:
        if name not in declared and name not in claim_texts():
            raise UsageError(f"--claims {name}: unknown claim; declared there are {', '.join(about) or 'none'}")
        if name not in declared:
            named = ", ".join(experiment.name for experiment in experiments)
            raise UsageError(f"--claims {name}: not declared by {named}, which declare {', '.join(about) or 'none'}")
        if name not in about:
            kind = declared[name][0].about
            raise UsageError(f"--claims {name}: it is about models that answer by {kind}, and {asked.model} does not")
    chosen = list(dict.fromkeys(asked.claims or about))
    if not chosen:
        raise UsageError(f"{', '.join(each.name for each in experiments)}: no claim there is about {asked.model}")
    return tuple(declared[name] for name in chosen)


def _check_names(experiments: Sequence[Experiment]) -> None:
    names = [experiment.name for experiment in experiments]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise UsageError(f"experiment {twice}: it is there twice")


def _check_assignments(experiments: Sequence[Experiment], asked: Asked) -> None:
    """Raise `UsageError` for a key of ``--set`` that none of the experiments has."""
    for text in asked.assignments:
        knowing = [each for each in experiments if knows(each, text.partition("=")[0])]
        collect([text], sections((knowing or experiments)[0], [asked.model]))


def _check_repeats(claims: Sequence[tuple[RobotClaim, str]], plans: Sequence[Plan]) -> None:
    """Raise `UsageError` for replicates that are too small for a claim to be judged."""
    repeats = {each.experiment.name: each.repeats for each in plans}
    for claim, name in claims:
        if repeats[name] < claim.least:
            raise UsageError(
                f"--repeats {repeats[name]}: {claim.id} needs at least {claim.least} trials of each condition"
            )
