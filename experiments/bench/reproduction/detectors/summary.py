"""What the row of C21 in the report says of the other detectors, where the folder has their table."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from experiments.bench.judging.verdict import Verdict
from experiments.bench.reproduction.detectors.panel import CLAIM
from experiments.bench.reproduction.detectors.study import FILE


def with_detectors(claims: Sequence[Verdict], folder: Path) -> list[Verdict]:
    """The verdicts, that of C21 saying what it comes to for each detector and preset in either arena.

    Parameters
    ----------
    claims
        The paper's claims.
    folder
        A reproduction's; without ``detectors.json`` in it the verdicts are as given.
    """
    said = summary(folder)
    return [
        replace(claim, tried=" ".join(filter(None, (claim.tried, said)))) if said and claim.id == CLAIM else claim
        for claim in claims
    ]


def summary(folder: Path) -> str:
    """Return in how many replicates C21 held, for every detector and preset; empty without ``detectors.json``."""
    path = folder / FILE
    if not path.is_file():
        return ""
    table = json.loads(path.read_text(encoding="utf-8"))
    parts = []
    for arena in dict.fromkeys(row["arena"] for row in table["rows"]):
        rows = [row for row in table["rows"] if row["arena"] == arena]
        counts = ", ".join(f"{row['label']} {row['held']}" for row in rows)
        parts.append(f"in the {arena} arena, of {table['replicates']} replicates: {counts}")
    return f"Held, by detector and preset, {'; '.join(parts)} (the chapter on detectors says why)."
