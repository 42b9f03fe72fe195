"""Off-line experiments: plan an experiment's clips, and conclude, draw and show a run of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from colias_sim.config import EventConfig
from experiments.base import console
from experiments.base.console import count, out_console, show_files
from experiments.base.errors import UsageError
from experiments.declare.clip import ClipFigure, OfflineExperiment
from experiments.declare.outcome import Outcome
from experiments.draw.terminal import show_controls, show_silent, show_verdicts
from experiments.judge.judge import judge
from experiments.judge.tests import summary_rows
from experiments.judge.verdict import Verdict, document, verdict_of
from experiments.kinds import registry
from experiments.kinds.controls import conclude_controls
from experiments.kinds.result import Kind, Run, concluding, load
from experiments.settings.models import event_camera, shown_models
from experiments.settings.parameters import differing
from experiments.settings.pictures import folder_pictures
from experiments.settings.settings import check_counts, events_of, watchers
from experiments.show.clips import TRIALS, TRUE_FRAMES, ClipTrial, described_scenes, record, trials_of
from experiments.show.controls import controls
from experiments.show.play import FRAMES, Trial, play
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import THRESHOLDS, RunFolder
from experiments.store.plan import Plan
from experiments.store.tables import PEAKS, TrialRecord, without_controls

if TYPE_CHECKING:
    from matplotlib.figure import Figure

QUANTITIES = ("spikes", "peak_hs", "trough_hs", "peak_vs", "trough_vs", "peak_looming")
"""Quantities of a summary: a count, then potentials."""


# What is run.


def plan(asked: Asked) -> Plan[ClipTrial]:
    """Return the plan of an experiment's clips.

    Parameters
    ----------
    asked
        What was asked for. Its options are ``pictures``, the folder of a user's own, shown in place of the scenes;
        ``recordings`` and ``frames``, whether to keep these; ``truth``, whether frames have what truly moved;
        ``controls``, whether models see each clip again as controls.

    Raises
    ------
    UsageError
        It cannot be run so.
    """
    experiment: OfflineExperiment = registry.declaration(asked)
    folder = asked.option("pictures")
    if asked.option("eyes", "one") != "one":
        raise UsageError(f"--eyes {asked.options['eyes']}: {experiment.name} shows clips, which no camera sees")
    if folder and not any(clip.takes_scene() for clip in experiment.clips):
        raise UsageError(f"--pictures: no clip of {experiment.name} has a background to show them")
    pictures = folder_pictures(folder) if folder else None
    repeats = experiment.repeats if asked.repeats is None else asked.repeats
    check_counts(asked.seed, repeats, f"{experiment.name}: repeats" if asked.repeats is None else "--repeats")
    models = shown_models(experiment.models, asked.models, asked.only)
    chosen, config = watchers(models, asked.values, {"events": EventConfig()}), events_of(asked.values)
    others, events = {"events": (EventConfig(), config)}, event_camera(chosen, config)
    truth, changed = bool(asked.option("truth")), differing(chosen, offline=True, others=others)
    again = controls if asked.option("controls") else None
    trials = trials_of(experiment, chosen, repeats, asked.seed, pictures, truth=truth, controls=again, events=events)
    recordings = bool(asked.option("recordings", True)) and experiment.recorded
    random = bool(events) or any(clip.is_random for clip in experiment.clips)
    equal = f"nothing in {experiment.name} is random: its {repeats} repeats are equal"
    resolved = {
        "experiment": experiment,
        "repeats": repeats,
        "seed": asked.seed,
        "trials": len(trials),
        "models": chosen,
        **({"changed": changed} if changed else {}),
        THRESHOLDS: {model.label: model.thresholds for model in chosen},
        **described_scenes(experiment.clips, repeats, pictures),
        "clips": {trial.label(): trial.condition.build(asked.seed).params for trial in trials if not trial.repeat},
        "recordings": recordings,
        **provenance.of((model.source for model in chosen), experiment),
    }
    return Plan(
        asked, experiment.name, trials,
        partial(play_clip, recordings=recordings, frames=bool(asked.option("frames", True))), resolved,
        (TRIALS, TRUE_FRAMES if truth else FRAMES), experiment, chosen, changed, "clips", random=random,
        notes=(equal,) if repeats > 1 and not random else (),
    )  # fmt: skip


def play_clip(trial: Trial, *, recordings: bool = False, frames: bool = True) -> TrialRecord:
    """Play a clip. With ``recordings`` it is recorded at the first seed; ``frames`` keeps a row per frame."""
    return play(trial, record if recordings and not trial.repeat else None, frames=frames)


# What it comes to.


def conclude(plan: Plan[ClipTrial], folder: RunFolder) -> None:
    """Judge the claims of the clips in ``folder``, and write verdicts, summary and figure."""
    from experiments.draw import style  # not before: workers do without matplotlib

    rows = without_controls(folder.table("trials")).to_dicts()
    folder.write_json("claims.json", document(verdicts(plan, rows)))
    if rows:
        conclude_controls(plan, folder, lambda: {trial.index: trial.way() for trial in plan.trials})
        folder.write_rows("summary.csv", summary_rows(rows, ("model", "clip"), QUANTITIES, QUANTITIES[1:]))
        style.save(load(folder.folder).figure(), folder.folder / "figure")


def verdicts(
    plan: Plan[ClipTrial], rows: Sequence[Mapping[str, Any]], all_rows: Sequence[Mapping[str, Any]] | None = None
) -> list[Verdict]:
    """Judge the claims of an off-line run, each at every seed. A seed is a replicate.

    Parameters
    ----------
    plan
        The run's.
    rows
        The run's rows.
    all_rows
        The same models' rows in other runs too: see `experiments.judge.judge.judge`.
    """
    experiment, lost = plan.declared, Outcome.unjudged("some of its clips failed")
    by_seed = [
        [row for row in rows if row["repeat"] == repeat] for repeat in sorted({trial.repeat for trial in plan.trials})
    ]
    whole = [len({row["trial"] for row in of_seed}) == len(experiment.clips) for of_seed in by_seed]
    spiking, random = plan.thresholds, plan.random
    found = []
    for claim in (registry.find_claim(claim, "clips") for claim in experiment.claims):
        outcomes = [
            judge(claim, of_seed, spiking.get(claim.spiking), all_rows or rows) if there else lost
            for of_seed, there in zip(by_seed, whole, strict=True)
        ]
        found.append(verdict_of(claim, outcomes, random=random, experiment=experiment.name))
    return found


# Reading it.


def draw(run: Run) -> Figure:
    """Draw the figure of a run of clips, from its folder alone."""
    from experiments.draw import clips  # not before: matplotlib takes its time to load

    declared = run.description["experiment"]
    title = clips.title(declared["name"], run.description["seed"], run.description.get("changed") or {})
    rows, frames = without_controls(run.trials), without_controls(run.frames)
    return clips.draw(ClipFigure(**declared["figure"]), rows, frames, run.thresholds, title)


def show(run: Run) -> None:
    """Print what a run comes to: peaks at the first seed, the verdicts, and where everything is."""
    table = without_controls(run.trials)
    rows = table.to_dicts()
    if rows:
        console.show(table.filter(repeat=0).select("clip", "model", *PEAKS, "spikes"), "first seed")
    out_console.print()
    show_verdicts(run.verdicts)
    show_silent(rows)
    show_controls(run.controls)
    show_files(run.folder, count(len({row["trial"] for row in rows}), "clip"))


def words(run: Run) -> str:
    """Say what a run shows."""
    return f"{run.description['experiment']['summary']}."


KIND = Kind(plan, concluding(conclude), draw, show, renders=False, chapter="Clips", words=words)
