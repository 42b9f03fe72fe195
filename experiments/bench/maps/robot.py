"""A map of experiments with the robot.

Points that differ in the network alone share their frames: they are models of the same trials. A trial that no point
changes, as its experiment lacks what an axis moves, is run once and counts at every point.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.models import ConfiguredModel, look_up
from experiments.bench.engine.settings import check_counts
from experiments.bench.maps import choice
from experiments.bench.maps.axes import Axis, Base, check_assignments, columns, expanded, label, ordered
from experiments.bench.maps.measures import Measure
from experiments.bench.maps.plan import Asked, MapPlan, Share, Watcher
from experiments.bench.robot.claims import RobotClaim, find
from experiments.bench.robot.experiment import Experiment, TrialSpec
from experiments.bench.robot.plan import Plan, describe, plan, sections
from experiments.bench.robot.sweep import grid
from experiments.bench.robot.sweep.grid import Point
from experiments.bench.store import provenance
from experiments.bench.store.parameters import Parameters

Claims = choice.Chosen[RobotClaim]
Measures = Sequence[tuple[Measure, str]]


def planned(experiments: Sequence[Experiment], asked: Asked) -> MapPlan:
    """Check and list all that a map of trials with the robot runs.

    Parameters
    ----------
    experiments
        Those whose trials answer for claims and measures. One that answers for none of them is not run.
    asked
        The rest of what was asked for.

    Raises
    ------
    UsageError
        A claim, a measure, a key, a value or a number is not legal, or a replicate is too small for a claim.
    """
    check_counts(asked.seed, asked.replicates, "--replicates")
    choice.check_names([experiment.name for experiment in experiments])
    model = look_up([asked.model])[0].chosen
    claims = choice.claims(experiments, asked, find, lambda claim: _refused(claim, model))
    declared = {each.name: _base(each, asked.model, sections(each, [asked.model])) for each in experiments}
    check_assignments(list(declared.values()), asked.assignments)
    every = {each.name: _planned(each, declared[each.name], asked) for each in experiments}
    conditions = {name: own.experiment.conditions() for name, own in every.items()}
    measures = choice.measures(conditions, asked, "robot", model.channels)
    answering = [each for each in experiments if each.name in {name for _, name in (*claims, *measures)}]
    check_assignments([declared[each.name] for each in answering], asked.assignments)
    plans = tuple(every[each.name] for each in answering)
    _check_repeats(claims, plans)
    bases = [_of_plan(each) for each in plans]
    points, found = ordered(asked.over, bases, asked.assignments)
    renderings = [
        (base, part)
        for base, each in zip(bases, answering, strict=True)
        for part in _parts(base, each, found, points, asked)
    ]
    for base, part in renderings:
        where = "; ".join(model.label for model in part.settings.models[:1])
        choice.check_given(measures, base.name, part.experiment.conditions(), where)
    trials = sum(part.repeats * len(part.experiment.conditions()) for _, part in renderings)
    check_counts(asked.seed, asked.replicates, "--replicates", trials)
    specs, by_label = _trials(renderings, asked.replicates, claims, measures)
    shares = {
        (point, base.name, replicate): by_label[base.name, label(point, found, base), replicate]
        for point in points
        for base in bases
        for replicate in range(asked.replicates)
    }
    repeats = tuple(each.repeats for each in plans)
    parameters = columns(points, found, bases)
    said = _description(plans, claims, measures, found, parameters, asked.replicates, len(specs))
    own = plans[0].settings.models[0]
    return MapPlan(
        claims, measures, found, tuple(points), own, asked.seed, asked.replicates, repeats, tuple(specs), shares, said,
        parameters,
    )  # fmt: skip


def _refused(claim: RobotClaim, model: ConfiguredModel) -> str:
    """Why a claim is not about the model judged, in words; empty if it is."""
    if not claim.concerns(model.channels):
        return f"it is about models that answer by {claim.about}, and {model.label} does not"
    if not claim.models <= {model.label}:
        return f"it compares models with each other, and a map with the robot shows {model.label} alone"
    return ""


def _base(experiment: Experiment, model: str, values: dict[str, Any]) -> Base:
    return Base(experiment.name, model, {section: (value,) for section, value in values.items()})


def _of_plan(made: Plan) -> Base:
    """An experiment as its plan has it: with the values of ``--set``."""
    model, settings = made.settings.models[0], made.settings
    section = look_up([model.source])[0].section
    own = {section: model.network, "robot": settings.robot, "camera": settings.camera, "scene": settings.scene}
    return _base(made.experiment, model.label, {**own, "experiment": made.experiment.design})


def _planned(experiment: Experiment, declared: Base, asked: Asked) -> Plan:
    return plan(experiment, [asked.model], declared.applying(asked.assignments), asked.repeats, asked.seed)


def _parts(
    base: Base, declared: Experiment, found: Sequence[Axis], points: Sequence[Point], asked: Asked
) -> Iterator[Plan]:
    """The plans of one experiment's renderings in replicate 0, the points that share one as models of it."""
    labels = {Point(expanded(point.values, base)): label(point, found, base) for point in points}
    own = base.applying(asked.assignments)
    for part in grid.parts(declared, [asked.model], list(labels), own, asked.repeats, asked.seed):
        models = tuple(
            dataclasses.replace(model, label=labels[_point(part.lines[model.label])])
            for model in part.plan.settings.models
        )
        yield dataclasses.replace(part.plan, settings=dataclasses.replace(part.plan.settings, models=models))


def _point(line: grid.Line) -> Point:
    return Point(tuple((key, value) for key, value in line.values.items() if value is not None))


def _trials(
    renderings: Sequence[tuple[Base, Plan]], replicates: int, claims: Claims, measures: Measures
) -> tuple[list[TrialSpec], dict[tuple[str, str, int], Share]]:
    """Every trial, and which of them are whose: (experiment, label, replicate) -> its trials."""
    specs: list[TrialSpec] = []
    shares: dict[tuple[str, str, int], Share] = {}
    for replicate in range(replicates):
        for base, part in renderings:
            own = _specs(part, replicate, len(specs), claims, measures)
            specs += own
            for model in part.settings.models:
                trials = range(own[0].index, own[-1].index + 1)
                watcher = Watcher(model.label, base.model, model.threshold)
                shares[base.name, model.label, replicate] = Share(base.name, replicate, trials, (watcher,))
    return specs, shares


def _specs(part: Plan, replicate: int, first: int, claims: Claims, measures: Measures) -> list[TrialSpec]:
    """The trials of a rendering in one replicate, numbered from ``first``; their seeds are those of a run alone.

    Motions that nothing asked for is judged on are left out. Repeat r of replicate k counts as k times the number of
    repeats, plus r.
    """
    name = part.experiment.name
    motions = {motion for claim, on in claims if on == name for motion in claim.motions}
    motions |= {"translation" for _, on in measures if on == name}
    whole = dataclasses.replace(part, seed=part.seed + replicate).specs()
    chosen = [spec for spec in whole if spec.condition.motion in motions]
    return [
        dataclasses.replace(spec, index=first + place, repeat=replicate * part.repeats + spec.repeat)
        for place, spec in enumerate(chosen)
    ]


def _check_repeats(claims: Claims, plans: Sequence[Plan]) -> None:
    """Raise `UsageError` for replicates that are too small for a claim to be judged."""
    repeats = {each.experiment.name: each.repeats for each in plans}
    for claim, name in claims:
        if repeats[name] < claim.least:
            raise UsageError(
                f"--repeats {repeats[name]}: {claim.id} needs at least {claim.least} trials of each condition"
            )


def _description(
    plans: Sequence[Plan], claims: Claims, measures: Measures, found: Sequence[Axis], parameters: Parameters,
    replicates: int, trials: int,
) -> dict[str, Any]:  # fmt: skip
    """What ``experiment.json`` holds: every parameter, the grid, claims and measures, and what computes it."""
    first, model = plans[0], plans[0].settings.models[0]
    files = [path for each in plans for path in provenance.of((), each.experiment)["files"]]
    changed = {key: values for each in plans for key, values in each.changed().items()}
    return {
        **describe(first),
        "kind": "map",
        "experiment": "map",
        "experiments": [each.experiment for each in plans],
        "repeats": [each.repeats for each in plans],
        "replicates": replicates,
        "trials": trials,
        "axes": {axis.name: axis.levels for axis in found},
        "claims": [{**claim.described(), "experiment": name} for claim, name in claims],
        "measures": [{**measure.described(), "experiment": name} for measure, name in measures],
        "changed": {**changed, **parameters},
        **provenance.of((model.source, *files), first.experiment),
    }
