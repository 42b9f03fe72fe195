"""What is written of the paper's claims in ``claims.toml`` and ``tried.toml``."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
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
    named: Mapping[str, list[str]] = _table("claims").get(CHOSEN, {})
    unknown = {claim for claims in named.values() for claim in claims} - {EVERY_CLAIM, *claim_texts()}
    if unknown:
        raise ValueError(f"claims.toml: [{CHOSEN}] names {', '.join(sorted(unknown))}, which is no claim")
    return {
        claim: tuple(
            name.replace("_", " ") for name, claims in named.items() if claim in claims or EVERY_CLAIM in claims
        )
        for claim in claim_texts()
    }


def readings_of_all() -> tuple[str, ...]:
    """Return the readings, in words, that were chosen for all claims together."""
    first, *others = chosen().values()
    return tuple(reading for reading in first if all(reading in other for other in others))


@cache
def tried() -> Mapping[str, str]:
    """Claim id -> what was tried to make it hold, or limits it, from ``tried.toml``."""
    return _table("tried")


def _table(name: str) -> dict[str, Any]:
    return tomllib.loads(files("experiments.bench.core").joinpath(f"{name}.toml").read_text(encoding="utf-8"))
