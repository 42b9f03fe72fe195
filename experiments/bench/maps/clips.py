"""A map of off-line experiments: clips of stimuli.

A replicate has each clip once, at one seed. The keys are those of the models, and those of the clips' stimuli:
``cluttered.grey`` is the grey of every ``cluttered`` clip. Points that differ in the network alone share their clips.
Clips that a point makes alike are shown once.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from experiments.bench.clips.claims import ClipClaim, find
from experiments.bench.clips.experiment import Clip, OfflineExperiment, Showing
from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.models import ConfiguredModel, Shown, look_up
from experiments.bench.engine.settings import changed, check_counts, watchers
from experiments.bench.maps import choice
from experiments.bench.maps.axes import Axis, Base, check_assignments, columns, expanded, label, ordered
from experiments.bench.maps.plan import Asked, MapPlan, Share, Watcher
from experiments.bench.robot.sweep import grid
from experiments.bench.robot.sweep.grid import Point, Values
from experiments.bench.store import provenance
from experiments.bench.store.parameters import Parameters, differing

Texts = Mapping[str, Mapping[str, str]]
"""Section -> name -> text."""


@dataclasses.dataclass(frozen=True, slots=True)
class Offline:
    """One experiment of a map, without the grid's values.

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
    """Points that share their clips: the clips, the variants of the models, and which of these are of which label."""

    base: Base
    clips: tuple[Clip, ...]
    models: tuple[ConfiguredModel, ...]
    watchers: Mapping[str, tuple[Watcher, ...]]


def planned(experiments: Sequence[OfflineExperiment], asked: Asked) -> MapPlan:
    """Check and list all that a map of clips shows.

    Parameters
    ----------
    experiments
        Those whose clips answer for claims and measures. One that answers for none of them is not shown.
    asked
        The rest of what was asked for.

    Raises
    ------
    UsageError
        A claim, a measure, a key, a value or a number is not legal.
    """
    if asked.repeats is not None:
        raise UsageError(f"--repeats {asked.repeats}: a replicate has each clip once; --replicates has more seeds")
    check_counts(asked.seed, asked.replicates, "--replicates")
    choice.check_names([experiment.name for experiment in experiments])
    model = look_up([asked.model], "offline")[0].chosen
    claims = choice.claims(experiments, asked, find, lambda claim: _refused(claim, model))
    clips = {each.name: [clip.build(asked.seed).params for clip in each.clips] for each in experiments}
    measures = choice.measures(clips, asked, "clips", model.channels)
    answering = [each for each in experiments if each.name in {name for _, name in (*claims, *measures)}]
    plain = [_offline(each, asked, claims, ()) for each in answering]
    check_assignments([each.base for each in plain], asked.assignments)
    made = [_offline(each, asked, claims, before.base.applying(asked.assignments))
            for each, before in zip(answering, plain, strict=True)]  # fmt: skip
    bases = [each.base for each in made]
    points, found = ordered(asked.over, bases, asked.assignments)
    renderings = [rendering for each in made for rendering in _renderings(each, found, points)]
    for each in renderings:
        params = [clip.build(asked.seed).params for clip in each.clips]
        choice.check_given(measures, each.base.name, params, next(iter(each.watchers)))
    check_counts(asked.seed, asked.replicates, "--replicates", sum(len(each.clips) for each in renderings), "clips")
    specs, by_label = _showings(renderings, asked)
    shares = {
        (point, base.name, replicate): by_label[base.name, label(point, found, base), replicate]
        for point in points
        for base in bases
        for replicate in range(asked.replicates)
    }
    beside = list(dict.fromkeys(each.label for own in made for each in own.models[1:]))
    parameters = columns(points, found, bases, beside)
    said = _description(made, claims, measures, found, parameters, asked, len(specs))
    return MapPlan(
        claims, measures, found, tuple(points), made[0].models[0], asked.seed, asked.replicates, (1,) * len(made),
        tuple(specs), shares, said, parameters,
    )  # fmt: skip


def _refused(claim: ClipClaim, model: ConfiguredModel) -> str:
    """Why a claim is not about the model judged, in words; empty if it is."""
    if model.label in claim.models:
        return ""
    return f"it is about {', '.join(sorted(claim.models))}, and not about {model.label}"


def _offline(
    experiment: OfflineExperiment, asked: Asked, claims: choice.Chosen[ClipClaim], assignments: Sequence[str]
) -> Offline:
    """One experiment with the values of ``--set``, and with the models that its claims compare."""
    needed = {each for claim, name in claims if name == experiment.name for each in claim.models}
    known = look_up(list(dict.fromkeys([asked.model, *experiment.models])), "offline")
    texts = [asked.model, *(each.asked.text for each in known[1:] if each.chosen.label in needed)]
    of_clips: dict[str, list[Any]] = {}
    for clip in experiment.clips:
        of_clips.setdefault(clip.stimulus, []).append(clip.build(asked.seed).params)
    models, texts_set = watchers(texts, assignments, {name: own[0] for name, own in of_clips.items()})
    clips = tuple(_changed(clip, texts_set, "--set") for clip in experiment.clips)
    shown = tuple(look_up(texts, "offline"))
    values: dict[str, tuple[Any, ...]] = {each.section: (own.network,) for each, own in zip(shown, models, strict=True)}
    for name in of_clips:
        values[name] = tuple(clip.build(asked.seed).params for clip in clips if clip.stimulus == name)
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


def _renderings(made: Offline, found: Sequence[Axis], points: Sequence[Point]) -> list[Rendering]:
    """The points of one experiment by the clips that they share."""
    inside = {each.section for each in made.shown}
    whole = {point: Point(expanded(point.values, made.base)) for point in points}
    grid.check_settled(next(iter(whole.values())), made.shown)
    renderings = []
    for outside, members in grid.by_rendering(list(dict.fromkeys(whole.values())), inside).items():
        clips = _shown_once([_changed(clip, _texts(outside), "--over") for clip in made.clips])
        models: dict[str, ConfiguredModel] = {}
        seen: dict[str, tuple[Watcher, ...]] = {}
        for point in (each for each in points if whole[each] in members):
            variants = _variants(made, found, point, whole[point])
            models |= {own.label: own for own, _ in variants}
            watching = tuple(Watcher(own.label, name, own.threshold) for own, name in variants)
            seen[watching[0].label] = watching
        renderings.append(Rendering(made.base, clips, tuple(models.values()), seen))
    return renderings


def _texts(values: Values) -> Texts:
    texts: dict[str, dict[str, str]] = {}
    for key, value in values:
        section, _, name = key.partition(".")
        texts.setdefault(section, {})[name] = value
    return texts


def _variants(made: Offline, found: Sequence[Axis], point: Point, whole: Point) -> list[tuple[ConfiguredModel, str]]:
    """The models at a point, the one judged first, each with its name without the grid's values."""
    variants: list[tuple[ConfiguredModel, str]] = []
    for shown, model in zip(made.shown, made.models, strict=True):
        called = label(point, found, made.base, model.label if variants else "")
        variants.append((grid.variant(model, called, grid.own_values(shown, whole)), model.label))
    return variants


def _shown_once(clips: Sequence[Clip]) -> tuple[Clip, ...]:
    """Clips, those that are alike once, under the names of all of them."""
    alike: dict[Any, list[Clip]] = {}
    for clip in clips:
        alike.setdefault((clip.stimulus, clip.build(0).params, clip.jitter_px), []).append(clip)
    return tuple(dataclasses.replace(own[0], name=", ".join(clip.name for clip in own)) for own in alike.values())


def _showings(
    renderings: Sequence[Rendering], asked: Asked
) -> tuple[list[Showing], dict[tuple[str, str, int], Share]]:  # fmt: skip
    """Every clip, and which are whose: (experiment, label, replicate) -> its clips. Replicate k has seed + k."""
    specs: list[Showing] = []
    shares: dict[tuple[str, str, int], Share] = {}
    for replicate in range(asked.replicates):
        for each in renderings:
            trials = range(len(specs), len(specs) + len(each.clips))
            specs += [
                Showing(each.base.name, index, replicate, asked.seed + replicate, clip, each.models)
                for index, clip in zip(trials, each.clips, strict=True)
            ]
            for name, own in each.watchers.items():
                shares[each.base.name, name, replicate] = Share(each.base.name, replicate, trials, own)
    return specs, shares


def _description(
    made: Sequence[Offline], claims: choice.Chosen[ClipClaim], measures: Sequence[tuple[Any, str]],
    found: Sequence[Axis], parameters: Parameters, asked: Asked, clips: int,
) -> dict[str, Any]:  # fmt: skip
    """What ``experiment.json`` holds: every parameter, the grid, claims and measures, and what computes it."""
    models = {model.label: model for each in made for model in each.models}
    files = [path for each in made for path in provenance.of((), each.declared)["files"]]
    return {
        "kind": "map",
        "experiment": "map",
        "experiments": [dataclasses.replace(each.declared, clips=each.clips) for each in made],
        "repeats": [1] * len(made),
        "replicates": asked.replicates,
        "seed": asked.seed,
        "trials": clips,
        "models": tuple(models.values()),
        "axes": {axis.name: axis.levels for axis in found},
        "claims": [{**claim.described(), "experiment": name} for claim, name in claims],
        "measures": [{**measure.described(), "experiment": name} for measure, name in measures],
        "changed": {**differing(tuple(models.values()), offline=True), **parameters},
        **provenance.of((*(model.source for model in models.values()), *files), made[0].declared),
    }
