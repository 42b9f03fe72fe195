"""Run an off-line experiment into a folder and say what it comes to: tables, verdicts at every seed, figure."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

from experiments.bench import console, figures, offline_figures, provenance
from experiments.bench.claims import Outcome
from experiments.bench.files import is_file
from experiments.bench.model_option import shown_models
from experiments.bench.offline import (
    CLIP_SCHEMA,
    SERIES_SCHEMA,
    Clip,
    OfflineExperiment,
    Showing,
    clip_contents,
    show,
    showings,
)
from experiments.bench.offline_claims import judge
from experiments.bench.paper import claim_texts
from experiments.bench.pool import Pool
from experiments.bench.results import Failure, Finished, RunFolder, mixture
from experiments.bench.settings import check_counts, watchers


@dataclass(frozen=True, slots=True)
class OfflinePlan:
    """An off-line run to do: everything that decides its numbers."""

    experiment: OfflineExperiment
    showings: tuple[Showing, ...]
    repeats: int
    seed: int

    @property
    def thresholds(self) -> dict[str, float | None]:
        """Each model's spiking threshold."""
        return {model.label: model.threshold for model in self.showings[0].models}

    def describe(self) -> dict[str, Any]:
        """What ``experiment.json`` holds."""
        return {
            "experiment": self.experiment,
            "repeats": self.repeats,
            "seed": self.seed,
            "trials": len(self.showings),
            "models": self.showings[0].models,
            "clips": {clip.name: clip.build(self.seed).params for clip in self.experiment.clips},
            **provenance.of([m.source for m in self.showings[0].models if is_file(m.source)], self.experiment),
        }


@dataclass(frozen=True, slots=True)
class OfflineVerdict:
    """A claim's answer at the seed asked for, and at how many of the seeds run it holds."""

    id: str
    says: str
    source: str
    verdict: str
    measured: str
    effect: str
    n: int
    seeds_holding: int
    seeds: int
    seeds_untested: int = 0
    decided: str = ""
    """The number that decided at the seed asked for, and its bound."""


@dataclass(frozen=True, slots=True)
class OfflineReport:
    """What an off-line run amounts to."""

    plan: OfflinePlan
    folder: Path
    rows: list[dict[str, Any]]
    verdicts: list[OfflineVerdict]
    failures: list[Failure]


def plan(
    experiment: OfflineExperiment, models: Sequence[str], assignments: Sequence[str], repeats: int | None, seed: int,
    *, only: bool = False,
) -> OfflinePlan:  # fmt: skip
    """A checked plan from what a person typed.

    ``models`` are shown the clips beside the experiment's own, or, with ``only``, instead of them.
    """
    count = experiment.repeats if repeats is None else repeats
    check_counts(seed, count)
    chosen, _ = watchers(shown_models(experiment.models, models, only), assignments)
    return OfflinePlan(experiment, tuple(showings(experiment, chosen, count, seed)), count, seed)


def amount(made: OfflinePlan, means: console.Means) -> str:
    """The design check: clips, frames, and on what."""
    frames = made.repeats * sum(len(clip.build(made.seed)) for clip in made.experiment.clips)
    return f"{len(made.showings)} clips, {frames:,} frames, {console.where(means)}"


def pixels(showing: Showing) -> float:
    """How many pixels a model is shown: what a clip costs goes by that."""
    return _pixels(showing.condition)


@cache
def _pixels(clip: Clip) -> float:
    built = clip.build(0)
    return float(len(built) * built.shape[0] * built.shape[1])


def run(made: OfflinePlan, out: Path, pool: Pool, means: console.Means, resume: bool, record: bool) -> OfflineReport:
    """Show what has not been shown, with progress, and conclude; ``record`` the first seed's clips."""
    recorded = [showing.index for showing in made.showings if record and showing.repeat == 0]
    contents = clip_contents(made.showings, recorded)
    with contextlib.closing(RunFolder(out, CLIP_SCHEMA, SERIES_SCHEMA)) as folder:
        folder.enter({**made.describe(), "recordings": record}, resume, contents, means.other_code)
        done = len(folder.done())
        if not means.quiet:
            resumed = f"; {done} of them done already" if done else ""
            said = f"{made.experiment.name}: {amount(made, means)}{resumed}, into {out}"
            console.error_console.print(said, soft_wrap=True, markup=False)
        work = partial(_show, record=record)
        failures = console.do(made.experiment.name, made.showings, folder, pool, means, work, "clips", pixels)
        return conclude(made, folder, failures)


def _show(showing: Showing, *, record: bool) -> Finished:
    return show(showing, record=record and showing.repeat == 0)


def conclude(made: OfflinePlan, folder: RunFolder, failures: Sequence[Failure]) -> OfflineReport:
    """Write verdicts and figure of the clips in ``folder``."""
    rows = folder.rows()
    verdicts = [_verdict(claim, made, rows) for claim in made.experiment.claims]
    folder.write_json("claims.json", verdicts)
    if rows:
        shown = [row for row in rows if row["repeat"] == 0]
        drawn = offline_figures.draw(made.experiment, shown, folder.frames(), made.thresholds)
        figures.save(drawn, folder.folder)
    return OfflineReport(made, folder.folder, rows, verdicts, list(failures))


def _verdict(claim: str, made: OfflinePlan, rows: Sequence[Mapping[str, Any]]) -> OfflineVerdict:
    says, source = claim_texts()[claim]
    by_seed: list[Outcome] = []
    for repeat in range(made.repeats):
        own = [row for row in rows if row["repeat"] == repeat]
        whole = len({row["trial"] for row in own}) == len(made.experiment.clips)
        lost = Outcome("untested", "some of its clips failed")
        by_seed.append(judge(claim, own, made.thresholds) if whole else lost)
    first, mixed = by_seed[0], mixture(rows)
    measured = "; ".join([first.measured, *([mixed] if mixed else [])])
    holding, untested = (sum(outcome.verdict == which for outcome in by_seed) for which in ("holds", "untested"))
    return OfflineVerdict(
        claim, says, source, first.verdict, measured, first.effect, first.n, holding, len(by_seed), untested,
        first.decided,
    )  # fmt: skip
