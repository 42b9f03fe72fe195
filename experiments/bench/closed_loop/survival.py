"""The survival of behaviours that escape: episodes without a collision, collisions a metre, and how they compare.

Every behaviour plays at the same seeds, so in the same worlds. What they share is told by exact intervals: of shares
Clopper and Pearson's, of rates Garwood's, of ratios of rates the conditional one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.bench.closed_loop.power import shares_needed
from experiments.bench.closed_loop.scores import rate, rate_ratio
from experiments.bench.stats.scores import Score, Standing
from experiments.bench.stats.tests import proportion_interval
from experiments.bench.store.files import Files
from experiments.bench.store.rows import known

PUBLISHED = {"lplc2": 0.961, "si-lgmd1": 0.937}
"""Model -> the share of encounters that it escaped on the robot, by the paper of SI-LGMD1."""


@dataclass(frozen=True, slots=True)
class Survival:
    """Survival of one behaviour.

    Attributes
    ----------
    name
        The behaviour.
    survived
        The share of episodes without a collision.
    per_metre
        Collisions a metre.
    ratio
        How many times more often a metre it collides than the reference; ``None`` of the reference itself.
    """

    name: str
    survived: Score
    per_metre: Score
    ratio: Score | None

    def row(self) -> dict[str, Any]:
        """Return a row of ``survival.csv``."""
        row: dict[str, Any] = {"behaviour": self.name, "episodes": self.survived.n}
        for name, score in (("survived", self.survived), ("collisions_m", self.per_metre), ("ratio", self.ratio)):
            ends = (math.nan,) * 3 if score is None else (score.value, score.low, score.high)
            row |= {f"{name}{end}": known(value) for end, value in zip(("", "_low", "_high"), ends, strict=True)}
        return row


def survival(standings: Sequence[Standing], reference: str) -> list[Survival]:
    """Return every behaviour's survival, least collisions a metre first; compared with ``reference``, if it played.

    A behaviour that the rows of ``standings`` have no episode of is not in them.
    """
    rows: Mapping[str, Any] = {standing.name: standing.rows for standing in standings}
    survivals = []
    for name, behaviour_rows in rows.items():
        unharmed = sum(not row["touched"] for row in behaviour_rows)
        share = Score(
            unharmed / len(behaviour_rows), *proportion_interval(unharmed, len(behaviour_rows)), len(behaviour_rows)
        )
        compared = rate_ratio(behaviour_rows, rows[reference]) if reference in rows and name != reference else None
        survivals.append(Survival(name, share, rate(behaviour_rows, "driven_m"), compared))
    return sorted(survivals, key=lambda entry: (_sortable(entry.per_metre.value), entry.name))


def write(folder: Path, survivals: Sequence[Survival]) -> Path:
    """Write ``survival.csv`` into a run's folder; return its path."""
    Files(folder).write_rows("survival.csv", [survival_of_one.row() for survival_of_one in survivals])
    return folder / "survival.csv"


def _sortable(value: float) -> float:
    return math.inf if math.isnan(value) else value


def best_against(survivals: Sequence[Survival], group: Sequence[str], reference: str) -> str:
    """Claim B2 asked of the best reflex of a group, in words; empty where it, or the ``reference``, did not play.

    The best is chosen by the episodes that judge it. That flatters it, and works against the claim.
    """
    best = next((candidate for candidate in survivals if candidate.name in group), None)
    if best is None or best.ratio is None:
        return ""
    if math.isnan(best.ratio.value):
        verdict = "neither collided, so nothing can be told"
    else:
        held = "so too" if best.ratio.low > 1.0 else "not shown"
        verdict = f"{best.ratio} times as often a metre; {held} (needs a lower end above 1)"
    return f"B2 asked of the best of them: {best.name} against {reference}: {verdict}"


def published(episodes: int) -> str:
    """Return what is to be said of the escape rates that were published, by so many ``episodes`` of each model."""
    (first, high), (second, low) = PUBLISHED.items()
    needed = shares_needed(high, low)
    return (
        f"The escape rates published for {first} and {second}, {high:.1%} and {low:.1%} of encounters with one robot: "
        f"not judged. To tell them apart with a power of 80 % takes {needed:,} encounters of each; these are "
        f"{episodes} episodes among ten robots."
    )
