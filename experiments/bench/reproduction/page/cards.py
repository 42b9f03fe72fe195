"""The evidence of each claim, as the report shows it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.bench.reproduction.page.overview import Tile, cause_of, tile
from experiments.bench.reproduction.readings import Row
from experiments.bench.reproduction.replicates import rate
from experiments.bench.reproduction.reproduce import Reproduction
from experiments.bench.stats.claim import words
from experiments.bench.stats.clips import ASSUMED, paper_claims
from experiments.bench.stats.count import Count
from experiments.bench.stats.excitation import Course, described
from experiments.bench.stats.verdict import Outcome, Verdict
from experiments.bench.studies.constants import STUDIES, compares_with, comparing, constants_text, outcomes
from experiments.bench.studies.counts import Counts
from experiments.bench.studies.stored import studies
from experiments.claims.readings import Reading, used_to_choose

OF_DETECTORS = "C21"
"""The claim whose card has the other detectors, where the folder has their study."""
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
        The readings that bear on it alone, each with the claim's outcome under it.
    assumed, choices
        Of a claim that compares models: what is assumed of the other model, and its other constants.
    cause
        In one line why it does not hold; empty where it holds.
    tried
        What was tried to make it hold, or what limits it; empty where it holds in every replicate.
    pooled
        The outcome on the trials of all replicates together; empty of one replicate.
    rate
        Of a claim about every single trial: the share of the trials of all replicates that break it.
    implied
        Why the model's equations imply it; empty where they do not.
    half
        Of a claim that hangs on unknown constants: its half about the DSNN, in how many replicates that held.
    equal
        The outcome with the models that it compares with on equal terms, and the number that decided.
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
    implied: str
    half: str
    equal: str


def cards(result: Reproduction) -> list[Card]:
    """Return a card for each of the paper's claims, in their order."""
    return [_card(claim, result) for claim in result.claims]


def _card(claim: Verdict, result: Reproduction) -> Card:
    glance, count = tile(claim), claim.count
    there = [plan.experiment.name for plan, _ in result.runs] + [
        report.plan.experiment.name for report in result.offline
    ]
    courses = {plan.experiment.name: report.courses for plan, report in result.runs}
    choices = outcomes_by_constants(claim.id, result.read_off)
    whole = result.pooled.get(claim.id)
    return Card(
        tile=glance,
        claim=claim,
        held=count.sentence(result.scale.name) if claim.experiment else claim.outcome.measured,
        interval=_interval(count),
        source=claim.source,
        experiments=tuple(name for name in claim.experiment.split(", ") if name),
        mechanism=mechanism_of(claim, there, courses),
        used=tuple(reading.name for reading in used_to_choose(claim.id) if not reading.of_all),
        readings=tuple(
            (chapter.reading, row)
            for chapter in result.readings
            for row in chapter.rows
            if row.claim == claim.id and not chapter.reading.of_all
        ),
        assumed=assumptions_text(claim.id, choices),
        choices=tuple(
            Choice(name, "holds" if outcome.verdict == "holds" else "does not hold", outcome.deciding)
            for name, outcome in choices.items()
        ),
        cause=cause_of(glance),
        tried=limits(claim, result.folder),
        pooled=f"{whole.verdict}: {whole.measured}" if whole and count.replicates > 1 else "",
        rate=_rate(claim.id, whole),
        implied=words(claim.id).implied,
        half=half_text(claim, result.scale.name),
        equal=equal_text(claim, result.scale.name),
    )


def half_text(claim: Verdict, name: str = "replicate") -> str:
    """Say what the DSNN's half of a claim is, and in how many replicates it held; empty of a claim without halves."""
    half = claim.count.half
    return f"{words(claim.id).of_dsnn}: {half.label}; {half.sentence(name)}" if half else ""


def equal_text(claim: Verdict, name: str = "replicate") -> str:
    """Say how a claim ends with its rivals on equal terms; empty of a claim without, and where none was shown."""
    if claim.equal is None or claim.outcome.equal is None:
        return ""
    terms = ", ".join(f"{equal} for {label}" for label, equal in paper_claims()[claim.id].equal_terms.items())
    decided = f"replicate 0, {claim.outcome.equal.verdict}: {claim.outcome.equal.deciding}"
    return f"{terms}: {claim.equal.label}; {claim.equal.sentence(name)}; {decided}"


def limits(claim: Verdict, folder: Path) -> str:
    """Return what was tried to make a claim hold, or what limits it; empty where it holds in every replicate."""
    count = claim.count
    if not claim.experiment or count.word == "holds" or count.holds == count.replicates:
        return ""
    detectors = detectors_text(folder) if claim.id == OF_DETECTORS else ""
    nothing = "" if count.half is not None and not count.fails else NOTHING_TRIED
    return " ".join(filter(None, (words(claim.id).tried or nothing, detectors)))


def detectors_text(folder: Path) -> str:
    """Say in how many replicates C21 held, for every detector and preset; empty without their study."""
    study = studies(folder).get("detectors")
    if study is None:
        return ""
    rows = [row for row in study["counts"] if row["claim"] == OF_DETECTORS]
    parts = []
    for arena in dict.fromkeys(row["point"]["arena"] for row in rows):
        counts = ", ".join(f"{row['model']} {row['holds']}" for row in rows if row["point"]["arena"] == arena)
        parts.append(f"in the {arena} arena, of {study['replicates']} replicates: {counts}")
    return f"Held, by detector and preset, {'; '.join(parts)} (the chapter on detectors says why)."


def mechanism_of(
    claim: Verdict, there: Collection[str], courses: Mapping[str, Sequence[Course]]
) -> tuple[str, str]:  # fmt: skip
    """Return the experiment whose figure draws the claim's mechanism, and what it draws.

    Parameters
    ----------
    claim
        The claim's verdict. Without its mechanism's experiment its own figure is all there is.
    there
        The names of the experiments that were run.
    courses
        Experiment -> the excitation and inhibition in its conditions, where it shows these; told in numbers.
    """
    name, what = words(claim.id).mechanism
    if name in there:
        drawn = courses.get(name, ())
        numbers = f"; means in units of HS where E + I is largest: {described(drawn)}" if drawn else ""
        return name, f"{what}{numbers}"
    if not claim.experiment:
        return "none", "not judged"
    return claim.experiment, "the figure of what it was judged on; no figure of the mechanism in this run"


def outcomes_by_constants(claim: str, read_off: Mapping[str, Counts]) -> dict[str, Outcome]:
    """Return the constants of the other model -> the claim's outcome with them; empty where they were not run."""
    for name in STUDIES:
        if name in read_off and any(asked.id == claim for asked, _ in read_off[name].plan.claims):
            return outcomes(read_off[name], claim)
    return {}


def assumptions_text(claim: str, by_constants: Mapping[str, Outcome]) -> str:
    """Return what is assumed of the model that a claim compares the DSNN with, and with which constants it holds."""
    if claim not in comparing():
        return ""
    others = f"in replicate 0: {constants_text(by_constants)}" if by_constants else "other constants were not run here"
    return f"{ASSUMED[compares_with(claim)]}; {others}"


def _interval(count: Count) -> str:
    if count.interval is None:
        return "none: nothing in it is random" if count.judged else "none: not judged"
    low, high = count.interval
    return f"{low:.0%} to {high:.0%} of replicates (exact 95 % interval of the share in which it holds)"


def _rate(claim: str, whole: Outcome | None) -> str:
    share = rate(claim, whole) if whole else ""
    return f"{share}; {EVER_MORE}" if share else ""
