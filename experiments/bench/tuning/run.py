"""Measure tuning curves into a folder: the clips on a pool, then tables and figures of their curves and preferences."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dsnn.stimuli import StimulusEntry
from experiments.bench.figures import plotting
from experiments.bench.offline import play_clip
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.play import FRAMES, Trial
from experiments.bench.run.runs import Batch, Resources
from experiments.bench.run.settings import check_counts, watchers
from experiments.bench.run.workers import Workers
from experiments.bench.sources import clips as stimuli
from experiments.bench.sources.clips import TRIALS, Clip, pixels
from experiments.bench.store import provenance
from experiments.bench.store.parameters import Parameters, differing
from experiments.bench.store.rows import Failure
from experiments.bench.store.run_folder import RunFolder
from experiments.bench.tuning import figure as tuning_figure
from experiments.bench.tuning.curves import TuningPoint, answers
from experiments.bench.tuning.preferences import Preferences, preferences
from experiments.bench.tuning.probes import STIMULUS, Family, Probe, families, of_stimulus

EXPERIMENT = "tuning"


@dataclass(frozen=True, slots=True)
class TuningPlan:
    """Curves to measure: everything that decides their numbers."""

    families: tuple[Family, ...]
    models: tuple[ConfiguredModel, ...]
    seed: int

    def numbered_probes(self) -> list[tuple[int, Family, Probe]]:
        """Return every clip in order, with its number and what it is a point of."""
        points = [(family, probe) for family in self.families for probe in family.probes if self._seen_by(family)]
        return [(index, family, probe) for index, (family, probe) in enumerate(points)]

    def showings(self) -> list[Trial[Clip]]:
        """Return the probes as jobs: each clip to all models that its family is shown to."""
        return [
            Trial(EXPERIMENT, i, probe.repeat, self.seed + probe.repeat, probe.clip, self._seen_by(family))
            for i, family, probe in self.numbered_probes()
        ]

    def _seen_by(self, family: Family) -> tuple[ConfiguredModel, ...]:
        return tuple(model for model in self.models if family.shown_to(model.channels))

    def amount(self) -> str:
        """Say how many clips and frames there are."""
        probes_shown = self.numbered_probes()
        frames = sum(len(probe.clip.build(self.seed + probe.repeat)) for _, _, probe in probes_shown)
        return f"{len(probes_shown)} clips, {frames:,} frames"

    def _files(self) -> list[str]:
        """Return the user's own files that stimuli are declared in."""
        entries = {probe.clip.entry.name: probe.clip.entry for family in self.families for probe in family.probes}
        return [place[0] for entry in entries.values() if (place := stimuli.place_of(entry))]

    def channels(self) -> dict[str, tuple[str, ...]]:
        """Return the channels by which each model answers."""
        return {model.label: model.channels for model in self.models}

    def changed(self) -> Parameters:
        """Return the parameters that are not at their defaults, by key and model."""
        return differing(self.models, offline=True)

    def describe(self) -> dict[str, Any]:
        """Return what ``run.json`` holds."""
        changed = self.changed()
        return {
            "kind": "tuning",
            "experiment": EXPERIMENT,
            "seed": self.seed,
            "trials": len(self.numbered_probes()),
            "models": self.models,
            **({"changed": changed} if changed else {}),
            "curves": [described(family) for family in self.families],
            **provenance.of([model.source for model in self.models] + self._files()),
        }


def described(family: Family) -> Family | dict[str, Any]:
    """Return what ``run.json`` holds of a family; of `STIMULUS` it is the parameters of the clips."""
    if family.name != STIMULUS:
        return family
    points = {probe.clip.name: {"params": probe.clip.build(0).params, "x": probe.x} for probe in family.probes}
    return {"name": family.name, "summary": family.summary, "x": family.x, "probes": points}


@dataclass(frozen=True, slots=True)
class TuningReport:
    """Results of tuning. ``figures`` are the paths of the pictures, by family."""

    plan: TuningPlan
    folder: Path
    answers: list[TuningPoint]
    preferences: list[Preferences]
    figures: dict[str, Path]
    failures: list[Failure]


def plan(
    models: Sequence[str],
    curves: Sequence[str],
    assignments: Sequence[str],
    seed: int,
    stimulus: StimulusEntry | None = None,
    over: str = "",
) -> TuningPlan:
    """Return a checked plan from what a person typed; `UsageError` for what is not legal.

    With a ``stimulus`` its curve along the parameter of ``over`` is measured, beside the ``curves`` that are named;
    without one those, or all of them.
    """
    check_counts(seed)
    if stimulus is None:
        chosen, _ = watchers(models, assignments)
        tuning = TuningPlan(families(curves), chosen, seed)
    else:
        listed = f"colias stimulus {stimulus.name} --parameters, colias parameters"
        chosen, assigned = watchers(models, assignments, {stimulus.name: stimulus.params}, listed)
        along = of_stimulus(stimulus, assigned.get(stimulus.name, {}), over, seed)
        tuning = TuningPlan((along, *(families(curves) if curves else ())), chosen, seed)
    if not tuning.numbered_probes():
        raise UsageError(f"--curve {curves[0]}: no model shown answers by looming; name one by --model")
    return tuning


def batch(plan: TuningPlan) -> Batch[Trial[Clip]]:
    """Return the clips of the curves as a batch."""
    showings = plan.showings()
    return Batch(
        name=EXPERIMENT,
        specs=showings,
        work=play_clip,
        description=plan.describe(),
        schemas=(TRIALS, FRAMES),
        parameters=plan.changed(),
        things="clips",
        amount=plan.amount,
        size=pixels,
    )


def run(plan: TuningPlan, out: Path, pool: Workers, resources: Resources) -> TuningReport:
    """Show what has not been shown, and conclude. Goes on where an earlier call stopped.

    Parameters
    ----------
    plan
        From `plan`.
    out
        The folder: a new or an empty one, or one that holds a part of these curves.
    pool, resources
        Where the clips are shown.
    """
    work = batch(plan)
    with closing(work.open(out, resources)) as folder:
        return conclude(plan, folder, work.fill(folder, pool, resources))


def conclude(plan: TuningPlan, folder: RunFolder, failures: Sequence[Failure]) -> TuningReport:
    """Write the tables and figures of the clips in ``folder``."""
    given, rows = evaluated(plan, folder)
    channels = plan.channels()
    known = {row.model: channels[row.model] for row in rows}
    pictures, changed = {}, plan.changed()
    families = {family.name: family for family in plan.families}
    if given:
        folder.write_rows("tuning.csv", [_row(a, families) for a in given])
        folder.write_rows("preferences.csv", [row.row() for row in rows])
        for family in plan.families:
            points = [a for a in given if a.curve == family.name]
            if points:
                pictures[family.name] = plotting.save(
                    tuning_figure.draw(family, points, known, changed), folder.folder, family.name
                )
    return TuningReport(plan, folder.folder, given, rows, pictures, list(failures))


def evaluated(plan: TuningPlan, folder: RunFolder) -> tuple[list[TuningPoint], list[Preferences]]:
    """Return the answers of the clips in ``folder``, and what each model prefers by them."""
    channels = plan.channels()
    given = answers(plan.numbered_probes(), channels, folder.frames(), plan.seed)
    known = {model: channels[model] for model in channels if any(a.model == model for a in given)}
    return given, [preferences(given, model, by) for model, by in known.items()]


def _row(given: TuningPoint, families: Mapping[str, Family]) -> dict[str, Any]:
    """Return a row of ``tuning.csv``, its axes by name; empty where the curve has no such axis."""
    family = families[given.curve]
    along = [families[STIMULUS].x.name] if STIMULUS in families else []
    names = ("speed_px_s", "size_px", "contrast", "cycles_px", "temporal_hz", "l_over_v_s", *along)
    axes: dict[str, float | None] = dict.fromkeys(names)
    values = dataclasses.asdict(given)
    x, y = values.pop("x"), values.pop("y")
    axes |= {family.x.name: x} if family.x.name in axes else {}
    axes |= {family.y.name: y} if family.y else {}
    head = {name: values.pop(name) for name in ("curve", "line", "model")}
    return {**head, **axes, **values}
