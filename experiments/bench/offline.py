"""Run an off-line experiment: plan its clips, play them into a folder, judge its claims, draw its figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from experiments import OFFLINE
from experiments.bench.report.terminal import error_console
from experiments.bench.result import Run, load
from experiments.bench.run import provenance
from experiments.bench.run.description import THRESHOLDS
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.parameters import Parameters, differing
from experiments.bench.run.play import FRAMES, Trial, play
from experiments.bench.run.rows import TrialRecord
from experiments.bench.run.runs import Batch, Resources
from experiments.bench.run.settings import check_counts, watchers
from experiments.bench.run.workers import Workers
from experiments.bench.sources.clips import TRIALS, OfflineExperiment, described_scenes, pixels, record
from experiments.bench.sources.judge import judge
from experiments.bench.sources.pictures import Pictures
from experiments.bench.stats import stored
from experiments.bench.stats.claim import Claim, find_claim
from experiments.bench.stats.tests import summary_rows
from experiments.bench.stats.verdict import Outcome, Verdict


@dataclass(frozen=True, slots=True)
class OfflinePlan:
    """An off-line run to do: everything that decides its numbers."""

    experiment: OfflineExperiment
    trials: tuple[Trial, ...]
    repeats: int
    seed: int
    pictures: Pictures | None = None

    @property
    def models(self) -> tuple[ConfiguredModel, ...]:
        """The models that the clips are shown to."""
        return self.trials[0].models

    @property
    def thresholds(self) -> dict[str, float | None]:
        """Each model's spiking threshold."""
        return {model.label: model.threshold for model in self.models}

    def changed(self) -> Parameters:
        """Return the models' parameters that are not at their defaults, by key and model."""
        return differing(self.models, offline=True)

    def describe(self) -> dict[str, Any]:
        """Return what ``run.json`` holds: every parameter, the seed, and what computes."""
        clips = [trial.condition for trial in self.trials if not trial.repeat]
        changed = self.changed()
        return {
            "kind": "clips",
            "experiment": self.experiment,
            "repeats": self.repeats,
            "seed": self.seed,
            "trials": len(self.trials),
            "models": self.models,
            **({"changed": changed} if changed else {}),
            THRESHOLDS: {model.label: model.thresholds for model in self.models},
            **described_scenes(self.experiment.clips, self.repeats, self.pictures),
            "clips": {clip.label(): clip.open(self.seed).stimulus.params for clip in clips},
            **provenance.of((model.source for model in self.models), self.experiment),
        }

    def is_random(self) -> bool:
        """Return whether the clips may differ with the seed: of those that ship, whether a frame of any does."""
        if self.experiment.repeats > 1 or self.experiment.name not in OFFLINE:
            return True
        # Three frames tell: what is random in a clip is so while its object is in view.
        pairs = ((clip.build(0), clip.build(1)) for clip in self.experiment.clips)
        places = ((one, other, len(one) * quarter // 4) for one, other in pairs for quarter in (1, 2, 3))
        return any((one[place].luma != other[place].luma).any() for one, other, place in places)


def plan(
    experiment: OfflineExperiment, models: Sequence[str], assignments: Sequence[str], repeats: int | None, seed: int,
    pictures: Pictures | None = None,
) -> OfflinePlan:  # fmt: skip
    """Return a checked plan from what a person typed.

    Parameters
    ----------
    experiment
        The experiment.
    models
        The models that are shown the clips.
    assignments
        ``SECTION.NAME=VALUE`` texts.
    repeats
        Number of repeats; ``None``: the experiment's own.
    seed
        Seed of the first repeat.
    pictures
        Shown in place of the scenes.

    Raises
    ------
    UsageError
        It cannot be run so.
    """
    count = experiment.repeats if repeats is None else repeats
    option = f"{experiment.name}: repeats" if repeats is None else "--repeats"
    check_counts(seed, count, option)
    chosen, _ = watchers(models, assignments)
    return OfflinePlan(experiment, experiment.trials(chosen, count, seed, pictures), count, seed, pictures)


def play_clip(trial: Trial, *, recordings: bool = False, frames: bool = True) -> TrialRecord:
    """Play a clip. With ``recordings`` it is recorded at the first seed; ``frames`` keeps a row per frame."""
    return play(trial, record if recordings and not trial.repeat else None, frames=frames)


def batch(plan: OfflinePlan, *, recordings: bool = False, frames: bool = True) -> Batch[Trial]:
    """Return the clips of a checked plan as a batch; ``recordings`` and ``frames`` as of `play_clip`."""
    return Batch(
        name=plan.experiment.name,
        specs=plan.trials,
        work=partial(play_clip, recordings=recordings, frames=frames),
        description={**plan.describe(), "recordings": recordings},
        schemas=(TRIALS, FRAMES),
        parameters=plan.changed(),
        things="clips",
        size=pixels,
    )


def run(
    plan: OfflinePlan, out: Path, pool: Workers, resources: Resources, *, recordings: bool = False
) -> Run:  # fmt: skip
    """Play the clips that a folder lacks, judge and draw.

    Parameters
    ----------
    plan
        From `plan`.
    out
        The run's folder: a new one, or one that holds a part of this run.
    pool, resources
        Where the clips are played.
    recordings
        Whether to record the first seed's clips for Rerun.
    """
    from experiments.bench.report import style  # not before: workers do without matplotlib

    if plan.repeats > 1 and not resources.quiet and not plan.is_random():
        error_console.print(f"note: nothing in {plan.experiment.name} is random: its {plan.repeats} repeats are equal")
    with batch(plan, recordings=recordings).run(out, pool, resources) as folder:
        rows = folder.table("trials").to_dicts()
        folder.write_json("claims.json", stored.document(verdicts(plan, rows)))
        shown = load(out)
        if rows:
            folder.write_rows("summary.csv", summary_rows(rows, ("model", "clip"), QUANTITIES, QUANTITIES[1:]))
            style.save(shown.figure(), out / "figure")
    return shown


QUANTITIES = ("spikes", "peak_hs", "trough_hs", "peak_vs", "trough_vs", "peak_looming")
"""Quantities of a summary: a count, then potentials."""


def verdicts(
    plan: OfflinePlan, rows: Sequence[Mapping[str, Any]], all_rows: Sequence[Mapping[str, Any]] | None = None
) -> list[Verdict]:
    """Judge the claims of an off-line run, each at every seed. A seed is a replicate.

    Parameters
    ----------
    plan
        The run's plan.
    rows
        The run's rows.
    all_rows
        The same models' rows in other runs too: see `experiments.bench.sources.judge.judge`.
    """
    random = plan.is_random()
    return [
        _verdict(find_claim(claim, "clips"), plan, rows, all_rows or rows, random) for claim in plan.experiment.claims
    ]


def _verdict(
    claim: Claim, plan: OfflinePlan, rows: Sequence[Mapping[str, Any]], all_rows: Sequence[Mapping[str, Any]],
    random: bool,
) -> Verdict:  # fmt: skip
    outcomes: list[Outcome] = []
    for repeat in range(plan.repeats):
        of_seed = [row for row in rows if row["repeat"] == repeat]
        whole = len({row["trial"] for row in of_seed}) == len(plan.experiment.clips)
        lost = Outcome.unjudged("some of its clips failed")
        outcomes.append(judge(claim, of_seed, plan.thresholds.get(claim.spiking), all_rows) if whole else lost)
    return Verdict.of(claim, outcomes, random=random, experiment=plan.experiment.name)
