"""What the row of C21 in the report says of the other detectors, where the folder has their study."""

from __future__ import annotations

from pathlib import Path

from experiments.bench.studies.stored import studies

STUDY, CLAIM = "detectors", "C21"


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
