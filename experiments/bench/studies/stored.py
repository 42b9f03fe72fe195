"""The studies that a folder has."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from experiments.bench.studies.counts import FORM

OTHERS = ("experiment", "claims", "readings", "design", "behaviours", "failures", "model_claims", "map")
"""Files that are no studies, and maps, whose figures show them."""


def studies(folder: Path) -> dict[str, dict[str, Any]]:
    """Return the studies in a folder, or one level below: name -> what its ``NAME.json`` holds.

    Of several of a name that in the folder itself counts, or else the first.
    """
    tables: dict[str, dict[str, Any]] = {}
    for path in (*sorted(folder.glob("*.json")), *sorted(folder.glob("*/*.json"))):
        if path.stem in tables or path.stem in OTHERS:
            continue
        table = read(path.parent, path.stem)
        if isinstance(table, dict) and table.get("form") == FORM and table.get("study") == path.stem:
            tables[path.stem] = table
    return tables


def read(folder: Path, name: str) -> Any:
    """Return what the file ``NAME.json`` in a folder holds; ``None`` where there is none."""
    path = folder / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
