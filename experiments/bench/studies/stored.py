"""The studies that a folder has."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from experiments.bench.store.places import regular
from experiments.bench.studies.counts import FORM

OTHERS = ("experiment", "claims", "readings", "design", "behaviours", "failures", "model_claims", "map")
"""Files that are no studies, and maps, whose figures show them."""


def studies(folder: Path) -> dict[str, dict[str, Any]]:
    """Return the studies in a folder, or one level below: name -> what its ``NAME.json`` holds.

    Of several of a name that in the folder itself counts, or else the first. A file that cannot be read is left out.
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
    """Return what the file ``NAME.json`` in a folder holds; ``None`` where there is none that can be read."""
    try:
        return json.loads(regular(folder / f"{name}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
