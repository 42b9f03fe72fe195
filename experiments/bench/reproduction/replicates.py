"""What each of the paper's claims comes to in the replicates of its experiments with the robot."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from experiments.bench.judging.statistics import proportion_interval
from experiments.bench.judging.verdict import Outcome
from experiments.bench.reproduction.robustness import judged_in
from experiments.bench.robot.claims import find
from experiments.bench.studies import replicates
from experiments.bench.studies.replicates import Replicate as Replicate
from experiments.bench.studies.replicates import replicate as replicate


def judged(claim: str, own: Replicate) -> Outcome:
    """Judge a claim in one replicate: for the DSNN, for the models it compares, or for each looming detector."""
    return replicates.judged(find(claim), own, judged_in()[claim])


def pooled(claim: str, every: Sequence[Replicate]) -> Outcome:
    """Judge a claim on the trials of all replicates together."""
    rows = tuple(row for each in every for row in each.rows)
    lost = sum((Counter(each.lost) for each in every), Counter[tuple[str, str]]())
    return judged(claim, Replicate(rows, lost, every[0].thresholds, every[0].looming))


def rate(claim: str, whole: Outcome) -> str:
    """Say which share of all trials breaks a claim about every single one, with its exact 95 % interval.

    Parameters
    ----------
    claim
        The claim's id.
    whole
        The claim on the trials of all replicates.

    Returns
    -------
    str
        Empty where the claim is not about every single trial.
    """
    if whole.broken is None or not find(claim).of_every_trial or not whole.n:
        return ""
    low, high = proportion_interval(whole.broken, whole.n)
    return (
        f"{whole.broken} of {whole.n} trials break it, {whole.broken / whole.n:.1%} (exact 95 % interval {low:.1%} to "
        f"{high:.1%})"
    )
