"""Which of the paper's claims hold: its robot experiments, the studies of seed and sensitivity, the verdicts."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from colias_sim.gl import require_backend
from experiments.bench import catalogue, console, study
from experiments.bench.conclusion import Report, conclude
from experiments.bench.paper import claim_texts
from experiments.bench.plan import Plan, describe
from experiments.bench.pool import Pool, open_pool
from experiments.bench.results import Failure, RunFolder
from experiments.bench.runner import Keep, run_trials
from experiments.bench.settings import plan

JUDGED_IN = {
    "C13": "general", "C14": "general", "C15": "speed", "C16": "distance", "C17": "angular-approach",
    "C18": "angular-approach", "C19": "angular-recession", "C20": "angular-recession",
}  # fmt: skip
"""Claim -> the experiment whose trials answer for it."""


@dataclass(frozen=True, slots=True)
class Scale:
    """How much to run: repeats of the experiments, number of seeds with repeats at each, repeats for sensitivity."""

    repeats: int
    seeds: int
    seed_repeats: int
    sensitivity_repeats: int


QUICK = Scale(repeats=2, seeds=2, seed_repeats=1, sensitivity_repeats=1)
USUAL = Scale(repeats=10, seeds=20, seed_repeats=2, sensitivity_repeats=2)
FULL = Scale(repeats=10, seeds=20, seed_repeats=10, sensitivity_repeats=10)


@dataclass(frozen=True, slots=True)
class ClaimReport:
    """A claim's line in the report and in ``claims.json``."""

    id: str
    says: str
    source: str
    verdict: str
    measured: str
    effect: str
    n: int
    experiment: str
    seeds_holding: int | None
    seeds: int | None


@dataclass(frozen=True, slots=True)
class Reproduction:
    """Everything the report shows."""

    folder: Path
    scale: Scale
    seed: int
    claims: list[ClaimReport]
    runs: list[tuple[Plan, Report]]
    sensitivity: dict[str, dict[str, str]]
    description: Mapping[str, Any]


def reproduce(
    folder: Path, scale: Scale, seed: int, models: Sequence[str], means: console.Means, extra: Sequence[str] = (),
) -> Reproduction:  # fmt: skip
    """Run what is missing of it all into ``folder``, then judge. Goes on where an earlier call stopped.

    ``models`` see the experiments' frames beside the DSNN, on which the claims are judged; ``extra`` experiments
    (names or files) are run and shown too.
    """
    names = [*study.PAPER, *extra]
    plans = [plan(catalogue.load(name), [study.MODEL, *models], (), scale.repeats, seed) for name in names]
    seeds = study.seed_cases(range(seed, seed + scale.seeds), scale.seed_repeats)
    moves = study.sensitivity_cases(scale.sensitivity_repeats, seed)
    if means.cluster is None:
        require_backend()
    folder.mkdir(parents=True, exist_ok=True)
    runs: list[tuple[Plan, Report]] = []
    failures: list[tuple[Plan, RunFolder, list[Failure]]] = []
    with open_pool(means.workers, means.cluster) as pool:
        for each in plans:
            out = folder / each.experiment.name
            run = console.open_folder(each, out, resume=(out / "experiment.json").exists())
            failures.append((each, run, console.run_with(each, run, pool, means, recordings=True)))
        seed_rows = _study(folder / "seeds", "other seeds", seeds, plans[0], pool, means)
        move_rows = _study(folder / "sensitivity", "sensitivity", moves, plans[0], pool, means)
    runs = [(each, conclude(each, run, failed)) for each, run, failed in failures]
    by_seed = study.verdicts(seeds, seed_rows)
    claims = _claims(runs, by_seed)
    result = Reproduction(folder, scale, seed, claims, runs, study.verdicts(moves, move_rows), describe(plans[0]))
    RunFolder(folder).write_json("claims.json", claims)
    return result


def _study(
    folder: Path, name: str, cases: Sequence[study.Case], example: Plan, pool: Pool, means: console.Means
) -> list[dict[str, Any]]:
    """The rows of a study's trials, which keep neither recordings nor frames."""
    specs = study.numbered(cases)
    run = RunFolder(folder)
    listed = [{"case": case.name, "trials": len(case.specs), "settings": case.specs[0].settings} for case in cases]
    description = {**describe(example), "experiment": name, "trials": len(specs), "cases": listed}
    if (folder / "experiment.json").exists():
        run.reopen(description)
    else:
        run.create(description)
    left = len(specs) - len(run.done())
    if not means.quiet:
        console.error_console.print(f"{name}: {len(specs)} trials, {left} of them to do", markup=False)
    with console.progress(name, left, means.quiet) as advance:
        run_trials(specs, run, pool, advance, Keep(recordings=False, frames=False))
    return run.rows()


def _claims(runs: Sequence[tuple[Plan, Report]], by_seed: Mapping[str, Mapping[str, str]]) -> list[ClaimReport]:
    """Every claim of the paper, in its order; those that nothing here tests yet say so."""
    reports = {each.experiment.name: report for each, report in runs}
    lines = []
    for claim, (says, source) in claim_texts().items():
        if claim not in JUDGED_IN:
            missing = "needs looming detectors" if claim == "C21" else "needs the off-line stimuli"
            lines.append(
                ClaimReport(claim, says, source, "untested", f"{missing}, not built yet", "", 0, "", None, None)
            )
            continue
        name = JUDGED_IN[claim]
        (verdict,) = [v for v in reports[name].verdicts if v.id == claim and v.model == study.MODEL]
        judged = [seed[claim] for seed in by_seed.values() if seed[claim] != "untested"]
        lines.append(
            ClaimReport(
                claim, says, source, verdict.verdict, verdict.measured, verdict.effect, verdict.n, name,
                judged.count("holds"), len(judged),
            )
        )  # fmt: skip
    return lines


def as_json(result: Reproduction) -> list[dict[str, Any]]:
    """The claims as plain values."""
    return [dataclasses.asdict(claim) for claim in result.claims]
