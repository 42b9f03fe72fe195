"""Check of the claims that an experiment declares."""

from __future__ import annotations

from typing import Any

from experiments.bench.run.errors import short
from experiments.bench.stats.claim import Claim


def check_claims(experiment: str, claims: Any) -> None:
    """Raise ``ValueError`` for claims that no experiment can declare: a tuple of ids, and of claims of one's own."""
    if not isinstance(claims, tuple) or not all(isinstance(claim, str | Claim) for claim in claims):
        value = f"the claim {claims.id}" if isinstance(claims, Claim) else short(claims)
        hint = "; a comma makes one: (X,)" if isinstance(claims, str | Claim) else ""
        where = f"experiment {experiment}: claims={value}"
        raise ValueError(f"{where}: legal is a tuple of names, and of claims of your own{hint}")
    for claim in claims:
        if isinstance(claim, Claim) and not claim.own:
            raise ValueError(f"experiment {experiment}: claim {claim.id} is the paper's: declare it by its id alone")
    ids = [claim.id for claim in claims if isinstance(claim, Claim)]
    twice = next((name for name in ids if ids.count(name) > 1), None)
    if twice is not None:
        raise ValueError(f"experiment {experiment}: two claims are called '{twice}'")
