"""What other commands left in a reproduction's folder, or in folders inside it: maps, eyes and drives, models' claims.

``colias map --out REPORT/NAME``, ``colias reproduce --fidelity --out REPORT/NAME`` and ``colias reproduce --models all
--out REPORT/NAME`` put them there. A file that cannot be read is left out.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.bench.judging.stored import verdicts
from experiments.bench.judging.verdict import Verdict
from experiments.bench.reproduction.page.overview import Tile, tile
from experiments.bench.reproduction.page.sections import Picture, figure_of
from experiments.bench.store.places import regular

MODEL_CLAIMS = "model_claims.json"


@dataclass(frozen=True, slots=True)
class Cell:
    """In how many replicates a claim held with one eye and drive, in words."""

    claim: str
    said: str


@dataclass(frozen=True, slots=True)
class EyeTable:
    """The claims with each eye and drive.

    Parameters
    ----------
    claims
        The columns.
    rows
        Eye and drive in words, and a cell for each claim.
    """

    claims: tuple[str, ...]
    rows: tuple[tuple[str, tuple[Cell, ...]], ...]


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
    eyes
        The claims with the robot's true eye and wheels; ``None`` without.
    models
        Claims of the models' own papers.
    """

    maps: tuple[Picture, ...]
    eyes: EyeTable | None
    models: tuple[ModelClaim, ...]


def stored(folder: Path) -> Stored:
    """Return what other commands left in the folder of a reproduction."""
    maps = [
        figure_of(path, f"map-{path.parent.name}", f"Map {path.parent.name}")
        for path in sorted(folder.glob("*/map.svg"))
    ]
    eyes = next((_eyes(rows) for rows in _lists(folder, "fidelity.json") if rows), None)
    models = [_model_claim(verdict) for verdict in _model_verdicts(folder)]
    return Stored(tuple(maps), eyes, tuple(models))


def read(folder: Path, name: str) -> Any:
    """Return what the file ``NAME.json`` in a folder holds; ``None`` where there is none that can be read.

    Chapters of other studies are given their data by this: see `experiments.bench.reproduction.chapters`.
    """
    try:
        return json.loads(regular(folder / f"{name}.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def _model_verdicts(folder: Path) -> Iterator[Verdict]:
    """The verdicts of every ``model_claims.json``, in the folder itself and one level below."""
    for path in (folder / MODEL_CLAIMS, *sorted(folder.glob(f"*/{MODEL_CLAIMS}"))):
        with suppress(ValueError):
            yield from verdicts(read(path.parent, path.stem))


def _lists(folder: Path, name: str) -> Iterator[list[dict[str, Any]]]:
    """The rows of every file of that name, in the folder itself and one level below."""
    for path in (folder / name, *sorted(folder.glob(f"*/{name}"))):
        rows = read(path.parent, path.stem)
        if isinstance(rows, list):
            yield rows


def _eyes(rows: list[dict[str, Any]]) -> EyeTable:
    claims = tuple(dict.fromkeys(row["claim"] for row in rows))
    cells = {(f"{row['eye']} eye, {row['drive']}", row["claim"]): row for row in rows}
    places = tuple(dict.fromkeys(place for place, _ in cells))
    return EyeTable(
        claims, tuple((place, tuple(_held(claim, cells[place, claim]) for claim in claims)) for place in places)
    )


def _held(claim: str, row: dict[str, Any]) -> Cell:
    vacuous = f", silent model in {row['vacuous']}" if row["vacuous"] else ""
    return Cell(claim, f"{row['held']} of {row['replicates']}{vacuous}")


def _model_claim(verdict: Verdict) -> ModelClaim:
    return ModelClaim(tile(verdict), verdict.model, verdict.source, verdict.says, verdict.outcome.deciding)
