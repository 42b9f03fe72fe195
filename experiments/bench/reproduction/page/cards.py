"""The evidence of each claim, as the report shows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from experiments.bench.clips.judging import deciding
from experiments.bench.judging.claim import Reading
from experiments.bench.judging.claims import used_to_choose
from experiments.bench.judging.paper import cited
from experiments.bench.judging.verdict import Outcome, Verdict
from experiments.bench.reproduction.mechanisms import constants
from experiments.bench.reproduction.page.overview import Tile, cause_of, tile
from experiments.bench.reproduction.readings import Chapter, Row
from experiments.bench.reproduction.reproduce import Reproduction
from experiments.bench.studies.constants import comparing


@dataclass(frozen=True, slots=True)
class Choice:
    """One choice of the constants of another model, whether the claim holds with it, and the number that decides."""

    name: str
    holds: str
    decided: str


@dataclass(frozen=True, slots=True)
class Card:
    """A claim with its evidence.

    Parameters
    ----------
    tile, claim
        The claim at a glance, and its verdict.
    source
        Where the paper says it, with the paper's own figure numbers.
    experiments
        Those that it was judged on.
    mechanism
        The experiment whose figure shows why it comes out so, and what that figure draws.
    used
        The readings that it was used to choose, without those that all claims were used to choose.
    readings
        The readings that bear on it alone, each with what it comes to under it.
    choices
        Of a claim that compares models: the other model's constants.
    cause
        In one line why it does not hold; empty where it holds.
    """

    tile: Tile
    claim: Verdict
    source: str
    experiments: tuple[str, ...]
    mechanism: tuple[str, str]
    used: tuple[str, ...]
    readings: tuple[tuple[Reading, Row], ...]
    choices: tuple[Choice, ...]
    cause: str


def cards(result: Reproduction) -> list[Card]:
    """Return a card for each of the paper's claims, in their order."""
    found = {claim: constants(claim, result.offline) for claim in comparing()}
    return [_card(claim, result.readings, found.get(claim.id, {})) for claim in result.claims]


def _card(claim: Verdict, chapters: Sequence[Chapter], found: Mapping[str, Outcome]) -> Card:
    own = tile(claim)
    place, _, drawn = claim.mechanism.partition(": ")
    return Card(
        own,
        claim,
        cited(claim.source),
        tuple(name for name in claim.experiment.split(", ") if name),
        (place, drawn),
        tuple(reading.name for reading in used_to_choose(claim.id) if not reading.of_all),
        tuple((chapter.reading, row) for chapter in chapters for row in chapter.rows if row.claim == claim.id),
        tuple(
            Choice(name, "holds" if each.verdict == "holds" else "does not hold", deciding(each))
            for name, each in found.items()
        ),
        cause_of(own),
    )
