"""What the row of C21 in the report says of the other detectors, where the folder has their table."""

from __future__ import annotations

import json
from pathlib import Path

from experiments.bench.reproduction.detectors.study import FILE


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
