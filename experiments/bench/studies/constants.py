"""Studies of claims that compare the DSNN with another model, along that model's constants.

The constants of the other models are not known: see `experiments.bench.sources.clip_claims.ASSUMED`. A claim is
judged by its own judge once for each variant of the other model, all on the same clips.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache

from experiments.bench.sources.clip_claims import ASSUMED, ClipClaim, find, paper_claims
from experiments.bench.stats.verdict import Outcome
from experiments.bench.studies.counts import Counts
from experiments.bench.studies.study import Axis, Level, Study, Tables

LISTED = 8
"""Choices of constants up to which they are told one by one."""
SPEED: Mapping[str, float] = {"C6": 120.0}
"""The object's speed in a claim's own clips, px/s, where its words name none."""
STUDIES = ("constants-2017", "constants-emd")


def compares_with(claim: str) -> str:
    """Return the label of the model of unknown constants that a claim compares the DSNN with; empty if none."""
    paper = paper_claims().get(claim)
    return next((model for model in ASSUMED if paper and model in paper.models), "")


@cache
def comparing() -> tuple[str, ...]:
    """Return the claims that say something of a model whose constants are not known."""
    return tuple(claim for claim in paper_claims() if compares_with(claim))


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
    levels = tuple(Level(_constants(label), plays={other: label}) for label in variants)
    return Study(
        name, summary, claims=tuple(_with_constants_given(find(claim)) for claim in claims), experiments=(name,),
        axes=(Axis(f"constants of {other}", levels),), repeats=None, replicates=1, as_run=True, tables=_told,
    )  # fmt: skip


def _with_constants_given(claim: ClipClaim) -> ClipClaim:
    """Return a claim with the other model's constants given, and on the clips that its words mean.

    The experiments show the object at other speeds too.
    """
    speed = {"speed": (SPEED[claim.id],)} if claim.id in SPEED else {}
    return replace(claim, settled=True, equal_terms={}, conditions={**claim.conditions, **speed})


def outcomes(counts: Counts, claim: str) -> dict[str, Outcome]:
    """Return each choice of the other model's constants -> a claim's outcome with it in replicate 0."""
    return {cell.point.values[0][1]: cell.outcomes[0] for cell in counts.cells if cell.claim == claim}


def _told(counts: Counts) -> Tables:
    claims = [claim.id for claim, _ in counts.plan.claims]
    rows = [{"claim": claim, "over all choices": constants_text(outcomes(counts, claim))} for claim in claims]
    return {"With which constants each claim holds": rows}


def constants_text(by_constants: Mapping[str, Outcome]) -> str:
    """Return with which constants a claim holds and with which it does not, in words: a long list is only counted."""
    holding = [constants for constants, outcome in by_constants.items() if outcome.verdict == "holds"]
    others = [constants for constants in by_constants if constants not in holding]
    parts = [f"{len(holding)} of {len(by_constants)} choices of the constants tried let it hold"]
    for what, choices in (("it holds with", holding), ("it does not with", others)):
        if 0 < len(choices) <= LISTED:
            parts.append(f"{what} {_listed(choices)}")
    return "; ".join(parts)


def _listed(choices: Sequence[str]) -> str:
    """Return several choices; a name that all have in common is told once."""
    names = {text.partition("=")[0] for text in choices}
    if len(names) == 1 and all(text.count("=") == 1 for text in choices):
        return f"{names.pop()} = {', '.join(text.partition('=')[2] for text in choices)}"
    return "; ".join(choices)


def _constants(label: str) -> str:
    """Return the constants in a label: ``spacing=4, tau_lp=50``."""
    return label.partition(":")[2].replace(",", ", ") or "as assumed"
