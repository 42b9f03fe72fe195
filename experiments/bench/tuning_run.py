"""Measure tuning curves into a folder: the clips on a pool, then tables and figures of what they come to."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.bench import console, figures, provenance, tuning_figures
from experiments.bench.description import begun, read_description, vacant
from experiments.bench.files import UsageError, is_file
from experiments.bench.models import Chosen
from experiments.bench.offline import CLIP_SCHEMA, SERIES_SCHEMA, Showing, clip_contents, show
from experiments.bench.offline_run import pixels
from experiments.bench.pool import Pool
from experiments.bench.results import Failure, RunFolder
from experiments.bench.settings import check_counts, watchers
from experiments.bench.tuning import Family, Probe, curve_family, families
from experiments.bench.tuning_curves import Answer, answers
from experiments.bench.tuning_preferences import Preferences, preferences

EXPERIMENT = "tuning"


@dataclass(frozen=True, slots=True)
class TuningPlan:
    """Curves to measure: everything that decides their numbers."""

    families: tuple[Family, ...]
    models: tuple[Chosen, ...]
    seed: int

    def shown(self) -> list[tuple[int, Family, Probe]]:
        """Every clip in order, with its number and what it is a point of."""
        points = [(family, probe) for family in self.families for probe in family.probes]
        return [(index, family, probe) for index, (family, probe) in enumerate(points)]

    def showings(self) -> list[Showing]:
        """The same as jobs: each clip to all models."""
        return [Showing(EXPERIMENT, i, 0, self.seed, probe.clip, self.models) for i, _, probe in self.shown()]

    def channels(self) -> dict[str, tuple[str, ...]]:
        """By what each model answers."""
        return {model.label: model.channels for model in self.models}

    def describe(self) -> dict[str, Any]:
        """What ``experiment.json`` holds."""
        sources = [model.source for model in self.models if is_file(model.source)]
        return {
            "experiment": EXPERIMENT,
            "seed": self.seed,
            "trials": len(self.shown()),
            "models": self.models,
            "curves": self.families,
            **provenance.of(sources),
        }


@dataclass(frozen=True, slots=True)
class TuningReport:
    """What was measured. ``figures`` are the paths of the pictures, by family."""

    plan: TuningPlan
    folder: Path
    answers: list[Answer]
    preferences: list[Preferences]
    figures: dict[str, Path]
    failures: list[Failure]


def plan(models: Sequence[str], curves: Sequence[str], assignments: Sequence[str], seed: int) -> TuningPlan:
    """A checked plan from what a person typed; `UsageError` for what is not legal."""
    check_counts(seed)
    chosen, _ = watchers(models, assignments)
    return TuningPlan(families(curves), chosen, seed)


def amount(made: TuningPlan, means: console.Means) -> str:
    """The design check: clips, frames, and on what."""
    frames = sum(len(probe.clip.build(made.seed)) for _, _, probe in made.shown())
    return f"{len(made.shown())} clips, {frames:,} frames, {console.where(means)}"


def run(made: TuningPlan, out: Path, pool: Pool, means: console.Means) -> TuningReport:
    """Show what has not been shown, with progress, and conclude. Goes on where an earlier call stopped."""
    resume, folder = _begun(out), RunFolder(out, CLIP_SCHEMA, SERIES_SCHEMA)
    folder.enter(made.describe(), resume, clip_contents(made.showings()), means.other_code)
    try:
        return _measure(made, folder, pool, means)
    finally:
        folder.close()


def _measure(made: TuningPlan, folder: RunFolder, pool: Pool, means: console.Means) -> TuningReport:
    done = len(folder.done())
    if not means.quiet:
        resumed = f"; {done} of them done already" if done else ""
        said = f"{EXPERIMENT}: {amount(made, means)}{resumed}, into {folder.folder}"
        console.error_console.print(said, soft_wrap=True, markup=False)
    failures = console.do(EXPERIMENT, made.showings(), folder, pool, means, show, "clips", pixels)
    return conclude(made, folder, failures)


def _begun(out: Path) -> bool:
    """Whether these are curves begun; `UsageError` where ``out`` holds anything else, which is never touched."""
    if not out.exists():
        return False
    if not out.is_dir():
        raise UsageError(f"--out {out}: is a file; choose a folder")
    if not begun(out):
        if not vacant(out):
            raise UsageError(f"--out {out}: holds other files; choose a new folder, or an empty one")
        return False
    if read_description(out).get("experiment") != EXPERIMENT:
        raise UsageError(f"--out {out}: holds another run; choose a new folder, or an empty one")
    return True


def conclude(made: TuningPlan, folder: RunFolder, failures: Sequence[Failure]) -> TuningReport:
    """Write the tables and figures of the clips in ``folder``."""
    channels = made.channels()
    given = answers(made.shown(), channels, folder.frames(), made.seed)
    known = {model: channels[model] for model in channels if any(a.model == model for a in given)}
    found = [preferences(given, model, by) for model, by in known.items()]
    pictures = {}
    if given:
        folder.write_rows("tuning.csv", [_row(a) for a in given])
        folder.write_rows("preferences.csv", [each.row() for each in found])
        for family in made.families:
            own = [a for a in given if a.curve == family.name]
            if own:
                pictures[family.name] = figures.save(
                    tuning_figures.draw(family, own, known), folder.folder, family.name
                )
    return TuningReport(made, folder.folder, given, found, pictures, list(failures))


def _row(given: Answer) -> dict[str, Any]:
    """A row of ``tuning.csv``, its axes by name; empty where the curve has no such axis."""
    family = curve_family(given.curve)
    axes = {"speed_px_s": None, "size_px": None, "contrast": None, "cycles_px": None, "temporal_hz": None}
    values = dataclasses.asdict(given)
    x, y = values.pop("x"), values.pop("y")
    axes |= {family.x.name: x} if family.x.name in axes else {}
    axes |= {family.y.name: y} if family.y else {}
    head = {name: values.pop(name) for name in ("curve", "line", "model")}
    return {**head, **axes, **values}
