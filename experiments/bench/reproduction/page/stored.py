"""Maps and models' claims that other commands left in a reproduction's folder, or in folders inside it.

``colias study model-claims --out REPORT/NAME`` and ``colias map --out REPORT/NAME`` put them there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from experiments.bench.reproduction.page.overview import Tile, tile
from experiments.bench.reproduction.page.sections import Picture, figure_of
from experiments.bench.stats.stored import verdicts
from experiments.bench.stats.verdict import Verdict
from experiments.bench.studies.stored import read

MODEL_CLAIMS = "model_claims.json"


@dataclass(frozen=True, slots=True)
class ModelClaim:
    """A claim of a model's own paper: its tile, the model, the paper, the claim's words, and what was measured."""

    tile: Tile
    model: str
    source: str
    says: str
    decided: str


@dataclass(frozen=True, slots=True)
class Stored:
    """The maps and the models' claims found in the folder of a reproduction.

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
    models = [_model_claim(verdict) for verdict in _model_verdicts(folder)]
    return Stored(tuple(maps), tuple(models))


def _model_verdicts(folder: Path) -> Iterator[Verdict]:
    """The verdicts of every ``model_claims.json``, in the folder itself and one level below."""
    for path in (folder / MODEL_CLAIMS, *sorted(folder.glob(f"*/{MODEL_CLAIMS}"))):
        if path.is_file():
            yield from verdicts(read(path.parent, path.stem))


def _model_claim(verdict: Verdict) -> ModelClaim:
    return ModelClaim(tile(verdict), verdict.model, verdict.source, verdict.says, verdict.outcome.deciding)
