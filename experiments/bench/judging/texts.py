"""What ``claims.toml``, ``tried.toml``, ``headlines.toml`` and ``readings.toml`` say of the paper's claims."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

CHOSEN = "chosen"
"""The table of ``claims.toml`` that has no claims: reading of the paper -> the claims that it was chosen for."""
EVERY_CLAIM = "all"


@cache
def claim_texts() -> Mapping[str, tuple[str, str]]:
    """Claim id -> (what the paper says, the label of its figure), in order of number."""
    parts = [part for name, room in _table("claims").items() if name != CHOSEN for part in room.values()]
    texts = {claim["id"]: (claim["says"], part["source"]) for part in parts for claim in part["claims"]}
    return dict(sorted(texts.items(), key=lambda item: int(item[0][1:])))


@cache
def chosen() -> Mapping[str, tuple[str, ...]]:
    """Claim id -> the readings of the paper that were chosen because this claim favoured them, in words.

    Raises
    ------
    ValueError
        ``claims.toml`` names a claim there that it does not have.
    """
    named = _named()
    unknown = {claim for claims in named.values() for claim in claims} - {EVERY_CLAIM, *claim_texts()}
    if unknown:
        raise ValueError(f"claims.toml: [{CHOSEN}] names {', '.join(sorted(unknown))}, which is no claim")
    return {
        claim: tuple(in_words(name) for name, claims in named.items() if claim in claims or EVERY_CLAIM in claims)
        for claim in claim_texts()
    }


def readings_of_all() -> tuple[str, ...]:
    """Return the readings, in words, that were chosen for all claims together."""
    first, *others = chosen().values()
    return tuple(reading for reading in first if all(reading in other for other in others))


@dataclass(frozen=True, slots=True)
class Reading:
    """A reading of the paper that was taken where it leaves room.

    Parameters
    ----------
    id
        Its name in ``claims.toml`` or ``readings.toml``.
    says
        The paper's words.
    taken, others
        The reading taken, and the others, one or more.
    note
        What a reader has to know of them.
    own
        The claims it was chosen for, or that tell the readings apart; empty where it was chosen for all.
    used
        Whether it was chosen because these claims, or all claims, favoured it.
    """

    id: str
    says: str
    taken: str
    others: tuple[str, ...]
    note: str
    own: tuple[str, ...]
    used: bool

    @property
    def name(self) -> str:
        """Its name in words, as `chosen` tells it."""
        return in_words(self.id)

    @property
    def of_all(self) -> bool:
        """Whether it was chosen for all claims together."""
        return self.used and not self.own


@cache
def readings() -> tuple[Reading, ...]:
    """Return the readings that were taken, in the order of ``readings.toml``.

    Raises
    ------
    ValueError
        ``claims.toml`` has a reading that is not described there.
    """
    named, told = _named(), _table("readings")
    missing = sorted(set(named) - set(told))
    if missing:
        raise ValueError(f"readings.toml: it lacks {', '.join(missing)}, of [{CHOSEN}] in claims.toml")
    found = []
    for name, text in told.items():
        own = tuple(claim for claim in named.get(name, text.get("claims", ())) if claim != EVERY_CLAIM)
        found.append(
            Reading(name, text["says"], text["taken"], tuple(text["others"]), text["note"], own, name in named)
        )
    return tuple(found)


def in_words(reading: str) -> str:
    """Return a reading's name in words."""
    return reading.replace("_", " ")


def _named() -> Mapping[str, list[str]]:
    """Reading -> the claims that it was chosen for, as ``claims.toml`` has them."""
    named: Mapping[str, list[str]] = _table("claims").get(CHOSEN, {})
    return named


def tried() -> Mapping[str, str]:
    """Claim id -> what was tried to make it hold, or limits it, from ``tried.toml``."""
    return _table("tried")


def title(claim: str) -> str:
    """Return what a claim says in a few words, from ``headlines.toml``; empty of a claim without a title."""
    titles: Mapping[str, str] = _table("headlines")["titles"]
    return titles.get(claim, "")


def causes() -> Mapping[str, str]:
    """Claim id -> in one line why it fails, or holds in some replicates only, from ``headlines.toml``."""
    found: Mapping[str, str] = _table("headlines")["causes"]
    return found


@cache
def _table(name: str) -> dict[str, Any]:
    return tomllib.loads(files("experiments.bench.judging").joinpath(f"{name}.toml").read_text(encoding="utf-8"))
