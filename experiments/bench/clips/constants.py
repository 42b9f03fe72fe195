"""Claims that compare the DSNN with another model, along that model's constants: with which of them each would hold.

The constants of the other models are not known: see `experiments.bench.clips.judging.ASSUMED`. A claim is judged here
by its own judge once for each variant of the other model, all on the same clips.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache, partial

from experiments.bench.clips.claims import ClipClaim, find, paper_claims
from experiments.bench.clips.judging import ASSUMED, DSNN, Rows, deciding
from experiments.bench.judging.verdict import Outcome

SUFFIX = "-constants"
LISTED = 8
"""Choices of constants up to which they are told one by one."""
SPEED: Mapping[str, float] = {"C6": 120.0}
"""The object's speed in a claim's own clips, px/s, where its words name none."""


def compares_with(claim: str) -> str:
    """Return the label of the model of unknown constants that a claim compares the DSNN with; empty if none."""
    paper = paper_claims().get(claim)
    return next((model for model in ASSUMED if paper and model in paper.models), "")


@cache
def comparing() -> tuple[str, ...]:
    """Return the claims that say something of a model whose constants are not known."""
    return tuple(claim for claim in paper_claims() if compares_with(claim))


def along_constants(claim: str, variants: Sequence[str]) -> ClipClaim:
    """Return one of the paper's claims about two models, asked of other constants of the other model.

    Parameters
    ----------
    claim
        Its id: ``C5``, ``C6``, ``C7``, ``C11`` or ``C26``.
    variants
        Labels of the other model with its constants: ``dsn2017:k_sig=10``.

    Returns
    -------
    ClipClaim
        A claim of our own, not the paper's: ``C7-constants``. It holds if the paper's does with one of the variants.

    Raises
    ------
    ValueError
        The claim is not about such a model, or there are no variants, or one is of another model.

    Examples
    --------
    >>> from experiments import along_constants
    >>> along_constants("C7", ("dsn2017", "dsn2017:k_sig=10")).id
    'C7-constants'
    """
    if claim not in comparing():
        raise ValueError(f"along_constants: claim={claim!r}: legal is {', '.join(comparing())}")
    other = compares_with(claim)
    wrong = [label for label in variants if label.partition(":")[0] != other]
    if wrong or not variants:
        raise ValueError(f"along_constants: variants={tuple(variants)}: legal are labels of {other}, one or more")
    conditions = dict(find(claim).conditions)
    if claim in SPEED:
        conditions["speed"] = (SPEED[claim],)
    return ClipClaim(
        id=f"{claim}{SUFFIX}",
        says=f"{claim} with one at least of {len(variants)} choices of the constants of {other}, which are not known",
        source=find(claim).source,
        judge=partial(_with_any, claim),
        models=frozenset({DSNN, *variants}),
        conditions=conditions,
    )


def outcomes(claim: str, rows: Rows, threshold: float) -> dict[str, Outcome]:
    """Return each choice of the other model's constants -> what one of the paper's claims comes to with it.

    Parameters
    ----------
    claim
        The paper's, one of `comparing`.
    rows
        Rows of ``trials.parquet`` that the claim is about, of the DSNN and of the other model's variants, of one seed.
    threshold
        The DSNN's spiking threshold.
    """
    other = compares_with(claim)
    alone = [row for row in rows if row["model"] == DSNN]
    labels = [label for label in dict.fromkeys(row["model"] for row in rows) if label.partition(":")[0] == other]
    return {
        _constants(label): find(claim).judge(
            [*alone, *({**row, "model": other} for row in rows if row["model"] == label)], threshold
        )
        for label in labels
    }


def _with_any(claim: str, rows: Rows, threshold: float) -> Outcome:
    found = outcomes(claim, rows, threshold)
    first = next(iter(found.values()))
    for constants, each in found.items():
        if each.verdict == "holds":
            return Outcome("holds", said(found), n=each.n, decided=f"{constants}: {each.decided}")
    return Outcome("fails", said(found), n=first.n, decided=deciding(first))


def said(found: Mapping[str, Outcome]) -> str:
    """Return with which constants a claim holds and with which it does not, in words: a long list is only counted."""
    holding = [constants for constants, each in found.items() if each.verdict == "holds"]
    others = [constants for constants in found if constants not in holding]
    parts = [f"{len(holding)} of {len(found)} choices of the constants tried let it hold"]
    for what, choices in (("it holds with", holding), ("it does not with", others)):
        if 0 < len(choices) <= LISTED:
            parts.append(f"{what} {_listed(choices)}")
    return "; ".join(parts)


def _listed(choices: Sequence[str]) -> str:
    """Several choices; a name that all have in common is told once."""
    names = {text.partition("=")[0] for text in choices}
    if len(names) == 1 and all(text.count("=") == 1 for text in choices):
        return f"{names.pop()} = {', '.join(text.partition('=')[2] for text in choices)}"
    return "; ".join(choices)


def _constants(label: str) -> str:
    """The constants in a label: ``spacing=4, tau_lp=50``."""
    return label.partition(":")[2].replace(",", ", ") or "as assumed"
