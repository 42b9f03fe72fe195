"""The evidence of each claim, as the report shows it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from experiments.bench.clips.judging import deciding
from experiments.bench.judging.claim import Reading
from experiments.bench.judging.claims import used_to_choose, words
from experiments.bench.judging.count import Count
from experiments.bench.judging.paper import cited
from experiments.bench.judging.verdict import Outcome, Verdict
from experiments.bench.reproduction import mechanisms
from experiments.bench.reproduction.detectors import CLAIM, summary
from experiments.bench.reproduction.page.overview import Tile, cause_of, tile
from experiments.bench.reproduction.readings import Row
from experiments.bench.reproduction.replicates import rate
from experiments.bench.reproduction.reproduce import Reproduction
from experiments.bench.studies.constants import comparing

NOTHING_TRIED = "nothing yet: it held when the defaults were chosen"
EVER_MORE = (
    "a claim about every single trial fails ever more surely the more trials there are; the rate of trials does not"
)


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
    held
        In how many replicates it held, in words; of a claim that nothing here judges, what it would take.
    interval
        The exact 95 % interval of the share of replicates in which it holds, or why there is none.
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
    assumed, choices
        Of a claim that compares models: what is assumed of the other model, and its other constants.
    cause
        In one line why it does not hold; empty where it holds.
    tried
        What was tried to make it hold, or what limits it; empty where it holds in every replicate.
    pooled
        What it comes to on the trials of all replicates together; empty of one replicate.
    rate
        Of a claim about every single trial: the share of the trials of all replicates that break it.
    """

    tile: Tile
    claim: Verdict
    held: str
    interval: str
    source: str
    experiments: tuple[str, ...]
    mechanism: tuple[str, str]
    used: tuple[str, ...]
    readings: tuple[tuple[Reading, Row], ...]
    assumed: str
    choices: tuple[Choice, ...]
    cause: str
    tried: str
    pooled: str
    rate: str


def cards(result: Reproduction) -> list[Card]:
    """Return a card for each of the paper's claims, in their order."""
    return [_card(claim, result) for claim in result.claims]


def _card(claim: Verdict, result: Reproduction) -> Card:
    glance, count = tile(claim), claim.count
    there = [plan.experiment.name for plan, _ in result.runs] + [
        report.plan.experiment.name for report in result.offline
    ]
    courses = {plan.experiment.name: report.courses for plan, report in result.runs}
    place, _, drawn = mechanisms.mechanism(claim, there, courses).partition(": ")
    choices = mechanisms.constants(claim.id, result.offline) if claim.id in comparing() else {}
    whole = result.pooled.get(claim.id)
    return Card(
        tile=glance,
        claim=claim,
        held=count.sentence(result.scale.name) if claim.experiment else claim.outcome.measured,
        interval=_interval(count),
        source=cited(claim.source),
        experiments=tuple(name for name in claim.experiment.split(", ") if name),
        mechanism=(place, drawn),
        used=tuple(reading.name for reading in used_to_choose(claim.id) if not reading.of_all),
        readings=tuple(
            (chapter.reading, row) for chapter in result.readings for row in chapter.rows if row.claim == claim.id
        ),
        assumed=mechanisms.assumed(claim.id, result.offline),
        choices=tuple(
            Choice(name, "holds" if outcome.verdict == "holds" else "does not hold", deciding(outcome))
            for name, outcome in choices.items()
        ),
        cause=cause_of(glance),
        tried=limits(claim, result.folder),
        pooled=f"{whole.verdict}: {whole.measured}" if whole and count.replicates > 1 else "",
        rate=_rate(claim.id, whole),
    )


def limits(claim: Verdict, folder: Path) -> str:
    """Return what was tried to make a claim hold, or what limits it; empty where it holds in every replicate."""
    count = claim.count
    if not claim.experiment or count.word == "holds" or count.holds == count.replicates:
        return ""
    detectors = summary(folder) if claim.id == CLAIM else ""
    return " ".join(filter(None, (words(claim.id).tried or NOTHING_TRIED, detectors)))


def _interval(count: Count) -> str:
    if count.interval is None:
        return "none: nothing in it is random" if count.judged else "none: not judged"
    low, high = count.interval
    return f"{low:.0%} to {high:.0%} of replicates (exact 95 % interval of the share in which it holds)"


def _rate(claim: str, whole: Outcome | None) -> str:
    share = rate(claim, whole) if whole else ""
    return f"{share}; {EVER_MORE}" if share else ""
