"""Which of the paper's claims hold: its experiments, the studies of seed and sensitivity, the verdicts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from colias_sim.gl import require_backend
from experiments.bench import (
    behave,
    behave_figure,
    behaviour_claims,
    console,
    footage_claims,
    offline_claims,
    offline_run,
    study,
)
from experiments.bench.behave import BehaviourPlan, Played
from experiments.bench.behaviour_claims import BehaviourClaim
from experiments.bench.claims import LOOMING_CLAIMS, Verdict
from experiments.bench.conclusion import Report, conclude
from experiments.bench.contents import robot_contents
from experiments.bench.description import begun
from experiments.bench.files import UsageError
from experiments.bench.model_option import shown_models
from experiments.bench.offline_run import OfflineReport, OfflineVerdict
from experiments.bench.paper import claim_texts, tried
from experiments.bench.plan import Plan, describe
from experiments.bench.pool import Pool, open_pool
from experiments.bench.reproduce_plan import BESIDE as BESIDE
from experiments.bench.reproduce_plan import ENOUGH as ENOUGH
from experiments.bench.reproduce_plan import FULL as FULL
from experiments.bench.reproduce_plan import (
    LOOMING_DETECTORS,
    SEEDS,
    SENSITIVITY,
    Scale,
    design,
    planned,
)
from experiments.bench.reproduce_plan import QUICK as QUICK
from experiments.bench.reproduce_plan import USUAL as USUAL
from experiments.bench.results import Failure, RunFolder, mixture
from experiments.bench.runner import Keep, work

RELIABLE = 0.9
"""The share of seeds a claim should hold at."""
NOTHING_TRIED = "nothing yet: it held when the defaults were chosen"


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
    """How many seeds the claim was to be judged at; ``seeds_untested`` of them could not."""
    seeds_untested: int | None
    pooled: str
    """The same on the trials of all seeds together."""
    tried: str
    """What was tried, if it fails or does not hold at nine seeds of ten."""
    decided: str = ""
    """The number that decided the verdict, and its bound."""


@dataclass(frozen=True, slots=True)
class Reproduction:
    """Everything the report shows."""

    folder: Path
    scale: Scale
    seed: int
    claims: list[ClaimReport]
    runs: list[tuple[Plan, Report]]
    offline: list[OfflineReport]
    sensitivity: dict[str, dict[str, str]]
    behaviours: list[Played]
    """Episodes in each env."""
    own_claims: list[BehaviourClaim]
    """Ours, about behaviours."""
    failures: Mapping[str, Sequence[Failure]]
    """Those of the two studies."""
    description: Mapping[str, Any]


def models_shown(given: Sequence[str] | None, only: bool) -> list[str]:
    """The models that ``--model`` and ``--only`` ask for; `UsageError` without the one that the claims are about."""
    names = shown_models((study.MODEL, *BESIDE), given, only)
    if study.MODEL not in names:
        raise UsageError(f"--only: the claims are about {study.MODEL}: give --model {study.MODEL} too")
    return names


def reproduce(
    folder: Path, scale: Scale, seed: int, models: Sequence[str], means: console.Means, extra: Sequence[str] = (),
    robot_only: bool = False, only: bool = False,
) -> Reproduction:  # fmt: skip
    """Run what is missing of it all into ``folder``, then judge. Goes on where an earlier call stopped.

    ``models`` see the experiments' frames beside the DSNN, on which the claims are judged; ``extra`` experiments
    (names or files) are run and shown too. With ``robot_only`` neither clips are shown nor behaviours played; with
    ``only`` the looming detectors are not shown either, and the claim about them is untested.
    """
    made = planned(scale, seed, models, extra, robot_only, only)
    plans, seeds, moves = made.plans, made.seeds, made.moves
    if means.cluster is None:
        require_backend()
    if not means.quiet:
        console.announce(plans, sum(len(case.specs) for case in (*seeds, *moves)), folder, means)
    done: list[tuple[Plan, RunFolder, list[Failure]]] = []
    with ExitStack() as locks:
        with open_pool(means.workers, means.cluster) as pool:
            folder.mkdir(parents=True, exist_ok=True)
            for each in plans:
                out = folder / each.experiment.name
                run = console.open_folder(each, out, means, begun(out), recordings=True)
                locks.callback(run.close)
                done.append((each, run, console.run_with(each, run, pool, means, recordings=True)))
            shows = [_show(each, folder / each.experiment.name, pool, means) for each in made.offline]
            played = [_play(each, folder, pool, means) for each in made.loops]
            seed_rows, seed_failures = _study(folder / SEEDS, "other seeds", seeds, plans[0], pool, means)
            move_rows, move_failures = (
                _study(folder / SENSITIVITY, "sensitivity", moves, plans[0], pool, means) if moves else ([], [])
            )
        runs = [(each, conclude(each, run, failed)) for each, run, failed in done]
    claims = _claims(runs, shows, study.verdicts(seeds, seed_rows), study.pooled(seeds, seed_rows), mixture(seed_rows))
    failures = {SEEDS: seed_failures, SENSITIVITY: move_failures}
    sensitivity = study.verdicts(moves, move_rows)
    own = behaviour_claims.judge([standing for each in played for standing in each.standings]) if played else []
    result = Reproduction(
        folder, scale, seed, claims, runs, shows, sensitivity, played, own, failures, describe(plans[0])
    )
    RunFolder(folder).write_json("design.json", design(made))
    RunFolder(folder).write_json("claims.json", claims)
    if own:
        RunFolder(folder).write_json("behaviours.json", own)
    return result


def _play(each: BehaviourPlan, folder: Path, pool: Pool, means: console.Means) -> Played:
    """The episodes in one env, without recordings, and their figure."""
    short = each.settings[0].env.partition("/")[2].partition("-")[0].lower()
    done = behave.run_with(each, folder / f"behave-{short}", pool, means, 0)
    behave_figure.write(done)
    return done


def _show(each: offline_run.OfflinePlan, out: Path, pool: Pool, means: console.Means) -> OfflineReport:
    return offline_run.run(each, out, pool, means, begun(out), each.experiment.recorded)


def _study(
    folder: Path, name: str, cases: Sequence[study.Case], example: Plan, pool: Pool, means: console.Means
) -> tuple[list[dict[str, Any]], list[Failure]]:
    """The rows of a study's trials, which keep neither recordings nor frames, and what failed."""
    specs = study.numbered(cases)
    listed = [{"case": case.name, "trials": len(case.specs), "settings": case.specs[0].settings} for case in cases]
    description = {**describe(example), "experiment": name, "trials": len(specs), "cases": listed}
    with closing(RunFolder(folder)) as run:
        run.enter(description, begun(folder), robot_contents(specs, recordings=False, frames=False), means.other_code)
        left = len(specs) - len(run.done())
        if not means.quiet:
            console.error_console.print(f"{name}: {len(specs)} trials, {left} of them to do", markup=False)
        kept = partial(work, keep=Keep(recordings=False, frames=False))
        failures = console.do(name, specs, run, pool, means, kept, size=console.seconds)
        return run.rows(), failures


def _claims(
    runs: Sequence[tuple[Plan, Report]],
    shows: Sequence[OfflineReport],
    by_seed: Mapping[str, Mapping[str, str]],
    pooled: Mapping[str, Verdict],
    mixed: str,
) -> list[ClaimReport]:
    """Every claim of the paper, in its order; those that nothing here tests yet say so."""
    shown = {verdict.id: (report, verdict) for report in shows for verdict in report.verdicts}
    reports = {each.experiment.name: report for each, report in runs}
    lines = []
    for claim, (says, source) in claim_texts().items():
        if claim in shown:
            lines.append(_of_clips(*shown[claim]))
            continue
        if claim in offline_claims.JUDGES:
            lines.append(
                _untested(
                    claim, says, source, "its off-line experiment was not run (--quick and --robot-only leave some out)"
                )
            )
            continue
        if claim == footage_claims.CLAIM:
            lines.append(_untested(claim, says, source, "needs footage of your own: colias watch FILE --judge"))
            continue
        name = study.judged_in().get(claim, "")
        if not name:
            lines.append(_untested(claim, says, source, "none of the experiments here declares this claim"))
            continue
        if claim in LOOMING_CLAIMS:
            lines.append(_of_looming(claim, says, source, name, reports[name]))
            continue
        (verdict,) = [v for v in reports[name].verdicts if v.id == claim and v.model == study.MODEL]
        found = [seed[claim] for seed in by_seed.values()]
        whole = pooled[claim]
        said = "; ".join([f"{whole.verdict}: {whole.measured}", *([mixed] if mixed else [])])
        rare = verdict.verdict == "fails" or found.count("holds") < RELIABLE * len(found)
        lines.append(
            ClaimReport(
                claim, says, source, verdict.verdict, verdict.measured, verdict.effect, verdict.n, name,
                found.count("holds"), len(found), found.count("untested"),
                said, tried().get(claim, NOTHING_TRIED) if rare else "", verdict.decided,
            )
        )  # fmt: skip
    return lines


def _of_looming(claim: str, says: str, source: str, name: str, report: Report) -> ClaimReport:
    """A claim about looming detectors: it holds if it does for each of them."""
    own = [v for v in report.verdicts if v.id == claim and v.model in LOOMING_DETECTORS]
    verdicts = {verdict.verdict for verdict in own}
    missing = [name for name in LOOMING_DETECTORS if name not in {v.model for v in own}]
    whole = "untested" if missing or "untested" in verdicts else "fails" if "fails" in verdicts else "holds"
    parts = [*(f"{v.model} {v.verdict}: {v.measured}" for v in own), *(f"{name} was not shown" for name in missing)]
    measured = "; ".join(parts)
    effect = "; ".join(f"{v.model}: {v.effect}" for v in own)
    said = tried().get(claim, NOTHING_TRIED) if whole == "fails" else ""
    decided = "; ".join(f"{v.model}: {v.decided}" for v in own if v.verdict == whole and v.decided)
    return ClaimReport(
        claim, says, source, whole, measured, effect, sum(v.n for v in own), name, None, None, None, "", said, decided
    )


def _of_clips(report: OfflineReport, verdict: OfflineVerdict) -> ClaimReport:
    """A claim about off-line stimuli."""
    rare = verdict.verdict == "fails" or verdict.seeds_holding < RELIABLE * verdict.seeds
    said = tried().get(verdict.id, NOTHING_TRIED) if rare else ""
    return ClaimReport(
        verdict.id, verdict.says, verdict.source, verdict.verdict, verdict.measured, verdict.effect, verdict.n,
        report.plan.experiment.name, verdict.seeds_holding, verdict.seeds, verdict.seeds_untested, "", said,
        verdict.decided,
    )  # fmt: skip


def _untested(claim: str, says: str, source: str, why: str) -> ClaimReport:
    return ClaimReport(claim, says, source, "untested", why, "", 0, "", None, None, None, "", "")
