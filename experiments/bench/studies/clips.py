"""A study of off-line experiments: clips of stimuli.

A replicate has each clip once, at one seed and before one scene. The keys are those of the models, and those of the
clips' stimuli: ``cluttered.grey`` is the grey of every ``cluttered`` clip. Points that differ in the network alone
share their clips. Clips that a point makes alike are shown once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from experiments.bench.engine.pictures import Pictures
from experiments.bench.offline import OfflinePlan
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import ConfiguredModel, SelectedModel, look_up
from experiments.bench.run.play import Trial
from experiments.bench.run.settings import changed, check_counts, watchers
from experiments.bench.sources.clip_claims import ClipClaim, find
from experiments.bench.sources.clips import TRIALS, Clip, OfflineExperiment, clips_of, described_scenes
from experiments.bench.store import provenance
from experiments.bench.store.parameters import Parameters, differing
from experiments.bench.studies import choice, grid
from experiments.bench.studies.grid import Base, Point, Values
from experiments.bench.studies.measures import SPIKES
from experiments.bench.studies.plan import Share, StudyPlan, Watcher, study_description
from experiments.bench.studies.study import Axis, Study

Texts = Mapping[str, Mapping[str, str]]
"""Section -> name -> text."""


@dataclasses.dataclass(frozen=True, slots=True)
class Offline:
    """One experiment of a study, without the grid's values.

    Parameters
    ----------
    declared
        The experiment.
    clips
        Its clips as ``--set`` has them.
    selected, models
        The model judged and those that its claims compare it with: what was asked of them, and what they are.
    base
        What the axes see of it.
    """

    declared: OfflineExperiment
    clips: tuple[Clip, ...]
    selected: tuple[SelectedModel, ...]
    models: tuple[ConfiguredModel, ...]
    base: Base

    def before(self, place: int) -> Base:
        """Return what the axes see of it before one of its models; all of it before the first, which is judged."""
        if not place:
            return self.base
        others = {model.section for model in self.selected} - {self.selected[place].section}
        values = {section: value for section, value in self.base.values.items() if section not in others}
        return dataclasses.replace(self.base, values=values)


@dataclasses.dataclass(frozen=True, slots=True)
class Rendering:
    """Points that share their clips: the clips, the variants of the models, and those that are of each point."""

    base: Base
    clips: tuple[Clip, ...]
    models: tuple[ConfiguredModel, ...]
    watchers: Mapping[Point, tuple[Watcher, ...]]


def planned(
    study: Study, experiments: Sequence[OfflineExperiment], seed: int, pictures: Pictures | None = None
) -> StudyPlan:
    """Check and list all that a study of clips shows.

    Parameters
    ----------
    study
        The study.
    experiments
        Those whose clips answer for claims and measures. One that answers for none of them is not shown.
    seed
        Of replicate 0.
    pictures
        Shown in place of the scenes.

    Raises
    ------
    UsageError
        A claim, a measure, a key, a value or a number is not legal.
    """
    if study.over and study.repeats is not None:
        raise UsageError(f"--repeats {study.repeats}: a replicate has each clip once; --replicates has more seeds")
    if len(study.models) > 1:
        raise UsageError(f"models {', '.join(study.models)}: clips are judged of one model at a time")
    check_counts(seed, study.replicates, "--replicates")
    choice.check_names([experiment.name for experiment in experiments])
    model = look_up(study.models, "offline")[0].chosen
    claims = choice.claims(experiments, study, find, lambda claim: _refused(claim, model))
    if SPIKES in study.measures:
        raise UsageError(f"--measure {SPIKES}: it needs trials with the robot; {experiments[0].name} has clips")
    clips = {experiment.name: [clip.build(seed).params for clip in experiment.clips] for experiment in experiments}
    measures = choice.measures(clips, study, "clips", model.channels)
    answering = [
        experiment for experiment in experiments if experiment.name in {name for _, name in (*claims, *measures)}
    ]
    plain = [offline(experiment, study, seed, claims, ()) for experiment in answering]
    grid.check_assignments([part.base for part in plain], study.assignments)
    parts = [offline(experiment, study, seed, claims, before.base.applying(study.assignments))
            for experiment, before in zip(answering, plain, strict=True)]  # fmt: skip
    bases = [part.base for part in parts]
    grid.check_levels(study.axes, bases, study.name, TRIALS.names())
    axes = study.axes + (grid.axes_of(study.over, bases, study.assignments) if study.over else ())
    points = grid.points_of([(axis.name, axis.labels) for axis in axes])
    renderings = [rendering for part in parts for rendering in _renderings(part, axes, points)]
    for rendering in renderings:
        params = [clip.build(seed).params for clip in rendering.clips]
        choice.check_given(measures, rendering.base.name, params, next(iter(rendering.watchers.values()))[0].label)
    clips_shown = sum(len(rendering.clips) for rendering in renderings)
    check_counts(seed, study.replicates, "--replicates", clips_shown, "clips")
    specs: list[Trial] = []
    shares: dict[tuple[Point, str, str, int], Share] = {}
    for replicate in range(study.replicates):
        for rendering in renderings:
            trials = range(len(specs), len(specs) + len(rendering.clips))
            specs += [
                Trial(rendering.base.name, index, replicate, seed + replicate, clip, rendering.models)
                for index, clip in zip(trials, clips_of(rendering.clips, replicate, pictures), strict=True)
            ]
            for point, watching in rendering.watchers.items():
                key = (point, model.label, rendering.base.name, replicate)
                shares[key] = Share(rendering.base.name, replicate, trials, watching)
    called = [
        (_called(part, place, axes, point), point, part.before(place))
        for point in points
        for part in parts
        for place in range(len(part.models))
    ]
    parameters = grid.columns(called, axes)
    about = study_description(
        _description(parts, study, parameters, seed, len(specs), pictures), axes, claims, measures, study.replicates
    )
    return StudyPlan(
        study, claims, measures, axes, tuple(points), (parts[0].models[0],),
        tuple((point, model.label) for point in points), seed, study.replicates, (1,) * len(parts), tuple(specs),
        shares, about, parameters,
    )  # fmt: skip


def points_of_run(study: Study, run_plan: OfflinePlan) -> StudyPlan:
    """Return the plan of a study whose points are read off a run of an experiment, with the replicates of that run."""
    by_label = {model.label: model for model in run_plan.models}
    model = by_label[study.models[0]]
    claims = choice.claims([run_plan.experiment], study, find, lambda _: "")
    axes = study.axes
    points = grid.points_of([(axis.name, axis.labels) for axis in axes])
    size = len(run_plan.experiment.clips)
    shares: dict[tuple[Point, str, str, int], Share] = {}
    for point in points:
        plays = {name: label for axis, (_, level) in zip(axes, point.values, strict=True)
                 for name, label in axis.level(level).plays.items()}  # fmt: skip
        for name, label in plays.items():
            if label not in by_label:
                raise UsageError(
                    f"study {study.name}: {name} is played by {label}, which {run_plan.experiment.name} lacks"
                )
        others = plays or {label: label for label in by_label if label != model.label}
        beside = (Watcher.of(by_label[label], name) for name, label in others.items())
        watching = (Watcher.of(model, model.label), *beside)
        for replicate in range(run_plan.repeats):
            trials = range(replicate * size, (replicate + 1) * size)
            shares[point, model.label, run_plan.experiment.name, replicate] = Share(
                run_plan.experiment.name, replicate, trials, watching
            )
    return StudyPlan(
        study, claims, (), axes, tuple(points), (model,), tuple((point, model.label) for point in points),
        run_plan.seed, run_plan.repeats, (1,), run_plan.trials, shares,
        study_description({**run_plan.describe(), "kind": "study"}, axes, claims, (), run_plan.repeats),
        run_plan.changed(),
    )  # fmt: skip


def _refused(claim: ClipClaim, model: ConfiguredModel) -> str:
    """Say why a claim is not about the model judged, in words; empty if it is."""
    if model.label in claim.models:
        return ""
    return f"it is about {', '.join(sorted(claim.models))}, and not about {model.label}"


def offline(
    experiment: OfflineExperiment, study: Study, seed: int, claims: choice.Chosen[ClipClaim],
    assignments: Sequence[str],
) -> Offline:  # fmt: skip
    """Return one experiment with the values of ``--set``, and with the models that its claims compare."""
    needed = {label for claim, name in claims if name == experiment.name for label in claim.models}
    known = look_up(list(dict.fromkeys([*study.models, *experiment.models])), "offline")
    texts = [*study.models, *(model.asked.text for model in known[1:] if model.chosen.label in needed)]
    of_clips: dict[str, list[Any]] = {}
    for clip in experiment.clips:
        of_clips.setdefault(clip.entry.name, []).append(clip.build(seed).params)
    models, texts_set = watchers(texts, assignments, {name: params[0] for name, params in of_clips.items()})
    clips = tuple(_changed(clip, texts_set, "--set") for clip in experiment.clips)
    selected = tuple(look_up(texts, "offline"))
    values: dict[str, tuple[Any, ...]] = {
        entry.section: (model.network,) for entry, model in zip(selected, models, strict=True)
    }
    for name in of_clips:
        values[name] = tuple(clip.build(seed).params for clip in clips if clip.entry.name == name)
    return Offline(experiment, clips, selected, models, Base(experiment.name, models[0].label, values))


def _changed(clip: Clip, texts: Texts, option: str) -> Clip:
    """Return a clip with values for its stimulus, typed after ``option``; `UsageError` if one is not legal."""
    stimulus = clip.entry.name
    stimulus_texts = texts.get(stimulus, {})
    if not stimulus_texts:
        return clip

    def typed(name: str, text: str) -> str:
        return f"{option} {stimulus}.{name}={text}"

    params = changed(stimulus, clip.build(0).params, stimulus_texts, typed)
    values = {**dict(clip.changes), **{name: getattr(params, name) for name in stimulus_texts}}
    try:
        return dataclasses.replace(clip, changes=tuple(values.items()))
    except ValueError as error:
        assignments = ", ".join(typed(*item) for item in stimulus_texts.items())
        raise UsageError(f"{assignments}: {' '.join(str(error).split())}") from error


def _renderings(part: Offline, axes: Sequence[Axis], points: Sequence[Point]) -> list[Rendering]:
    """Return the points of one experiment by the clips that they share."""
    inside = {model.section for model in part.selected}
    values = {point: grid.expanded(point, axes, part.base) for point in points}
    grid.check_settled(next(iter(values.values())), part.selected)
    renderings = []
    for outside, members in grid.by_rendering(values.values(), inside).items():
        clips = _shown_once([_changed(clip, _texts(outside), "--over") for clip in part.clips])
        models: dict[str, ConfiguredModel] = {}
        watching: dict[Point, tuple[Watcher, ...]] = {}
        labels: dict[Values, Point] = {}
        for point in (point for point in points if values[point] in members):
            first = labels.setdefault(values[point], point)  # points that are alike here share their labels
            variants = _variants(part, axes, first, values[point])
            models |= {variant.label: variant for variant, _ in variants}
            watching[point] = tuple(Watcher.of(variant, name) for variant, name in variants)
        renderings.append(Rendering(part.base, clips, tuple(models.values()), watching))
    return renderings


def _texts(values: Values) -> Texts:
    texts: dict[str, dict[str, str]] = {}
    for key, value in values:
        section, _, name = key.partition(".")
        texts.setdefault(section, {})[name] = value
    return texts


def _variants(
    part: Offline, axes: Sequence[Axis], point: Point, values: Values
) -> list[tuple[ConfiguredModel, str]]:  # fmt: skip
    """Return the models at a point, the one judged first, each with its name without the grid's values."""
    variants: list[tuple[ConfiguredModel, str]] = []
    for place, (selected, model) in enumerate(zip(part.selected, part.models, strict=True)):
        called = _called(part, place, axes, point)
        variants.append((grid.variant(model, called, grid.own_values(selected, values)), model.label))
    return variants


def _called(part: Offline, place: int, axes: Sequence[Axis], point: Point) -> str:
    """Return the label of a model at a point; one that no axis moves has one label, and is shown a clip once."""
    return grid.label(point, axes, part.before(place), part.models[place].label if place else "")


def _shown_once(clips: Sequence[Clip]) -> tuple[Clip, ...]:
    """Clips, those that are alike once, under the names of all of them."""
    alike: dict[Any, list[Clip]] = {}
    for clip in clips:
        alike.setdefault((clip.stimulus, clip.build(0).params, clip.jitter_px, clip.takes_scene()), []).append(clip)
    return tuple(dataclasses.replace(group[0], name=", ".join(clip.name for clip in group)) for group in alike.values())


def _description(
    parts: Sequence[Offline], study: Study, parameters: Parameters, seed: int, clips: int, pictures: Pictures | None
) -> dict[str, Any]:
    """Return what ``run.json`` holds beside the grid: every parameter, and what computes it."""
    models = {model.label: model for part in parts for model in part.models}
    files = [path for part in parts for path in provenance.of((), part.declared)["files"]]
    sources = [*(model.source for model in models.values()), *files, *filter(None, (study.file,))]
    return {
        "kind": "map" if study.over else "study",
        "experiments": [dataclasses.replace(part.declared, clips=part.clips) for part in parts],
        "repeats": [1] * len(parts),
        "seed": seed,
        **described_scenes([clip for part in parts for clip in part.clips], study.replicates, pictures),
        "trials": clips,
        "models": tuple(models.values()),
        "changed": {**differing(tuple(models.values()), offline=True), **parameters},
        **provenance.of(sources, parts[0].declared),
    }
