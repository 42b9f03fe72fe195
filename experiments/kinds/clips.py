"""Run an off-line experiment: plan its clips, play them into a folder, judge its claims, draw its figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from experiments.base.console import error_console
from experiments.declare.clip import OfflineExperiment
from experiments.declare.outcome import Outcome
from experiments.judge import stored
from experiments.judge.judge import judge
from experiments.judge.tests import summary_rows
from experiments.judge.verdict import Verdict, verdict_of
from experiments.kinds.registry import find_claim
from experiments.kinds.result import Run, load
from experiments.settings.parameters import differing
from experiments.settings.pictures import Pictures
from experiments.settings.settings import check_counts, watchers
from experiments.show.clips import TRIALS, described_scenes, record, trials_of
from experiments.show.play import FRAMES, Trial, play
from experiments.store import provenance
from experiments.store.description import THRESHOLDS
from experiments.store.runs import Batch
from experiments.store.tables import TrialRecord
from experiments.store.workers import Workers


def is_random(experiment: OfflineExperiment) -> bool:
    """Return whether the clips differ between repeats: whether one has a scene of its own in each, or a frame does."""
    if any(clip.takes_scene() for clip in experiment.clips):
        return True
    pairs = ((clip.build(0), clip.build(1)) for clip in experiment.clips)
    frames = ((one[place].luma, other[place].luma) for one, other in pairs for place in range(len(one)))
    return any((one != other).any() for one, other in frames)


def plan(
    experiment: OfflineExperiment, models: Sequence[str], assignments: Sequence[str], repeats: int | None, seed: int,
    pictures: Pictures | None = None, *, frames: bool = True,
) -> Batch[Trial]:  # fmt: skip
    """Return an experiment's clips as a batch, checked, from what a person typed.

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
    frames
        Whether to keep a row per frame.

    Raises
    ------
    UsageError
        It cannot be run so.
    """
    count = experiment.repeats if repeats is None else repeats
    option = f"{experiment.name}: repeats" if repeats is None else "--repeats"
    check_counts(seed, count, option)
    chosen, _ = watchers(models, assignments)
    trials, changed = trials_of(experiment, chosen, count, seed, pictures), differing(chosen, offline=True)
    description = {
        "kind": "clips",
        "experiment": experiment,
        "repeats": count,
        "seed": seed,
        "trials": len(trials),
        "models": chosen,
        **({"changed": changed} if changed else {}),
        THRESHOLDS: {model.label: model.thresholds for model in chosen},
        **described_scenes(experiment.clips, count, pictures),
        "clips": {trial.label(): trial.condition.build(seed).params for trial in trials if not trial.repeat},
        "recordings": False,
        **provenance.of((model.source for model in chosen), experiment),
    }
    return Batch(
        name=experiment.name,
        specs=trials,
        work=partial(play_clip, frames=frames),
        description=description,
        schemas=(TRIALS, FRAMES),
        parameters=changed,
        things="clips",
    )


def play_clip(trial: Trial, *, recordings: bool = False, frames: bool = True) -> TrialRecord:
    """Play a clip. With ``recordings`` it is recorded at the first seed; ``frames`` keeps a row per frame."""
    return play(trial, record if recordings and not trial.repeat else None, frames=frames)


def run(clips: Batch[Trial], out: Path, pool: Workers, *, recordings: bool = False) -> Run:
    """Play the clips that a folder lacks, judge and draw.

    Parameters
    ----------
    clips
        From `plan`.
    out
        The run's folder: a new one, or one that holds a part of this run.
    pool
        Where the clips are played.
    recordings
        Whether to record the first seed's clips for Rerun.
    """
    from experiments.draw import style  # not before: workers do without matplotlib

    repeats = clips.description["repeats"]
    if repeats > 1 and not pool.quiet and not is_random(clips.description["experiment"]):
        error_console.print(f"note: nothing in {clips.name} is random: its {repeats} repeats are equal")
    work, description = partial(play_clip, recordings=recordings), {**clips.description, "recordings": recordings}
    with replace(clips, work=work, description=description).run(out, pool) as folder:
        rows = folder.table("trials").to_dicts()
        folder.write_json("claims.json", stored.document(verdicts(clips, rows)))
        shown = load(out)
        if rows:
            folder.write_rows("summary.csv", summary_rows(rows, ("model", "clip"), QUANTITIES, QUANTITIES[1:]))
            style.save(shown.figure(), out / "figure")
    return shown


QUANTITIES = ("spikes", "peak_hs", "trough_hs", "peak_vs", "trough_vs", "peak_looming")
"""Quantities of a summary: a count, then potentials."""


def thresholds(clips: Batch[Trial]) -> dict[str, float | None]:
    """Return the spiking threshold of each model that clips are shown to."""
    return {model.label: model.threshold for model in clips.specs[0].models}


def verdicts(
    clips: Batch[Trial], rows: Sequence[Mapping[str, Any]], all_rows: Sequence[Mapping[str, Any]] | None = None
) -> list[Verdict]:
    """Judge the claims of an off-line run, each at every seed. A seed is a replicate.

    Parameters
    ----------
    clips
        The run's clips, from `plan`.
    rows
        The run's rows.
    all_rows
        The same models' rows in other runs too: see `experiments.judge.judge.judge`.
    """
    experiment, lost = clips.description["experiment"], Outcome.unjudged("some of its clips failed")
    by_seed = [[row for row in rows if row["repeat"] == repeat] for repeat in range(clips.description["repeats"])]
    whole = [len({row["trial"] for row in of_seed}) == len(experiment.clips) for of_seed in by_seed]
    spiking, random = thresholds(clips), is_random(experiment)
    found = []
    for claim in (find_claim(claim, "clips") for claim in experiment.claims):
        outcomes = [
            judge(claim, of_seed, spiking.get(claim.spiking), all_rows or rows) if there else lost
            for of_seed, there in zip(by_seed, whole, strict=True)
        ]
        found.append(verdict_of(claim, outcomes, random=random, experiment=experiment.name))
    return found
