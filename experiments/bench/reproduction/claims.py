"""The paper's claims in a reproduction: each with the verdict of replicate 0, and in how many replicates it held."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from experiments import OFFLINE
from experiments.bench.clips import claims as clips_claims
from experiments.bench.clips import summary as clips_summary
from experiments.bench.clips.summary import OfflineReport
from experiments.bench.footage import claims as footage_claims
from experiments.bench.judging.claim_files import PAPER, claim_ids
from experiments.bench.judging.claims import used_to_choose, words
from experiments.bench.judging.replicates import ROBUST_SHARE, counted
from experiments.bench.judging.verdict import Outcome, Verdict, together
from experiments.bench.reproduction import robustness
from experiments.bench.reproduction.replicates import Replicate, judged, pooled, rate, with_note
from experiments.bench.robot.claims import find
from experiments.bench.store.rows import mixture

NOTHING_TRIED = "nothing yet: it held when the defaults were chosen"
EVER_MORE = (
    "a claim about every single trial fails ever more surely the more trials there are; the rate of trials does not"
)


def verdicts(replicates: Sequence[Replicate], shows: Sequence[OfflineReport], name: str = "replicate") -> list[Verdict]:
    """Return a verdict for every claim of the paper, in its order; one that nothing here tests says so.

    Parameters
    ----------
    replicates
        The experiments with the robot. The first is replicate 0, the headline.
    shows
        The off-line experiments.
    name
        What a replicate with the robot is called: see `experiments.bench.reproduction.plan.Scale.name`.
    """
    shown = _offline(shows)
    found = []
    for claim in claim_ids(PAPER):
        place = robustness.judged_in().get(claim, "")
        if claim in shown and place:
            verdict = _of_both(shown[claim], claim, place, replicates, name)
        elif claim in shown:
            verdict = shown[claim]
        elif claim in clips_claims.paper_claims() or claim == footage_claims.CLAIM or not place:
            verdict = _untested(claim)  # of both kinds too: its clips were not shown
        else:
            verdict = _of_robot(claim, place, replicates, name)
        found.append(
            _explained(replace(verdict, used_to_choose="; ".join(reading.name for reading in used_to_choose(claim))))
        )
    return found


def _offline(shows: Sequence[OfflineReport]) -> Mapping[str, Verdict]:
    """Claim -> its verdict by clips. A claim that a silent network would keep is held against those of all of them."""
    rows = [row for report in shows for row in report.rows]
    return {
        verdict.id: verdict
        for report in shows
        for verdict in clips_summary.verdicts(report.plan, report.rows, rows, random=is_random(report))
    }


def is_random(report: OfflineReport) -> bool:
    """Whether the clips of an off-line experiment that ships differ with the seed: those that declare repeats do."""
    declared = report.plan.experiment
    return declared.repeats > 1 or declared.name not in OFFLINE


def _untested(claim: str) -> Verdict:
    if claim in clips_claims.paper_claims():
        why = "its off-line experiment was not run (--quick and --robot-only leave some out)"
    elif claim == footage_claims.CLAIM:
        why = "needs footage of your own: colias watch FILE --judge"
    else:
        why = "none of the experiments here declares this claim"
    return words(claim).verdict(Outcome.unjudged(why), overall="untested")


def _explained(verdict: Verdict) -> Verdict:
    """The verdict with what was tried, where it fails or holds in few replicates."""
    rare = verdict.replicates is not None and (verdict.replicates_held or 0) < ROBUST_SHARE * verdict.replicates
    if verdict.verdict != "fails" and not rare:
        return verdict
    return replace(verdict, tried=words(verdict.id).tried or NOTHING_TRIED)


def _of_both(clips: Verdict, claim: str, place: str, replicates: Sequence[Replicate], name: str) -> Verdict:
    """A claim about clips and the robot: it holds in a replicate with the robot if it does there and on the clips."""
    robot = [judged(claim, each) for each in replicates]
    verdicts = [together((each.verdict, clips.verdict)) for each in robot]
    said: list[tuple[str, Verdict | Outcome]] = [("clips", clips), ("the robot", robot[0])]
    deciding = [f"{what}: {each.decided}" for what, each in said if each.verdict == verdicts[0] and each.decided]
    whole = Outcome(
        verdicts[0],
        "; ".join(f"{what} {each.verdict}: {each.measured}" for what, each in said),
        "; ".join(f"{what}: {each.effect}" for what, each in said if each.effect),
        clips.n + robot[0].n,
        "; ".join(deciding),
    )
    fields = counted(verdicts, name=name).fields()
    return find(claim).verdict(whole, experiment=f"{clips.experiment}, {place}", **fields)


def _of_robot(claim: str, place: str, replicates: Sequence[Replicate], name: str) -> Verdict:
    found = [judged(claim, each) for each in replicates]
    whole = pooled(claim, replicates)
    mixed = mixture([row for each in replicates for row in each.rows if row["experiment"] == place])
    share = rate(claim, whole)
    said = f"{whole.verdict}: {whole.measured}"
    return find(claim).verdict(
        with_note(found[0], mixed),
        experiment=place,
        rate=f"{share}; {EVER_MORE}" if share else "",
        pooled=said if len(replicates) > 1 else "",
        **counted([each.verdict for each in found], name=name).fields(),
    )
