"""The paper's claims in a reproduction: each with the verdict of the runs that answer for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from experiments.bench.clips import claims as clips_claims
from experiments.bench.clips.summary import OfflineReport
from experiments.bench.core.verdict import Verdict, claim_texts, tried
from experiments.bench.footage import claims as footage_claims
from experiments.bench.reproduction import robustness
from experiments.bench.reproduction.plan import LOOMING_DETECTORS
from experiments.bench.robot.claims import find
from experiments.bench.robot.plan import Plan
from experiments.bench.robot.summary import Report

RELIABLE = 0.9
"""The share of seeds a claim should hold at."""
NOTHING_TRIED = "nothing yet: it held when the defaults were chosen"


def verdicts(
    runs: Sequence[tuple[Plan, Report]],
    shows: Sequence[OfflineReport],
    by_seed: Mapping[str, Mapping[str, str]],
    pooled: Mapping[str, Verdict],
    mixed: str,
) -> list[Verdict]:
    """Return a verdict for every claim of the paper, in its order; one that nothing here tests says so.

    Parameters
    ----------
    runs
        The experiments with the robot.
    shows
        The off-line experiments.
    by_seed
        Seed -> claim -> verdict, of the study of seeds.
    pooled
        Claim -> its verdict on the trials of all seeds together.
    mixed
        Which code computed these trials, in words, if several did.
    """
    shown = {verdict.id: verdict for report in shows for verdict in report.verdicts}
    reports = {each.experiment.name: report for each, report in runs}
    found = []
    for claim in claim_texts():
        name = robustness.judged_in().get(claim, "")
        if claim in shown:
            verdict = _explained(shown[claim])
        elif claim in clips_claims.CLAIMS or claim == footage_claims.CLAIM or not name:
            verdict = _untested(claim)
        elif find(claim).models:
            (verdict,) = [_explained(v) for v in reports[name].verdicts if v.id == claim]
            verdict = replace(verdict, experiment=name)
        elif find(claim).about == "looming":
            verdict = _of_looming(claim, name, reports[name])
        else:
            verdict = _of_robot(claim, name, reports[name], by_seed, pooled[claim], mixed)
        found.append(verdict)
    return found


def _untested(claim: str) -> Verdict:
    if claim in clips_claims.CLAIMS:
        why = "its off-line experiment was not run (--quick and --robot-only leave some out)"
    elif claim == footage_claims.CLAIM:
        why = "needs footage of your own: colias watch FILE --judge"
    else:
        why = "none of the experiments here declares this claim"
    return Verdict(claim, *claim_texts()[claim], "untested", why)


def _explained(verdict: Verdict) -> Verdict:
    """The verdict with what was tried, where it fails or holds at few seeds."""
    rare = verdict.seeds is not None and (verdict.seeds_holding or 0) < RELIABLE * verdict.seeds
    if verdict.verdict != "fails" and not rare:
        return verdict
    return replace(verdict, tried=tried().get(verdict.id, NOTHING_TRIED))


def _of_robot(
    claim: str, name: str, report: Report, by_seed: Mapping[str, Mapping[str, str]], whole: Verdict, mixed: str
) -> Verdict:
    (verdict,) = [v for v in report.verdicts if v.id == claim and v.model == robustness.MODEL]
    found = [seed[claim] for seed in by_seed.values()]
    return _explained(
        replace(
            verdict, model="", experiment=name, seeds=len(found), seeds_holding=found.count("holds"),
            seeds_untested=found.count("untested"),
            pooled="; ".join([f"{whole.verdict}: {whole.measured}", *([mixed] if mixed else [])]),
        )
    )  # fmt: skip


def _of_looming(claim: str, name: str, report: Report) -> Verdict:
    """A claim about looming detectors: it holds if it does for each of them."""
    own = [v for v in report.verdicts if v.id == claim and v.model in LOOMING_DETECTORS]
    found = {verdict.verdict for verdict in own}
    missing = [name for name in LOOMING_DETECTORS if name not in {v.model for v in own}]
    parts = [*(f"{v.model} {v.verdict}: {v.measured}" for v in own), *(f"{name} was not shown" for name in missing)]
    verdict = Verdict(
        claim, *claim_texts()[claim],
        "untested" if missing or "untested" in found else "fails" if "fails" in found else "holds",
        "; ".join(parts), "; ".join(f"{v.model}: {v.effect}" for v in own), sum(v.n for v in own), experiment=name,
    )  # fmt: skip
    decided = "; ".join(f"{v.model}: {v.decided}" for v in own if v.verdict == verdict.verdict and v.decided)
    return _explained(replace(verdict, decided=decided))
