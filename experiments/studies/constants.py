"""Claims that compare the DSNN with another model, along that model's constants, which are not known.

A claim is judged once for each variant of the other model, on the same clips: see
`experiments.bench.sources.clip_claims.ASSUMED`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from experiments import Axis, Level, Study
from experiments.bench.sources.clip_claims import ASSUMED, find, paper_claims
from experiments.bench.stats.verdict import Outcome

LISTED = 8
"""Choices of constants up to which they are listed one by one."""
SPEED: Mapping[str, float] = {"C6": 120.0}
"""The object's speed in a claim's own clips, px/s, where its words name none."""
STUDIES = ("constants-2017", "constants-emd")


def compares_with(claim: str) -> str:
    """Return the label of the model of unknown constants that a claim compares the DSNN with; empty if none."""
    paper = paper_claims().get(claim)
    return next((model for model in ASSUMED if paper and model in paper.models), "")


def along(name: str, summary: str, claims: Sequence[str], other: str, variants: Sequence[str]) -> Study:
    """Return the study of claims along the constants of another model.

    Parameters
    ----------
    name
        The study, and the experiment that shows the variants.
    summary
        A line for ``colias list``.
    claims
        Ids of claims that compare the DSNN with the other model.
    other
        The other model's label.
    variants
        Its labels with other constants: ``dsn2017:k_sig=10``.
    """
    levels = tuple(
        Level(label.partition(":")[2].replace(",", ", ") or "as assumed", plays={other: label}) for label in variants
    )
    asked = []
    for claim in map(find, claims):  # on the clips that its words mean: the experiments show other speeds too
        speed = {"speed": (SPEED[claim.id],)} if claim.id in SPEED else {}
        asked.append(replace(claim, settled=True, equal_terms={}, conditions={**claim.conditions, **speed}))
    return Study(name, summary, tuple(asked), experiments=(name,), axes=(Axis(f"constants of {other}", levels),),
                 repeats=None, replicates=1, as_run=True, tables=listed)  # fmt: skip


def outcomes(result: Any, claim: str) -> dict[str, Outcome]:
    """Return each choice of the other model's constants -> a claim's outcome with it in replicate 0."""
    return {point[0][1]: found[0] for (point, _, name), found in result.outcomes.items() if name == claim}


def listed(result: Any) -> dict[str, list[dict[str, Any]]]:
    """Return the table of the constants with which each claim holds."""
    claims = [claim.id for claim, _ in result.plan.claims]
    rows = [{"claim": claim, "over all choices": constants_text(outcomes(result, claim))} for claim in claims]
    return {"With which constants each claim holds": rows}


def constants_text(by_constants: Mapping[str, Outcome]) -> str:
    """Return with which constants a claim holds and with which it does not, in words: a long list is only counted."""
    holding = [constants for constants, outcome in by_constants.items() if outcome.verdict == "holds"]
    others = [constants for constants in by_constants if constants not in holding]
    parts = [f"{len(holding)} of {len(by_constants)} choices of the constants tried let it hold"]
    for words, choices in (("it holds with", holding), ("it does not with", others)):
        if 0 < len(choices) <= LISTED:
            parts.append(f"{words} {'; '.join(choices)}")
    return "; ".join(parts)
