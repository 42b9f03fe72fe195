"""A study of off-line experiments: clips of stimuli.

A replicate has each clip once, at one seed and before one scene. The keys are those of the models, and those of the
clips' stimuli: ``cluttered.grey`` is the grey of every ``cluttered`` clip. Points that differ in the network alone
share their clips. Clips that a point makes alike are shown once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from experiments.bench.clips.claims import ClipClaim, find
from experiments.bench.clips.experiment import Clip, OfflineExperiment, Showing, clips_of, described_scenes
from experiments.bench.clips.plan import OfflinePlan
from experiments.bench.clips.rows import CLIP_SCHEMA
from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.models import ConfiguredModel, Shown, look_up
from experiments.bench.engine.pictures import Pictures
from experiments.bench.engine.settings import changed, check_counts, watchers
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
    shown, models
        The model judged and those that its claims compare it with: what was asked of them, and what they are.
    base
        What the axes see of it.
    """

    declared: OfflineExperiment
    clips: tuple[Clip, ...]
    shown: tuple[Shown, ...]
    models: tuple[ConfiguredModel, ...]
    base: Base


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
        raise UsageError(f"study {study.name}: models={study.models}: a study of clips judges one model")
    check_counts(seed, study.replicates, "--replicates")
    choice.check_names([experiment.name for experiment in experiments])
    model = look_up(study.models, "offline")[0].chosen
    claims = choice.claims(experiments, study, find, lambda claim: _refused(claim, model))
    if SPIKES in study.measures:
        raise UsageError(f"--measure {SPIKES}: it needs trials with the robot; {experiments[0].name} has clips")
    clips = {each.name: [clip.build(seed).params for clip in each.clips] for each in experiments}
    measures = choice.measures(clips, study, "clips", model.channels)
    answering = [each for each in experiments if each.name in {name for _, name in (*claims, *measures)}]
    plain = [_offline(each, study, seed, claims, ()) for each in answering]
    grid.check_assignments([each.base for each in plain], study.assignments)
    made = [_offline(each, study, seed, claims, before.base.applying(study.assignments))
            for each, before in zip(answering, plain, strict=True)]  # fmt: skip
    bases = [each.base for each in made]
    grid.check_levels(study.axes, bases, study.name, CLIP_SCHEMA.names)
    axes = study.axes + (grid.axes_of(study.over, bases, study.assignments) if study.over else ())
    points = grid.points_of([(axis.name, axis.labels) for axis in axes])
    renderings = [rendering for each in made for rendering in _renderings(each, axes, points)]
    for each in renderings:
        params = [clip.build(seed).params for clip in each.clips]
        choice.check_given(measures, each.base.name, params, next(iter(each.watchers.values()))[0].label)
    shown = sum(len(each.clips) for each in renderings)
    check_counts(seed, study.replicates, "--replicates", shown, "clips")
    specs: list[Showing] = []
    shares: dict[tuple[Point, str, str, int], Share] = {}
    for replicate in range(study.replicates):
        for each in renderings:
            trials = range(len(specs), len(specs) + len(each.clips))
            specs += [
                Showing(each.base.name, index, replicate, seed + replicate, clip, each.models)
                for index, clip in zip(trials, clips_of(each.clips, replicate, pictures), strict=True)
            ]
            for point, own in each.watchers.items():
                key = (point, model.label, each.base.name, replicate)
                shares[key] = Share(each.base.name, replicate, trials, own)
    called = [
        (grid.label(point, axes, each.base, each.models[place].label if place else ""), point, each.base)
        for point in points
        for each in made
        for place in range(len(each.models))
    ]
    parameters = grid.columns(called, axes)
    about = study_description(
        _description(made, study, parameters, seed, len(specs), pictures), axes, claims, measures, study.replicates
    )
    return StudyPlan(
        study, claims, measures, axes, tuple(points), (made[0].models[0],),
        tuple((point, model.label) for point in points), seed, study.replicates, (1,) * len(made), tuple(specs),
        shares, about, parameters,
    )  # fmt: skip


def points_of_run(study: Study, own: OfflinePlan) -> StudyPlan:
    """Return the plan of a study whose points are read off a run of an experiment, with the replicates of that run."""
    by_label = {model.label: model for model in own.showings[0].models}
    model = by_label[study.models[0]]
    claims = choice.claims([own.experiment], study, find, lambda _: "")
    axes = study.axes
    points = grid.points_of([(axis.name, axis.labels) for axis in axes])
    size = len(own.experiment.clips)
    shares: dict[tuple[Point, str, str, int], Share] = {}
    for point in points:
        plays = {name: label for axis, (_, level) in zip(axes, point.values, strict=True)
                 for name, label in axis.level(level).plays.items()}  # fmt: skip
        for name, label in plays.items():
            if label not in by_label:
                raise UsageError(f"study {study.name}: {name} is played by {label}, which {own.experiment.name} lacks")
        others = plays or {label: label for label in by_label if label != model.label}
        beside = (Watcher.of(by_label[label], name) for name, label in others.items())
        watching = (Watcher.of(model, model.label), *beside)
        for replicate in range(own.repeats):
            trials = range(replicate * size, (replicate + 1) * size)
            shares[point, model.label, own.experiment.name, replicate] = Share(
                own.experiment.name, replicate, trials, watching
            )
    return StudyPlan(
        study, claims, (), axes, tuple(points), (model,), tuple((point, model.label) for point in points), own.seed,
        own.repeats, (1,), own.showings, shares,
        study_description({**own.describe(), "kind": "study"}, axes, claims, (), own.repeats), own.changed(),
    )  # fmt: skip


def _refused(claim: ClipClaim, model: ConfiguredModel) -> str:
    """Why a claim is not about the model judged, in words; empty if it is."""
    if model.label in claim.models:
        return ""
    return f"it is about {', '.join(sorted(claim.models))}, and not about {model.label}"


def _offline(
    experiment: OfflineExperiment, study: Study, seed: int, claims: choice.Chosen[ClipClaim],
    assignments: Sequence[str],
) -> Offline:  # fmt: skip
    """One experiment with the values of ``--set``, and with the models that its claims compare."""
    needed = {each for claim, name in claims if name == experiment.name for each in claim.models}
    known = look_up(list(dict.fromkeys([*study.models, *experiment.models])), "offline")
    texts = [*study.models, *(each.asked.text for each in known[1:] if each.chosen.label in needed)]
    of_clips: dict[str, list[Any]] = {}
    for clip in experiment.clips:
        of_clips.setdefault(clip.stimulus, []).append(clip.build(seed).params)
    models, texts_set = watchers(texts, assignments, {name: own[0] for name, own in of_clips.items()})
    clips = tuple(_changed(clip, texts_set, "--set") for clip in experiment.clips)
    shown = tuple(look_up(texts, "offline"))
    values: dict[str, tuple[Any, ...]] = {each.section: (own.network,) for each, own in zip(shown, models, strict=True)}
    for name in of_clips:
        values[name] = tuple(clip.build(seed).params for clip in clips if clip.stimulus == name)
    return Offline(experiment, clips, shown, models, Base(experiment.name, models[0].label, values))


def _changed(clip: Clip, texts: Texts, option: str) -> Clip:
    """A clip with values for its stimulus, typed after ``option``; `UsageError` if one is not legal."""
    own = texts.get(clip.stimulus, {})
    if not own:
        return clip

    def typed(name: str, text: str) -> str:
        return f"{option} {clip.stimulus}.{name}={text}"

    params = changed(clip.stimulus, clip.build(0).params, own, typed)
    values = {**dict(clip.changes), **{name: getattr(params, name) for name in own}}
    try:
        return dataclasses.replace(clip, changes=tuple(values.items()))
    except ValueError as error:
        said = ", ".join(typed(*each) for each in own.items())
        raise UsageError(f"{said}: {' '.join(str(error).split())}") from None


def _renderings(made: Offline, axes: Sequence[Axis], points: Sequence[Point]) -> list[Rendering]:
    """The points of one experiment by the clips that they share."""
    inside = {each.section for each in made.shown}
    values = {point: grid.expanded(point, axes, made.base) for point in points}
    grid.check_settled(next(iter(values.values())), made.shown)
    renderings = []
    for outside, members in grid.by_rendering(values.values(), inside).items():
        clips = _shown_once([_changed(clip, _texts(outside), "--over") for clip in made.clips])
        models: dict[str, ConfiguredModel] = {}
        watching: dict[Point, tuple[Watcher, ...]] = {}
        labels: dict[Values, Point] = {}
        for point in (each for each in points if values[each] in members):
            first = labels.setdefault(values[point], point)  # points that are alike here share their labels
            variants = _variants(made, axes, first, values[point])
            models |= {own.label: own for own, _ in variants}
            watching[point] = tuple(Watcher.of(own, name) for own, name in variants)
        renderings.append(Rendering(made.base, clips, tuple(models.values()), watching))
    return renderings


def _texts(values: Values) -> Texts:
    texts: dict[str, dict[str, str]] = {}
    for key, value in values:
        section, _, name = key.partition(".")
        texts.setdefault(section, {})[name] = value
    return texts


def _variants(
    made: Offline, axes: Sequence[Axis], point: Point, values: Values
) -> list[tuple[ConfiguredModel, str]]:  # fmt: skip
    """The models at a point, the one judged first, each with its name without the grid's values."""
    variants: list[tuple[ConfiguredModel, str]] = []
    for shown, model in zip(made.shown, made.models, strict=True):
        called = grid.label(point, axes, made.base, model.label if variants else "")
        variants.append((grid.variant(model, called, grid.own_values(shown, values)), model.label))
    return variants


def _shown_once(clips: Sequence[Clip]) -> tuple[Clip, ...]:
    """Clips, those that are alike once, under the names of all of them."""
    alike: dict[Any, list[Clip]] = {}
    for clip in clips:
        alike.setdefault((clip.stimulus, clip.build(0).params, clip.jitter_px, clip.takes_scene()), []).append(clip)
    return tuple(dataclasses.replace(own[0], name=", ".join(clip.name for clip in own)) for own in alike.values())


def _description(
    made: Sequence[Offline], study: Study, parameters: Parameters, seed: int, clips: int, pictures: Pictures | None
) -> dict[str, Any]:
    """What ``experiment.json`` holds beside the grid: every parameter, and what computes it."""
    models = {model.label: model for each in made for model in each.models}
    files = [path for each in made for path in provenance.of((), each.declared)["files"]]
    sources = [*(model.source for model in models.values()), *files, *filter(None, (study.file,))]
    return {
        "kind": "map" if study.over else "study",
        "experiments": [dataclasses.replace(each.declared, clips=each.clips) for each in made],
        "repeats": [1] * len(made),
        "seed": seed,
        **described_scenes([clip for each in made for clip in each.clips], study.replicates, pictures),
        "trials": clips,
        "models": tuple(models.values()),
        "changed": {**differing(tuple(models.values()), offline=True), **parameters},
        **provenance.of(sources, made[0].declared),
    }
