"""What other commands left in a reproduction's folder, or in folders inside it: studies, maps, models' claims.

``colias study NAME --out REPORT/NAME`` and ``colias map --out REPORT/NAME`` put them there. A file that cannot be read
is left out.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.bench.reproduction.page.overview import Tile, sign
from experiments.bench.reproduction.page.sections import Picture, figure_of
from experiments.bench.studies.stored import read


@dataclass(frozen=True, slots=True)
class ModelClaim:
    """A claim of a model's own paper: its tile, the model, the paper, the claim's words, and what was measured."""

    tile: Tile
    model: str
    source: str
    says: str
    said: str


@dataclass(frozen=True, slots=True)
class Stored:
    """What was found.

    Parameters
    ----------
    maps
        Figures of maps.
    models
        Claims of the models' own papers.
    """

    maps: tuple[Picture, ...]
    models: tuple[ModelClaim, ...]


def stored(folder: Path) -> Stored:
    """Return the maps and the models' claims that other commands left in the folder of a reproduction."""
    maps = [
        figure_of(path, f"map-{path.parent.name}", f"Map {path.parent.name}")
        for path in sorted(folder.glob("*/map.svg"))
    ]
    models = [_model_claim(row) for rows in _lists(folder, "model_claims.json") for row in rows]
    return Stored(tuple(maps), tuple(models))


def _lists(folder: Path, name: str) -> Iterator[list[dict[str, Any]]]:
    """The rows of every file of that name, in the folder itself and one level below."""
    for path in (folder / name, *sorted(folder.glob(f"*/{name}"))):
        rows = read(path.parent, path.stem)
        if isinstance(rows, list):
            yield rows


def _model_claim(row: dict[str, Any]) -> ModelClaim:
    word = row.get("overall") or row["verdict"]
    several = row.get("replicates") or 0
    count = f"{row['replicates_held']} of {several}" if several > 1 else ""
    tile = Tile(row["id"], word, sign(word), row["says"], count)
    return ModelClaim(tile, row["model"], row["source"], row["says"], row["decided"] or row["measured"])
