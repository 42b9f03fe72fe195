"""A study of experiments with the robot.

Points and models that differ in the network alone share their frames: they are models of the same trials. A trial that
no point changes, as its experiment lacks what an axis moves, is run once and counts at every point.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from experiments.bench.engine.pictures import Pictures
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import ConfiguredModel, SelectedModel, look_up
from experiments.bench.run.settings import check_counts
from experiments.bench.sources.experiment import Experiment
from experiments.bench.sources.robot import RobotTrial
from experiments.bench.sources.robot_claims import RobotClaim, find
from experiments.bench.sources.rows import TRIAL_SCHEMA
from experiments.bench.store import provenance
from experiments.bench.studies import choice, grid
from experiments.bench.studies.grid import Base, Point, Values
from experiments.bench.studies.measures import Measure
from experiments.bench.studies.plan import EVERY_MODEL, Share, StudyPlan, Watcher, shown_at, study_description
from experiments.bench.studies.study import Axis, Study
from experiments.bench.trials import Plan, describe, plan, sections
from experiments.bench.trials import sources as plan_sources

Claims = choice.Chosen[RobotClaim]
Measures = Sequence[tuple[Measure, str]]


@dataclasses.dataclass(frozen=True, slots=True)
class Rendering:
    """Trials of one experiment that several points and models share.

    Parameters
    ----------
    plan
        Its plan in replicate 0; its models are the variants shown.
    watchers
        Point and model -> the models that are judged there, by their labels in these trials.
    """

    plan: Plan
    watchers: Mapping[tuple[Point, str], tuple[Watcher, ...]]


def planned(
    study: Study, experiments: Sequence[Experiment], seed: int, models_in: Mapping[str, Sequence[str]],
    pictures: Pictures | None = None,
) -> StudyPlan:  # fmt: skip
    """Check and list all that a study of trials with the robot runs.

    Parameters
    ----------
    study
        The study.
    experiments
        Those whose trials answer for claims and measures. One that answers for none of them is not run, unless the
        study judges each claim on the models that it is about.
    seed
        Of replicate 0.
    models_in
        Experiment -> the models shown there, all judged together, in place of the study's; empty: the study's models
        are judged one by one.
    pictures
        The wall of the arena has one of them in each replicate.

    Raises
    ------
    UsageError
        A claim, a measure, a key, a value or a number is not legal, or a replicate is too small for a claim.
    """
    check_counts(seed, study.replicates, "--replicates")
    choice.check_names([experiment.name for experiment in experiments])
    selected = {experiment.name: look_up(models_in.get(experiment.name, study.models)) for experiment in experiments}
    models = tuple(model.chosen for model in look_up(study.models))
    claims = choice.claims(experiments, study, find, lambda claim: "" if models_in else _refused(claim, models),
                           counts_spikes=True)  # fmt: skip
    declared = {
        (experiment.name, model.asked.text): _base(
            experiment, model.asked.text, sections(experiment, [model.asked.text])
        )
        for experiment in experiments
        for model in selected[experiment.name]
    }
    grid.check_assignments(list(declared.values()), study.assignments)
    plans = {
        (experiment.name, model.asked.text): plan(
            experiment, [model.asked.text], declared[experiment.name, model.asked.text].applying(study.assignments),
            study.repeats, seed, pictures,
        )
        for experiment in experiments
        for model in selected[experiment.name]
    }  # fmt: skip
    bases = {key: _of_plan(run_plan, key[1]) for key, run_plan in plans.items()}
    conditions = {name: run_plan.experiment.conditions() for (name, _), run_plan in plans.items()}
    of_spikes = not claims and not study.measures
    channels = [channel for model in models for channel in model.channels]
    measures = choice.measures(conditions, study, "robot", channels, of_spikes=of_spikes)
    on = {name for _, name in (*claims, *measures)}
    answering = [experiment for experiment in experiments if models_in or experiment.name in on]
    there = {key: base for key, base in bases.items() if key[0] in {experiment.name for experiment in answering}}
    grid.check_assignments([declared[key] for key in there], study.assignments)
    _check_repeats(claims, {name: run_plan.repeats for (name, _), run_plan in plans.items()}, study)
    grid.check_levels(study.axes, list(there.values()), study.name, TRIAL_SCHEMA.names())
    axes = study.axes + (grid.axes_of(study.over, list(there.values()), study.assignments) if study.over else ())
    points = grid.points_of([(axis.name, axis.labels) for axis in axes])
    renderings: list[Rendering] = []
    called: list[tuple[str, Point, Base]] = []
    for experiment in answering:
        added, names = _renderings(
            experiment, selected[experiment.name], there, axes, points, study, seed, bool(models_in), pictures
        )
        renderings += added
        called += names
    if any(measure.conditions for measure, _ in measures):  # an axis may move the conditions themselves
        every = {name: [c for part in renderings if part.plan.experiment.name == name
                        for c in part.plan.experiment.conditions()] for name in conditions}  # fmt: skip
        measures = choice.measures(every, study, "robot", channels, of_spikes=of_spikes)
    for part in renderings:
        where = "; ".join(model.label for model in part.plan.settings.models[:1])
        choice.check_given(measures, part.plan.experiment.name, part.plan.experiment.conditions(), where)
    trials = sum(part.plan.repeats * len(part.plan.experiment.conditions()) for part in renderings)
    check_counts(seed, study.replicates, "--replicates", trials)
    motions = None if study.every_trial else _motions(claims, measures)
    specs: list[RobotTrial] = []
    shares: dict[tuple[Point, str, str, int], Share] = {}
    for replicate in range(study.replicates):
        for part in renderings:
            replicate_specs = _specs(part.plan, replicate, len(specs), motions)
            numbers = range(len(specs), len(specs) + len(replicate_specs))
            specs += replicate_specs
            for (point, model), watchers in part.watchers.items():
                name = part.plan.experiment.name
                shares[point, model, name, replicate] = Share(name, replicate, numbers, watchers)
    judged = tuple(dict.fromkeys((point, model) for point, model, _, replicate in shares if not replicate))
    order = {point: place for place, point in enumerate(points)}
    names_in_order = {model.label: place for place, model in enumerate(models)}
    judged = tuple(sorted(judged, key=lambda key: (order[key[0]], names_in_order.get(key[1], 0))))
    parameters = grid.columns(called, axes)
    first = {
        name: run_plan
        for (name, _), run_plan in reversed(plans.items())
        if name in {experiment.name for experiment in answering}
    }
    own_plans = [first[experiment.name] for experiment in answering]
    return StudyPlan(
        study, claims, measures, axes, tuple(points), models, judged, seed, study.replicates,
        tuple(run_plan.repeats for run_plan in own_plans), tuple(specs), shares,
        study_description(_description(own_plans, study, renderings, parameters, len(specs)), axes, claims, measures,
                          study.replicates),
        parameters,
    )  # fmt: skip


def _refused(claim: RobotClaim, models: Sequence[ConfiguredModel]) -> str:
    """Say why a claim is about none of the models judged, in words; empty if it is about one."""
    labels = ", ".join(model.label for model in models)
    channel = "looming" if claim.about == "looming" else "hs"
    if not any(channel in model.channels for model in models):
        do = "do" if len(models) > 1 else "does"
        return f"it is about models that answer by {claim.about}, and {labels} {do} not"
    if any(not claim.models <= {model.label} for model in models):
        return f"it compares models with each other, and a study with the robot judges {labels} alone"
    return ""


def _base(experiment: Experiment, model: str, values: dict[str, Any]) -> Base:
    return Base(experiment.name, model, {section: (value,) for section, value in values.items()})


def _of_plan(run_plan: Plan, model: str) -> Base:
    """Return an experiment before one model as its plan has it: with the values of ``--set``."""
    settings = run_plan.settings
    (selected,) = look_up([model])
    section = selected.section
    values = {section: settings.models[0].network, "robot": settings.robot, "camera": settings.camera,
              "scene": settings.scene, "experiment": run_plan.experiment.design}  # fmt: skip
    settled = frozenset(f"{section}.{name}" for name in selected.asked.values)
    return dataclasses.replace(_base(run_plan.experiment, settings.models[0].label, values), settled=settled)


def _renderings(
    declared: Experiment, selected: Sequence[SelectedModel], bases: Mapping[tuple[str, str], Base],
    axes: Sequence[Axis], points: Sequence[Point], study: Study, seed: int, together: bool,
    pictures: Pictures | None,
) -> tuple[list[Rendering], list[tuple[str, Point, Base]]]:  # fmt: skip
    """Return the renderings of one experiment; and every label in them, with its point and the experiment before it."""
    texts = [model.asked.text for model in selected]
    values = {
        (point, model): grid.expanded(point, axes, bases[declared.name, model])
        for point in points
        for model in shown_at(point, axes, texts)
    }
    if study.over:
        whole = _base(declared, "", sections(declared, texts))
        grid.check_settled(grid.expanded(points[0], axes, whole), selected)
    inside = {model.section for model in selected}
    renderings: list[Rendering] = []
    called: list[tuple[str, Point, Base]] = []
    for outside, members in grid.by_rendering(values.values(), inside).items():
        keys = [key for key, point_values in values.items() if point_values in members]
        here = [model for model in selected if any(model.asked.text == asked for _, asked in keys)]
        common = _planned(declared, here, study, outside, bases, seed, pictures)
        variants: dict[str, ConfiguredModel] = {}
        labels: dict[tuple[Point, str], Watcher] = {}
        known: dict[tuple[str, Values], str] = {}
        for model, chosen in zip(here, common.settings.models, strict=True):
            base = bases[declared.name, model.asked.text]
            for point, asked in keys:
                if asked != model.asked.text:
                    continue
                point_values = values[point, asked]
                prefix = "" if model is selected[0] else chosen.label
                name = known.setdefault((asked, point_values), grid.label(point, axes, base, prefix))
                called.append((name, point, base))
                if name not in variants:
                    variants[name] = grid.variant(chosen, name, grid.own_values(model, point_values))
                labels[point, chosen.label] = Watcher.of(variants[name], chosen.label)
        settings = dataclasses.replace(common.settings, models=tuple(variants.values()))
        watchers: dict[tuple[Point, str], tuple[Watcher, ...]] = {key: (watcher,) for key, watcher in labels.items()}
        if together:
            watchers = {
                (point, EVERY_MODEL): tuple(watcher for (where, _), watcher in labels.items() if where == point)
                for point, _ in labels
            }
        renderings.append(Rendering(dataclasses.replace(common, settings=settings), watchers))
    return renderings, called


def _planned(
    declared: Experiment, selected: Sequence[SelectedModel], study: Study, outside: Values,
    bases: Mapping[tuple[str, str], Base], seed: int, pictures: Pictures | None,
) -> Plan:  # fmt: skip
    """Return the plan of one rendering; a refusal names the option that its value came by."""
    over = [f"{key}={value}" for key, value in outside]
    texts = [model.asked.text for model in selected]
    known = {text for model in texts for text in bases[declared.name, model].applying(study.assignments)}
    assignments = [text for text in study.assignments if text in known]
    try:
        return plan(declared, texts, [*assignments, *over], study.repeats, seed, pictures)
    except UsageError as error:
        message = str(error)
        if any(message.startswith(f"--set {text}:") for text in over):
            message = message.replace("--set", "--over", 1)
        raise UsageError(message) from error


def _motions(claims: Claims, measures: Measures) -> Mapping[str, set[str]]:
    """Experiment -> the motions that what is asked of it is judged on."""
    motions: dict[str, set[str]] = {}
    for claim, on in claims:
        motions.setdefault(on, set()).update(claim.motions)
    for measure, on in measures:
        motions.setdefault(on, set()).update(measure.motions)
    return motions


def _specs(part: Plan, replicate: int, first: int, motions: Mapping[str, set[str]] | None) -> list[RobotTrial]:
    """Return the trials of a rendering in one replicate, numbered from ``first``; their seeds are those of a run alone.

    Repeat r of replicate k counts as k times the number of repeats, plus r.
    """
    whole = part.replicate(replicate).specs()
    if motions is not None:
        whole = [
            spec for spec in whole if spec.condition.path or spec.condition.motion in motions[part.experiment.name]
        ]
    return [
        dataclasses.replace(spec, index=first + place, repeat=replicate * part.repeats + spec.repeat)
        for place, spec in enumerate(whole)
    ]


def _check_repeats(claims: Claims, repeats: Mapping[str, int], study: Study) -> None:
    """Raise `UsageError` for replicates that are too small for a claim of a grid that was typed to be judged."""
    for claim, name in claims:
        if study.over and repeats[name] < claim.least:
            raise UsageError(
                f"--repeats {repeats[name]}: {claim.id} needs at least {claim.least} trials of each condition"
            )


def _description(
    plans: Sequence[Plan], study: Study, renderings: Sequence[Rendering], parameters: Mapping[str, Any], trials: int
) -> dict[str, Any]:
    """Return what ``run.json`` holds beside the grid: every parameter, and what computes it."""
    first = plans[0]
    models = {model.label: model for rendering in renderings for model in rendering.plan.settings.models}
    sources = [model.source for model in models.values()]
    files = [path for run_plan in plans for path in provenance.of(plan_sources(run_plan), run_plan.experiment)["files"]]
    changed = {key: values for run_plan in plans for key, values in run_plan.changed().items()}
    return {
        **describe(first),
        "kind": "map" if study.over else "study",
        "experiments": [run_plan.experiment for run_plan in plans],
        "repeats": [run_plan.repeats for run_plan in plans],
        "trials": trials,
        "models": tuple(models.values()),
        "changed": {**changed, **parameters},
        **provenance.of((*dict.fromkeys(sources), *files, *filter(None, (study.file,))), first.experiment),
    }
