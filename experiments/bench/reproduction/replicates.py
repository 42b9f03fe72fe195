"""The paper's experiments with the robot, and the outcomes of its claims in their replicates.

Which experiments there are and which models they show, the one that answers for each claim, and the claims judged.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence

from experiments.bench import registry
from experiments.bench.sources.robot_claims import find
from experiments.bench.stats.tests import proportion_interval
from experiments.bench.stats.verdict import Outcome
from experiments.bench.studies import replicates
from experiments.bench.studies.replicates import Replicate, asked_models

SHOWN = ("distance-mechanism", "approach-mechanism", "recession-mechanism")
"""Experiments without claims that the report shows, at the headline's seed alone."""


def single_model_experiments() -> tuple[str, ...]:
    """Return those of the paper's experiments that show one model: not those that compare moves of the network."""
    return tuple(name for name in registry.paper_experiments() if len(registry.load(name).models) == 1)


def models_in(among: Collection[str] | None = None, beside: Sequence[str] = ()) -> dict[str, list[str]]:
    """Return each of the paper's experiments with the models shown there in every replicate.

    Parameters
    ----------
    among
        Models to be shown; ``None``: all that claims need, and `MODEL`.
    beside
        Models that are shown in those of `single_model_experiments` too.
    """
    return {
        name: [
            *(model for model in asked_models(registry.load(name)) if among is None or model in among),
            *(beside if name in single_model_experiments() else ()),
        ]
        for name in registry.paper_experiments()
    }


def judged(claim: str, trials: Replicate) -> Outcome:
    """Judge a claim in one replicate: for the DSNN, for the models it compares, or for each looming detector."""
    return replicates.judged(find(claim), trials, registry.answering()[claim])


def pooled(claim: str, every: Sequence[Replicate]) -> Outcome:
    """Judge a claim on the trials of all replicates together."""
    rows = tuple(row for replicate in every for row in replicate.rows)
    lost = sum((Counter(replicate.lost) for replicate in every), Counter[tuple[str, str]]())
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
