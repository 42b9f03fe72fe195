"""Run an off-line experiment into a folder and say what it comes to: tables, verdicts at every seed, figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from experiments.bench import console, figures, offline_figures
from experiments.bench.claims import Outcome
from experiments.bench.model_option import shown_models
from experiments.bench.offline import CLIP_SCHEMA, SERIES_SCHEMA, OfflineExperiment, Showing, show, showings
from experiments.bench.offline_claims import judge
from experiments.bench.paper import claim_texts
from experiments.bench.plan import versions
from experiments.bench.pool import Pool
from experiments.bench.results import Failure, Finished, RunFolder
from experiments.bench.runner import run_all
from experiments.bench.settings import check_counts, watchers

NS_A_PIXEL = 25.0
"""About what a model takes for one: for estimates."""


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
            "versions": versions(),
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


def estimate(made: OfflinePlan, workers: int) -> str:
    """The design check: clips, frames, expected time."""
    clips = [clip.build(made.seed) for clip in made.experiment.clips]
    frames = made.repeats * sum(map(len, clips))
    pixels = made.repeats * sum(len(clip) * clip.shape[0] * clip.shape[1] for clip in clips)
    seconds = pixels * NS_A_PIXEL * 1e-9 * len(made.showings[0].models) / max(workers, 1) + console.START_S
    return f"{len(made.showings)} clips, {frames:,} frames, about {seconds:.0f} s on {max(workers, 1)} workers"


def run(made: OfflinePlan, out: Path, pool: Pool, means: console.Means, resume: bool, record: bool) -> OfflineReport:
    """Show what has not been shown, with progress, and conclude; ``record`` the first seed's clips."""
    folder = RunFolder(out, CLIP_SCHEMA, SERIES_SCHEMA)
    folder.enter(made.describe(), resume)
    done = len(folder.done())
    if not means.quiet:
        resumed = f"; {done} of them done already" if done else ""
        said = f"{made.experiment.name}: {estimate(made, means.workers)}{resumed}, into {out}"
        console.error_console.print(said, soft_wrap=True, markup=False)
    with console.progress(made.experiment.name, len(made.showings) - done, means.quiet, "clips") as advance:
        failures = run_all(made.showings, folder, pool, advance, partial(_show, record=record))
    console.tell(failures)
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
    first = by_seed[0]
    holding = sum(outcome.verdict == "holds" for outcome in by_seed)
    return OfflineVerdict(
        claim, says, source, first.verdict, first.measured, first.effect, first.n, holding, len(by_seed)
    )
