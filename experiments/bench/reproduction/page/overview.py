"""The first screen: totals, a tile for each claim, why claims fail, and on how many trials all that was judged."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from experiments.bench import registry
from experiments.bench.reproduction import eyes
from experiments.bench.reproduction.page.miniature import miniature
from experiments.bench.reproduction.reproduce import Reproduction
from experiments.bench.stats.claim import title_of, words
from experiments.bench.stats.count import MEANINGS, SIGNS, Count, Kind, totals
from experiments.bench.stats.verdict import Verdict

Filter = Literal["kept", "broken", "unjudged"]
"""Choices of the page's filter: a claim holds, or held in all replicates of few; it fails in any, without a word that
it holds; no replicate of it could be judged, or too few for a word."""
NO_CAUSE = "The cause is not known: it held when the defaults were chosen."
SILENT = "The model hardly answers translations either, so that it keeps the claim by being silent."
UNKNOWN = "The DSNN's half holds; the rest is about a model whose constants are not published."


@dataclass(frozen=True, slots=True)
class Tile:
    """A claim at a glance.

    Parameters
    ----------
    id
        The claim's, which is also the anchor of its evidence.
    title
        The claim in a few words.
    count
        In how many replicates it held.
    picture
        The readings that decided it against their bound, as an SVG element; empty where there are none.
    """

    id: str
    title: str
    count: Count
    picture: str = ""

    @property
    def kind(self) -> Kind:
        """The name of the tile's style class."""
        return self.count.kind

    @property
    def filter(self) -> Filter:
        """The choice of the page's filter that it is shown under."""
        if self.kind == "unjudged":
            return "unjudged"
        return "broken" if self.count.fails and self.count.word != "holds" else "kept"

    @property
    def label(self) -> str:
        """The sign and the word; without a word the count."""
        return f"{SIGNS[self.kind]} {self.count.label}"

    @property
    def detail(self) -> str:
        """The detail beside the label: the count behind a word, or why replicates were not judged."""
        reasons = ", ".join(f"{reason} in {number}" for reason, number in self.count.unjudged.items())
        if self.count.half is not None:
            return f"unknown constants; the DSNN's half: {self.count.half.label}"
        if not self.count.judged:
            return ", ".join(self.count.unjudged)
        if not self.count.random:
            return "nothing random"
        return str(self.count) if self.count.word else reasons


@dataclass(frozen=True, slots=True)
class Reason:
    """A claim that does not hold, and the cause in one line."""

    tile: Tile
    cause: str


@dataclass(frozen=True, slots=True)
class EyeRow:
    """A claim about the robot under each eye and drive.

    Parameters
    ----------
    id, title
        The claim's.
    tiles
        One for each of `eyes.CELLS`; ``None`` where the claim was not shown.
    cause
        In one line what the robot's own eye and wheels make of it.
    """

    id: str
    title: str
    tiles: tuple[Tile | None, ...]
    cause: str


@dataclass(frozen=True, slots=True)
class Amount:
    """The amount of trials, clips and episodes that the verdicts rest on.

    Parameters
    ----------
    replicates, first, last
        Number of replicates with the robot, and the seeds of the first and the last.
    in_each, trials
        Trials with the robot in one replicate, and in all of them.
    moves
        Number of things moved, in one replicate each.
    clips
        Clips shown, those of replicates included.
    episodes
        Episodes of behaviours.
    """

    replicates: int
    first: int
    last: int
    in_each: int
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
    tiles, our_tiles
        Of the paper's claims, and of our own.
    reasons
        Of the claims of both kinds that do not hold in every replicate: those that fail first.
    unjudged
        The ids of the claims whose trials or clips were not shown.
    amount
        On how much this rests.
    eyes
        The claims about the robot under each eye and drive.
    legend
        The kinds of tiles that this page has, each with its sign and what it means.
    filters
        Choice of the filter -> how many tiles it shows; those alone that show any.
    """

    totals: list[str]
    tiles: list[Tile]
    our_tiles: list[Tile]
    reasons: list[Reason]
    unjudged: list[str]
    amount: Amount
    eyes: list[EyeRow]
    legend: list[tuple[Kind, str, str]]
    filters: dict[Filter, int]


def tile(claim: Verdict) -> Tile:
    """Return the tile of a claim."""
    return Tile(claim.id, title_of(claim), claim.count, miniature(claim.decisions))


def overview(result: Reproduction) -> Overview:
    """Return the first screen of a reproduction."""
    tiles, own_tiles = [tile(claim) for claim in result.claims], [tile(claim) for claim in result.own_claims]
    kinds = {shown_tile.kind for shown_tile in (*tiles, *own_tiles)}
    return Overview(
        totals([(claim.id, claim.count) for claim in result.claims]),
        tiles,
        own_tiles,
        [
            Reason(claim_tile, cause)
            for claim_tile in _worst_first([*tiles, *own_tiles])
            if (cause := cause_of(claim_tile))
        ],
        [
            claim_tile.id
            for claim_tile in (*tiles, *own_tiles)
            if set(claim_tile.count.unjudged) == {"not shown"} and not claim_tile.count.judged
        ],
        _amount(result),
        _eyes(result),
        [(kind, SIGNS[kind], meaning) for kind, meaning in MEANINGS.items() if kind in kinds],
        dict(Counter(shown_tile.filter for shown_tile in (*tiles, *own_tiles))),
    )


def cause_of(of: Tile) -> str:
    """Return in one line why a claim does not hold everywhere; empty where it does, or where nothing judges it.

    The causes that claims declare are of those that fail, or hang on another model's constants.
    """
    count = of.count
    if count.word == "holds" or (not count.fails and set(count.unjudged) <= {"not shown"}):
        return ""
    if count.half is not None and not count.fails:
        return UNKNOWN
    return SILENT if not count.fails else words(of.id).cause or NO_CAUSE


def _worst_first(tiles: Sequence[Tile]) -> list[Tile]:
    order: tuple[Kind, ...] = ("fails", "sometimes", "counted", "unjudged")
    return [claim_tile for kind in order for claim_tile in tiles if claim_tile.kind == kind]


def _eyes(result: Reproduction) -> list[EyeRow]:
    under, rows = eyes.by_eye(result.folder), []
    for claim in result.claims:
        if claim.id not in registry.answering():
            continue
        title, counts = tile(claim).title, eyes.side_by_side(claim.id, claim.count, under)
        tiles = tuple(None if count is None else Tile(claim.id, title, count) for count in counts)
        rows.append(EyeRow(claim.id, title, tiles, words(claim.id).eye))
    return rows


def _amount(result: Reproduction) -> Amount:
    paper = registry.paper_experiments()
    in_each = sum(len(plan.specs()) for plan, _ in result.runs if plan.experiment.name in paper)
    many = result.scale.replicates
    return Amount(
        replicates=many,
        first=result.seed,
        last=result.seed + many - 1,
        in_each=in_each,
        trials=in_each * many,
        moves=len(result.sensitivity.plan.judged) - 1 if result.sensitivity else 0,
        clips=sum(len(report.plan.trials) for report in result.offline),
        episodes=sum(len(standing.rows) for played in result.behaviours for standing in played.standings),
    )
