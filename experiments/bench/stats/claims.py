"""The claims that ship: what their files declare, by id and by the kind of rows that they are judged on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from experiments.bench.run.errors import UsageError
from experiments.bench.stats.claim import Claim, Reading
from experiments.bench.stats.claim_files import PAPER, claim_ids, claim_module
from experiments.bench.stats.verdict import Verdict
from experiments.claims.readings import READINGS

Kind = TypeVar("Kind", bound=Claim)


def declared(claim: str) -> tuple[Claim, ...]:
    """Return what a claim's file declares: one `Claim` for each kind of rows that it is judged on.

    Parameters
    ----------
    claim
        Its id, one of `experiments.bench.stats.claim_files.claim_ids`.
    """
    values = vars(claim_module(claim)).values()
    return tuple(value for value in values if isinstance(value, Claim) and value.id == claim)


def words(claim: str) -> Claim:
    """Return the first that a claim's file declares: its words are those of all of them.

    Raises `UsageError` if the file, which is found by its name, declares no claim of that id.
    """
    kind = declared(claim)
    if not kind:
        raise UsageError(f"{claim_module(claim).__file__}: declares no claim with the id {claim}, as its name says")
    return kind[0]


def title_of(verdict: Verdict) -> str:
    """Return a claim in a few words: its title, or the words of one of a person's own."""
    return words(verdict.id).title if verdict.id in claim_ids() else verdict.says


def paper_claims() -> Mapping[str, Claim]:
    """Return id -> words of every claim of the paper, in order of number."""
    return {claim: words(claim) for claim in claim_ids(PAPER)}


def of_kind(kind: type[Kind]) -> Mapping[str, Kind]:
    """Return id -> claim, of those that ship and are of one kind, in the order of their ids."""
    return {claim: value for claim in claim_ids() for value in declared(claim) if isinstance(value, kind)}


def find(claim: Claim | str, kind: type[Kind]) -> Kind:
    """Return a claim of one kind by its id; one of a person's own stands for itself.

    Raises
    ------
    KeyError
        None of the claims that ship has that id and is of that kind.
    TypeError
        A claim of one's own is of another kind.
    """
    if isinstance(claim, kind):
        return claim
    if isinstance(claim, Claim):
        raise TypeError(f"claim {claim.id} is a {type(claim).__name__}, expected a {kind.__name__}")
    for value in declared(claim) if claim in claim_ids() else ():
        if isinstance(value, kind):
            return value
    raise KeyError(claim)


def used_to_choose(claim: str) -> tuple[Reading, ...]:
    """Return the readings that were chosen because a claim favoured them, those chosen for all claims too."""
    return tuple(reading for reading in READINGS if reading.used and claim in bears_on(reading))


def readings_of_all() -> tuple[Reading, ...]:
    """Return the readings that were chosen for all claims together."""
    return tuple(reading for reading in READINGS if reading.of_all)


def bears_on(reading: Reading) -> tuple[str, ...]:
    """Return the ids of the claims that a reading was chosen for."""
    return reading.claims or claim_ids(PAPER)
