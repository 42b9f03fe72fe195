"""The first screen: totals, a tile for each claim, why claims fail, and on how many trials all that was judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from experiments.bench.judging.claims import words
from experiments.bench.judging.overall import MEANINGS, SIGNS, Overall, totals
from experiments.bench.judging.verdict import Verdict
from experiments.bench.reproduction import robustness
from experiments.bench.reproduction.reproduce import Reproduction

NO_CAUSE = "The cause is not known: it held when the defaults were chosen."
SILENT = "The model answers no translation either, so that it keeps the claim by being silent."


@dataclass(frozen=True, slots=True)
class Tile:
    """A claim at a glance.

    Parameters
    ----------
    id
        The claim's, which is also the anchor of its evidence.
    word
        What it came to: `Verdict.word`. Also the name of its style class.
    sign
        The sign before the word.
    title
        The claim in a few words.
    count
        In how many replicates it held, such as ``17 of 20``; empty where that was not counted.
    """

    id: str
    word: str
    sign: str
    title: str
    count: str


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a claim does not hold, in one line."""

    tile: Tile
    cause: str


@dataclass(frozen=True, slots=True)
class Amount:
    """On how much the verdicts rest.

    Parameters
    ----------
    replicates, first, last
        How many there are with the robot, and the seeds of the first and the last.
    each, trials
        Trials with the robot in one replicate, and in all of them.
    moves
        How many things were moved, in one replicate each.
    clips
        Clips shown, replicates of them among these.
    episodes
        Episodes of behaviours.
    """

    replicates: int
    first: int
    last: int
    each: int
    trials: int
    moves: int
    clips: int
    episodes: int


@dataclass(frozen=True, slots=True)
class Overview:
    """The first screen.

    Parameters
    ----------
    totals
        What the claims came to, in phrases: those that hold come first.
    tiles, own
        Of the paper's claims, and of our own.
    reasons
        Of the claims of both kinds that were judged and do not hold: those that fail first.
    unjudged
        The ids of the claims that nothing here judges.
    amount
        On how much this rests.
    legend
        The words that tiles of this page have, each with its sign and what it means.
    """

    totals: list[str]
    tiles: list[Tile]
    own: list[Tile]
    reasons: list[Reason]
    unjudged: list[str]
    amount: Amount
    legend: list[tuple[Overall, str, str]]


def tile(claim: Verdict) -> Tile:
    """Return the tile of a claim."""
    return Tile(claim.id, claim.word, sign(claim.word), words(claim.id).title or claim.says, _count(claim))


def sign(word: str) -> str:
    """Return the sign that stands before a verdict's word."""
    return {str(each): own for each, own in SIGNS.items()}[word]


def overview(result: Reproduction) -> Overview:
    """Return the first screen of a reproduction."""
    tiles, own = [tile(claim) for claim in result.claims], [tile(claim) for claim in result.own_claims]
    words = {each.word for each in (*tiles, *own)}
    return Overview(
        totals([(claim.id, claim.word) for claim in result.claims]),
        tiles,
        own,
        [Reason(each, cause_of(each)) for each in _worst_first([*tiles, *own])],
        [each.id for each in (*tiles, *own) if each.word == "untested"],
        _amount(result),
        [(word, SIGNS[word], meaning) for word, meaning in MEANINGS.items() if word in words],
    )


def cause_of(own: Tile) -> str:
    """Return in one line why a claim does not hold everywhere; empty where it holds, or where nothing judges it.

    The causes that claims declare are of those that fail, or hang on another model's constants.
    """
    if own.word in ("holds", "untested"):
        return ""
    return SILENT if own.word == "vacuous" else words(own.id).cause or NO_CAUSE


def _worst_first(tiles: Sequence[Tile]) -> list[Tile]:
    order = ("fails", "fragile", "mixed", "vacuous", "untestable")
    return [each for word in order for each in tiles if each.word == word]


def _count(claim: Verdict) -> str:
    if claim.replicates is None or claim.standing == "unjudged":
        return ""
    if claim.standing == "deterministic":
        return "nothing random"
    return f"{claim.replicates_held} of {claim.replicates}{' so far' if claim.standing == 'so far' else ''}"


def _amount(result: Reproduction) -> Amount:
    paper = robustness.paper()
    each = sum(len(plan.specs()) for plan, _ in result.runs if plan.experiment.name in paper)
    many = result.scale.replicates
    return Amount(
        replicates=many,
        first=result.seed,
        last=result.seed + many - 1,
        each=each,
        trials=each * many,
        moves=len(result.sensitivity.plan.judged) - 1 if result.sensitivity else 0,
        clips=sum(len(report.plan.showings) for report in result.offline),
        episodes=sum(len(standing.rows) for played in result.behaviours for standing in played.standings),
    )
