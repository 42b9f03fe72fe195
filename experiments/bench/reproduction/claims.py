"""The paper's claims in a reproduction: what each came to in every replicate, and on all trials together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from experiments.bench import offline, registry
from experiments.bench.footage import claims as footage_claims
from experiments.bench.offline import OfflineReport
from experiments.bench.reproduction import replicates
from experiments.bench.sources.robot_claims import find
from experiments.bench.stats import clips as clips_claims
from experiments.bench.stats.claim import PAPER, claim_ids, words
from experiments.bench.stats.verdict import Outcome, Verdict
from experiments.bench.store.rows import mixture
from experiments.bench.studies.replicates import Replicate, places_of


def verdicts(every: Sequence[Replicate], shows: Sequence[OfflineReport]) -> list[Verdict]:
    """Return a verdict for every claim of the paper, in its order; one that nothing here judges says so.

    Parameters
    ----------
    every
        The experiments with the robot, in each replicate. The first is replicate 0, the headline.
    shows
        The off-line experiments.
    """
    by_clips = _by_clips(shows)
    return [_verdict(claim, every, by_clips.get(claim)) for claim in claim_ids(PAPER)]


def pooled(every: Sequence[Replicate]) -> dict[str, Outcome]:
    """Return the claims about the robot -> the outcome of each on the trials of all replicates together."""
    named = [claim for claim in claim_ids(PAPER) if _about_the_robot(claim)]
    return {claim: replicates.pooled(claim, every) for claim in named}


def _by_clips(shows: Sequence[OfflineReport]) -> Mapping[str, Verdict]:
    """Claim -> its verdict by clips. A claim that a silent network would keep is held against those of all of them."""
    rows = [row for report in shows for row in report.rows]
    return {verdict.id: verdict for report in shows for verdict in offline.verdicts(report.plan, report.rows, rows)}


def _about_the_robot(claim: str) -> bool:
    """Return whether trials with the robot alone answer for a claim."""
    return claim in registry.answering() and claim not in clips_claims.paper_claims() and claim != footage_claims.CLAIM


def _verdict(claim: str, every: Sequence[Replicate], clips: Verdict | None) -> Verdict:
    place = registry.answering().get(claim, "")
    if clips is not None and place:
        return _of_both(clips, place, every)
    if clips is not None:
        return clips
    return _of_robot(claim, place, every) if _about_the_robot(claim) else _unjudged(claim)


def _unjudged(claim: str) -> Verdict:
    if claim in clips_claims.paper_claims():
        why = "its off-line experiment was not run (--quick and --robot-only leave some out)"
    elif claim == footage_claims.CLAIM:
        why = "needs footage of your own: colias watch FILE --judge"
    else:
        why = "none of the experiments here declares this claim"
    return Verdict.of((claim, words(claim).says, words(claim).source), [Outcome.unjudged(why)])


def _of_both(clips: Verdict, place: str, every: Sequence[Replicate]) -> Verdict:
    """A claim about clips and the robot: the clips at their first seed are a part of each replicate with the robot."""
    outcomes = [
        Outcome.together({"clips": clips.outcome, "the robot": replicates.judged(clips.id, replicate)})
        for replicate in every
    ]
    return find(clips.id).verdict(*outcomes, experiment=f"{clips.experiment}, {place}")


def _of_robot(claim: str, place: str, every: Sequence[Replicate]) -> Verdict:
    first, *others = [replicates.judged(claim, replicate) for replicate in every]
    places = places_of(find(claim), place, {row["experiment"] for replicate in every for row in replicate.rows})
    mixed = mixture([row for replicate in every for row in replicate.rows if row["experiment"] in places])
    return find(claim).verdict(first.noting([mixed]), *others, experiment=", ".join(places))
