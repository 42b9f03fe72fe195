"""What the row of C21 in the report says of the other detectors, where the folder has their study."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from experiments.bench.judging.verdict import Verdict
from experiments.bench.studies.stored import studies

STUDY, CLAIM = "detectors", "C21"


def with_detectors(claims: Sequence[Verdict], folder: Path) -> list[Verdict]:
    """Return the verdicts, that of C21 saying what it comes to for each detector and preset in either arena.

    Parameters
    ----------
    claims
        The paper's claims.
    folder
        A reproduction's; without the study of detectors in it the verdicts are as given.
    """
    text = summary(folder)
    return [
        replace(claim, tried=" ".join(filter(None, (claim.tried, text)))) if text and claim.id == CLAIM else claim
        for claim in claims
    ]


def summary(folder: Path) -> str:
    """Return in how many replicates C21 held, for every detector and preset; empty without their study."""
    study = studies(folder).get(STUDY)
    if study is None:
        return ""
    rows = [row for row in study["counts"] if row["claim"] == CLAIM]
    parts = []
    for arena in dict.fromkeys(row["point"]["arena"] for row in rows):
        counts = ", ".join(f"{row['model']} {row['holds']}" for row in rows if row["point"]["arena"] == arena)
        parts.append(f"in the {arena} arena, of {study['replicates']} replicates: {counts}")
    return f"Held, by detector and preset, {'; '.join(parts)} (the chapter on detectors says why)."
