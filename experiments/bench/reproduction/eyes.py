"""The claims about the robot under each eye and drive of the study `fidelity`, side by side.

The headline of a reproduction is that of the default eye, which no robot has. Beside it stand the counts of
the same claims under the model of the robot's own eye, and with its wheels in open loop, where that study was run.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

from experiments.bench.stats.claim import claim_ids
from experiments.bench.stats.count import Count
from experiments.bench.studies.counts import count_of
from experiments.bench.studies.stored import studies
from experiments.studies.fidelity import EYE, STUDY, WHEELS

Apparatus = tuple[str, str]
"""An eye and a drive, as the study's axes name them."""
CELLS: Mapping[Apparatus, str] = {
    (eye.label, wheels.label): f"{eye.label} eye, {wheels.label}" for eye, wheels in product(EYE.levels, WHEELS.levels)
}
"""Every eye and drive, with a heading."""
FIRST: Apparatus = next(iter(CELLS))
"""The eye and the drive of the reproduction itself."""
SHOWN = f"colias study {STUDY.name}"
"""The command that shows the others."""
NOT_VALIDATED = "None of these eyes was validated against a robot."


def by_eye(folder: Path) -> dict[str, dict[Apparatus, Count]]:
    """Return claim -> what it came to under each eye and drive, in the claims' order; empty without their study.

    Parameters
    ----------
    folder
        Of a reproduction, which has the study in it.
    """
    study: Mapping[str, Any] = studies(folder).get(STUDY.name, {})
    counts: dict[str, dict[Apparatus, Count]] = {}
    for row in study.get("counts", ()):
        cell = row["point"].get(EYE.name), row["point"].get(WHEELS.name)
        if cell in CELLS:
            counts.setdefault(row["claim"], {})[cell] = count_of(row)
    return {claim: counts[claim] for claim in claim_ids() if claim in counts}


def side_by_side(claim: str, count: Count, under: Mapping[str, Mapping[Apparatus, Count]]) -> tuple[Count | None, ...]:
    """Return what a claim came to in each of `CELLS`; ``None`` where that was not shown.

    Parameters
    ----------
    claim
        Its id.
    count
        What it came to in the reproduction itself. It stands first: a claim has one word there.
    under
        From `by_eye`. The study has the seeds of the reproduction's first replicates in all cells.
    """
    cells = {**under.get(claim, {}), FIRST: count}
    return tuple(cells.get(cell) for cell in CELLS)
