"""Plan of an off-line run, and its description in ``run.json``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from experiments.bench.clips.experiment import Clip, OfflineExperiment, Showing, described_scenes, showings
from experiments.bench.engine.pictures import Pictures
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import shown_models
from experiments.bench.run.settings import check_counts, watchers
from experiments.bench.store import provenance
from experiments.bench.store.description import THRESHOLDS
from experiments.bench.store.parameters import Parameters, differing


@dataclass(frozen=True, slots=True)
class OfflinePlan:
    """An off-line run to do: everything that decides its numbers."""

    experiment: OfflineExperiment
    showings: tuple[Showing, ...]
    repeats: int
    seed: int
    pictures: Pictures | None = None

    @property
    def thresholds(self) -> dict[str, float | None]:
        """Each model's spiking threshold."""
        return {model.label: model.threshold for model in self.showings[0].models}

    def changed(self) -> Parameters:
        """Return the models' parameters that are not at their defaults, by key and model."""
        return differing(self.showings[0].models, offline=True)

    def describe(self) -> dict[str, Any]:
        """Return what ``run.json`` holds: every parameter, the seed, and what computes.

        ``changed``, where it is there, has the parameters that are not at their defaults.
        """
        models, changed = self.showings[0].models, self.changed()
        return {
            "kind": "clips",
            "experiment": self.experiment,
            "repeats": self.repeats,
            "seed": self.seed,
            "trials": len(self.showings),
            "models": models,
            **({"changed": changed} if changed else {}),
            THRESHOLDS: {model.label: model.thresholds for model in models},
            **described_scenes(self.experiment.clips, self.repeats, self.pictures),
            "clips": {
                showing.condition.name: showing.condition.build(showing.seed).params
                for showing in self.showings
                if not showing.repeat
            },
            **provenance.of((model.source for model in models), self.experiment),
        }

    def amount(self) -> str:
        """Say how many clips and frames there are."""
        frames = self.repeats * sum(len(clip.build(self.seed)) for clip in self.experiment.clips)
        return f"{len(self.showings)} clips, {frames:,} frames"


def plan(
    experiment: OfflineExperiment, models: Sequence[str], assignments: Sequence[str], repeats: int | None, seed: int,
    *, only: bool = False, pictures: Pictures | None = None,
) -> OfflinePlan:  # fmt: skip
    """Return a checked plan from what a person typed.

    ``models`` are shown the clips beside the experiment's own, or, with ``only``, instead of them. ``pictures`` are
    shown in place of the scenes. Raises `UsageError` for what cannot be run.
    """
    count = experiment.repeats if repeats is None else repeats
    option = f"{experiment.name}: repeats" if repeats is None else "--repeats"
    check_counts(seed, count, option, len(experiment.clips), "clips")
    try:
        chosen, _ = watchers(shown_models(experiment.models, models, only), assignments)
    except UsageError:
        _check_stimuli(experiment, assignments)
        raise
    return OfflinePlan(experiment, tuple(showings(experiment, chosen, count, seed, pictures)), count, seed, pictures)


def _check_stimuli(experiment: OfflineExperiment, assignments: Sequence[str]) -> None:
    """Raise `UsageError` where one of ``assignments`` is to a stimulus of the clips: these say what they are."""
    stimuli = {clip.entry.name for clip in experiment.clips}
    for text in assignments:
        if text.partition(".")[0] in stimuli:
            raise UsageError(
                f"--set {text}: the clips of {experiment.name} set the parameters of their stimuli; give the value in"
                " its file, as Clip(name, stimulus, {parameter: value})"
            )


def pixels(showing: Showing) -> float:
    """Return how many pixels a model is shown: what a clip costs goes by that."""
    return _pixels(showing.condition)


@cache
def _pixels(clip: Clip) -> float:
    built = clip.build(0)
    return float(len(built) * built.shape[0] * built.shape[1])
