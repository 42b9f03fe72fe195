"""The trials of a sweep, and the points of its grid at which each of them counts.

Points and models that differ in parameters of models alone share their frames: they are models of the same trials.
Trials that no axis changes are run once, and count at every point.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from experiments.base.errors import UsageError
from experiments.base.files import plain
from experiments.base.values import key_values
from experiments.declare.clip import Clip, OfflineExperiment
from experiments.declare.experiment import Experiment
from experiments.declare.study import WHOLE, Levels, Study
from experiments.judge.replicates import EVERY_MODEL, MODEL
from experiments.judge.sweep import SPIKES, TRUE, ClaimAt, Fewer, Share, Sweep, chosen, quantity
from experiments.kinds import registry, trials
from experiments.settings.grid import Base, Point, check_keys, knows, levels_of, moves, points_of, sets, values_of
from experiments.settings.models import ConfiguredModel, look_up, parse_model
from experiments.settings.parameters import differing
from experiments.settings.settings import check_counts, sections, watchers, with_values
from experiments.show import clips
from experiments.show.robot import is_random, trials_of
from experiments.show.trial_rows import TRIAL_SCHEMA
from experiments.store import provenance
from experiments.store.asked import Asked


@dataclass(frozen=True, slots=True)
class Part:
    """One experiment of a sweep: the models shown, and what makes its trials at a point.

    ``base`` has the sections of ``--set`` beside the models' own. ``render`` makes conditions, or clips' parameters,
    of what a point sets there, a function from a replicate and the models to trials, and whether replicates differ.
    """

    declared: Any
    models: Sequence[ConfiguredModel]
    base: Base
    repeats: int
    render: Callable[[Mapping[str, str]], tuple[Any, ...]]
    described: Mapping[str, Any]

    def base_of(self, model: ConfiguredModel) -> Base:
        """Return the sections of ``--set`` that the trials of a model read."""
        processor = {"processor": model.processor} if isinstance(self.declared, Experiment) else {}
        return {**self.base, model.section: model.network, **processor}


def settled(model: ConfiguredModel) -> set[str]:
    """Return the keys that a model has settled itself, as ``dsnn:n_con=5`` has."""
    return {f"{model.section}.{name}" for name in parse_model(model.text)[1]}


def _applying(assignments: Sequence[str], sections: Base) -> dict[str, str]:
    return {key: text for key, text in key_values(assignments).items() if knows(sections, key)}


def robot_part(declared: Experiment, study: Study, seed: int, models: Sequence[str]) -> Part:
    """Return an experiment with the robot, shown to models, as a part of a sweep."""
    values = _applying(study.assignments, sections(declared, models))
    asked = Asked(kind="trials", values=values, repeats=study.repeats, seed=seed)
    whole, settings, repeats = trials.checked(declared, models, asked)
    number, truth = len(whole.conditions()) * repeats, any(name.startswith(TRUE) for name in study.measures)
    resolved, changed = trials.resolve(asked, declared, whole, settings, repeats, number)

    def render(over: Mapping[str, str]) -> Any:
        point = replace(asked, values={**asked.values, **over})
        experiment, moved, _ = trials.checked(declared, models, point)

        def specs(replicate: int, shown: tuple[ConfiguredModel, ...]) -> list[Any]:
            seen = replace(moved, models=shown)
            found = trials_of(experiment, seen, repeats, seed + replicate, truth=truth)
            return [replace(spec, repeat=replicate * repeats + spec.repeat) for spec in found]

        return experiment.conditions(), specs, is_random(moved)

    base = {key: getattr(settings, key) for key in ("robot", "camera", "scene", "events")}
    base["experiment"] = whole.design
    return Part(whole, settings.models, base, repeats, render, {**resolved, "changed": changed})


def clips_part(declared: OfflineExperiment, study: Study, seed: int, needed: Collection[str] | None) -> Part:
    """Return clips as a part of a sweep; a key of a stimulus is of each of its clips.

    ``needed`` has the labels of the experiment's own models that are shown too; ``None``: all of them.
    """
    own = [model.text for model in look_up(declared.models, "offline") if needed is None or model.label in needed]
    stimuli = _stimuli(declared, seed)
    shown = look_up([*study.models, *own], "offline")
    values = _applying(study.assignments, {model.section: model.network for model in shown} | stimuli)
    models = watchers([model.text for model in shown], values, stimuli)
    whole = _with_clips_set(declared, values)

    def render(over: Mapping[str, str]) -> Any:
        moved = _with_clips_set(whole, over)

        def specs(replicate: int, variants: tuple[ConfiguredModel, ...]) -> list[Any]:
            every = clips.trials_of(moved, variants, study.replicates, seed)
            return [trial for trial in every if trial.repeat == replicate]

        return [clip.build(seed).params for clip in moved.clips], specs, any(clip.is_random for clip in moved.clips)

    described = {**clips.described_scenes(whole.clips, study.replicates, None),
                 "changed": differing(models, offline=True), "files": provenance.of((), declared)["files"]}  # fmt: skip
    return Part(whole, models, _stimuli(whole, seed), 1, render, described)


def _stimuli(declared: OfflineExperiment, seed: int) -> dict[str, Any]:
    """Return name of a stimulus -> the parameters of the first clip that shows it."""
    return {clip.entry.name: clip.build(seed).params for clip in reversed(declared.clips)}


def _with_clips_set(declared: OfflineExperiment, values: Mapping[str, str]) -> OfflineExperiment:
    """Return an experiment with values for its stimuli, by key; `UsageError` if one is not legal."""

    def with_own(clip: Clip) -> Clip:
        own = {key.partition(".")[2]: text for key, text in values.items() if key.partition(".")[0] == clip.entry.name}
        params = with_values(clip.entry.name, clip.build(0).params, own)
        return replace(clip, changes=dict(clip.changes) | {name: getattr(params, name) for name in own})

    return replace(declared, clips=[with_own(clip) for clip in declared.clips]) if values else declared


def sections_of(declared: Any) -> Base:
    """Return the sections of ``--set`` that the trials of an experiment read, beside those of models."""
    return sections(declared, ()) if isinstance(declared, Experiment) else _stimuli(declared, 0)


def sweep_of(
    study: Study, seed: int = 0, models_in: Mapping[str, Sequence[str]] | None = None, *, repeats: int | None = None,
    only: Levels | None = None, claim_at: ClaimAt | None = None, fewer: Fewer | None = None,
) -> Sweep:  # fmt: skip
    """Check a study and list all its trials.

    Parameters
    ----------
    study
        The study.
    seed
        Of replicate 0; replicate k has ``seed`` + k.
    models_in
        Experiment -> the models shown there, all judged together, in place of the study's.
    repeats
        Trials of each condition, in place of the study's own number.
    only
        Level -> the models judged there, where these are not all.
    claim_at
        As of a `Sweep`. The points are then read off one run of the off-line experiment, with its own models and the
        first of the study's.
    fewer
        As of a `Sweep`.

    Raises
    ------
    UsageError
        The experiments are of both kinds, or something that the study asks for is not legal.
    """
    check_counts(seed, study.replicates, "--replicates")
    experiments, on_robot = _experiments(study, repeats)
    study = study if repeats is None else replace(study, repeats=repeats)
    if not study.models:
        models_in = models_in or {experiment.name: registry.asked_models(experiment) for experiment in experiments}
        study = replace(study, models=(MODEL,))
    models = look_up(study.models, "robot" if on_robot else "offline")
    if not on_robot and not claim_at and len(models) > 1:
        raise UsageError(f"models {', '.join(study.models)}: clips are judged of one model at a time")
    judged = [EVERY_MODEL] if models_in else [model.label for model in (models if on_robot else models[:1])]
    claims = registry.claims_of(experiments, study, [] if models_in or claim_at else models)
    parts = []
    for experiment in experiments:
        needed = {label for claim, name in claims if name == experiment.name for label in claim.models}
        parts.append(
            robot_part(experiment, study, seed, (models_in or {}).get(experiment.name, study.models))
            if on_robot
            else clips_part(experiment, study, seed, None if claim_at else needed)
        )
    axes = _axes(study, parts)
    parameters: dict[str, dict[str, Any]] = {name: {} for name, levels in axes.items() if any(levels.values())}
    renderings = {part.declared.name: _renderings(part, study, axes, parameters, only or {}) for part in parts}
    conditions = {name: [conditions for conditions, *_ in found] for name, found in renderings.items()}
    measures = tuple(chosen(study.measures or (() if claims else (SPIKES,)), conditions, models))
    asked = {place for _, place, *_ in (*claims, *measures)}
    parts = [part for part in parts if models_in or part.declared.name in asked]
    shown = [(part.declared.name, *rendering) for part in parts for rendering in renderings[part.declared.name]]
    fixed = frozenset((point, name) for name, *_, random, _, watching in shown if not random for point in watching)
    if not any(random for *_, random, _, _ in shown):
        study = replace(study, replicates=1)
    specs, shares = _trials(shown, study.replicates, fewer, judged[0] if models_in or not on_robot else None)
    if claim_at:  # its points differ in nothing that is run: the columns of its trials are the models' own
        parameters |= parts[0].described["changed"]
    there = {(point, name) for point, name, *_ in shares}
    each = [part.repeats for part in parts]
    resolved = {
        **_resolved(study, parts, specs, parameters), "repeats": each, "replicates": study.replicates, "seed": seed,
        "axes": axes, "claims": [{**plain(claim), "experiment": name} for claim, name in claims],
        "measures": [{"name": name, "unit": quantity(name).unit, "experiment": place}
                     for name, place, _ in measures],
    }  # fmt: skip
    judged_at = tuple((point, name) for point in points_of(axes) for name in judged if (point, name) in there)
    return Sweep(
        study, claims, measures, axes, judged_at, seed, tuple(specs), shares, each, fixed, resolved, parameters,
        claim_at=claim_at, fewer=fewer,
    )  # fmt: skip


def _experiments(study: Study, repeats: int | None) -> tuple[list[Any], bool]:
    """Return the experiments of a study, all of one kind, and whether a robot is in them."""
    experiments: list[Any] = list(map(registry.find, study.experiments or registry.answering_for(study.claims)))
    names = [experiment.name for experiment in experiments]
    on_robot = isinstance(experiments[0], Experiment)
    if any(isinstance(other, Experiment) != on_robot for other in experiments) or len(set(names)) < len(names):
        raise UsageError(f"EXPERIMENT: {', '.join(names)} must be different experiments, all with a robot or all clips")
    if not on_robot and (repeats is not None or study.repeats not in (None, WHOLE)):
        raise UsageError(f"--repeats: {', '.join(names)} shows clips, once in a replicate; give --replicates")
    return experiments, on_robot


def _trials(
    shown: Sequence[tuple[Any, ...]], replicates: int, fewer: Fewer | None, whole: str | None
) -> tuple[list[Any], dict[tuple[Point, str, str, int], Share]]:
    """Return all trials, one replicate after the other, and at which points and models each of them counts.

    ``shown`` has each rendering after its experiment's name; points have all ``replicates``, or ``fewer``. Where all
    models of a point are judged together, ``whole`` is the name under which they are.
    """
    specs: list[Any] = []
    shares: dict[tuple[Point, str, str, int], Share] = {}
    for replicate, (name, _, rendered, random, variants, watching) in product(range(replicates), shown):
        counting = {point: seen for point, seen in watching.items() if not fewer or replicate < fewer(dict(point))}
        if not counting or (replicate and not random):  # it would be replicate 0 once more
            continue
        labels = {model.label for seen in counting.values() for model in seen.values()}
        found = rendered(replicate, tuple(model for label, model in variants.items() if label in labels))
        numbers = range(len(specs), len(specs) + len(found))
        specs += [replace(spec, index=number) for number, spec in zip(numbers, found, strict=True)]
        for point, seen in counting.items():
            if whole is None:
                shares |= {(point, one, name, replicate): (numbers, {one: model}) for one, model in seen.items()}
            else:
                shares[point, whole, name, replicate] = (numbers, seen)
    return specs, shares


def _resolved(
    study: Study, parts: Sequence[Part], specs: Sequence[Any], parameters: Mapping[str, Any]
) -> dict[str, Any]:
    """Return what ``run.json`` has of the parts of a sweep: experiments, models, changed parameters, the code."""
    variants = {model.label: model for spec in specs for model in spec.models}
    files = [path for part in parts for path in part.described["files"]]
    sources = [*dict.fromkeys(model.source for model in variants.values()), *files, *filter(None, (study.file,))]
    changes = {key: value for part in parts for key, value in part.described["changed"].items()}
    return {
        **parts[0].described, "experiments": [part.declared for part in parts], "trials": len(specs),
        "models": tuple(variants.values()), "changed": {**changes, **parameters},
        **provenance.of(sources, parts[0].declared),
    }  # fmt: skip


def _axes(study: Study, parts: Sequence[Part]) -> dict[str, Levels]:
    """Return the axes of a study; `UsageError` for a key that there is not, and for an axis that moves nothing."""
    readers = [(part.base_of(model), settled(model)) for part in parts for model in part.models]
    bases = [base for base, _ in readers]
    check_keys(study.assignments, bases, "--set")
    axes = dict(study.axes) | levels_of(study.over, study.assignments)
    for name, levels in axes.items():
        if name in (*TRIAL_SCHEMA, *clips.TRIALS):
            raise UsageError(f"axis {name}: the table of trials has that column; rename the axis")
        texts = [text for level in levels.values() for text in level]
        check_keys(texts, bases, "--over" if name not in study.axes else f"axis {name}:")
        if texts and not any(moves(levels, base, fixed) for base, fixed in readers):
            raise UsageError(f"axis {name}: the models have settled that themselves, so that it moves nothing")
    return axes


def _renderings(
    part: Part, study: Study, axes: Mapping[str, Levels], parameters: dict[str, dict[str, Any]], only: Levels
) -> list[tuple[Any, ...]]:
    """Return the trials of one experiment that points share, and note the points' values in ``parameters``.

    Each has what `Part.render` returns, the models by label, and of each point the models by their names.
    """
    texts = {point: [text for name, level in point for text in axes[name][level]] for point in points_of(axes)}
    by_setting: dict[tuple[tuple[str, str], ...], list[Point]] = {}
    for point in texts:
        by_setting.setdefault(tuple(sets(texts[point], part.base).items()), []).append(point)
    renderings: list[tuple[Any, ...]] = []
    for setting, members in by_setting.items():
        variants: dict[str, ConfiguredModel] = {}
        watching: dict[Point, dict[str, ConfiguredModel]] = {}
        labels: dict[Any, str] = {}
        pairs = [(place, model, point) for place, model in enumerate(part.models) for point in members]
        if isinstance(part.declared, OfflineExperiment):  # the order of models of a trial enters a design's digest
            pairs.sort(key=lambda pair: members.index(pair[2]))
        for place, model, point in pairs:
            judging = [only.get(level, study.models) for _, level in point]
            if model.text in study.models and any(model.text not in models for models in judging):
                continue
            base, fixed = part.base_of(model), settled(model)
            moved = [(name, level) for name, level in point if moves(axes[name], base, fixed)]
            values = {key: value for key, value in sets(texts[point], base).items() if key not in fixed}
            named = [level if name in study.axes else f"{name}={level}" for name, level in moved]
            name = " ".join(filter(None, (model.label if place else "", *named))) or model.label
            label = labels.setdefault((place, *values.items()), name)  # points that are alike there share it
            for axis, level in point:
                if axis in parameters:
                    parameters[axis][label] = values_of(axes[axis])[level] if (axis, level) in moved else None
            network, processor = (
                with_values(section, value, {key.partition(".")[2]: text for key, text in values.items()
                                         if key.partition(".")[0] == section})
                for section, value in ((model.section, model.network), ("processor", model.processor))
            )  # fmt: skip
            moved_model = replace(model, label=label, network=network, processor=processor)
            variants.setdefault(label, moved_model)
            watching.setdefault(point, {})[model.label] = variants[label]
        if watching:
            conditions, specs, random = part.render(dict(setting))
            skipping = any(model.processor.every > 1 for model in variants.values())  # frames that the seed decides
            renderings.append((conditions, specs, random or skipping, variants, watching))
    return renderings
