"""The paper's claims in words, by their ids, and what was tried on them: the .toml files beside this one."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files


@cache
def claim_texts() -> Mapping[str, tuple[str, str]]:
    """Claim id -> (what the paper says, the label of its figure)."""
    table = tomllib.loads(files("experiments.bench").joinpath("claims.toml").read_text(encoding="utf-8"))
    parts = [part for room in table.values() for part in room.values()]
    return {claim["id"]: (claim["says"], part["source"]) for part in parts for claim in part["claims"]}


@cache
def tried() -> Mapping[str, str]:
    """Claim id -> what was tried to make it hold, or limits it, from ``tried.toml``."""
    return tomllib.loads(files("experiments.bench").joinpath("tried.toml").read_text(encoding="utf-8"))
