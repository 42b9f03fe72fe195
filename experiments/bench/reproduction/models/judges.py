"""The judges of the models' own claims: each check of ``model_claims.toml`` on the rows of clips."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging.paper import SIGNED, Rows
from experiments.bench.judging.of_models import ModelClaim
from experiments.bench.judging.verdict import Check, Outcome, decide
from experiments.bench.leaderboard.scores import answer
from experiments.bench.reproduction.models.clips import names

Row = Mapping[str, Any]
REST = 0.5
"""Of a looming detector's potential."""
TOP = 5
"""Numbers that are told of a group of clips."""


def value(row: Row, measure: str) -> float:
    """The number of a clip that a claim is about: see the head of ``model_claims.toml``."""
    if measure == "spikes":
        return float(row["spikes"])
    if measure == "peak":
        return float(row["peak_looming"]) - REST
    return max(sign * float(row[column]) for column, sign in SIGNED.values())


def clip_claim(claim: ModelClaim, label: str, than: str = "") -> ClipClaim:
    """The claim with its judge, about the model shown as ``label`` and, where it compares two, ``than``."""
    compared = {than} if than else set()
    return ClipClaim(
        id=claim.id, says=claim.says, source=claim.source, models=frozenset({label, *compared}),
        conditions={"clip": names(claim.groups)}, of_potentials=claim.measure != "spikes",
        judge=partial(_JUDGES[claim.check], claim, label, than),
    )  # fmt: skip


def _of(rows: Rows, label: str, groups: Iterable[str]) -> list[Row]:
    """A model's rows of the clips of some groups."""
    wanted = names(groups)
    return [row for row in rows if row["model"] == label and row["clip"] in wanted]


def _each(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """The measure is at least the bound in every clip."""
    own = _of(rows, label, claim.clips)
    checks = [
        Check(f"{_said(row, claim)} (needs at least {claim.bound:g})", value(row, claim.measure) - claim.bound, False)
        for row in own
    ]
    return _outcome(claim, own, checks)


def _none(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """The measure is at most the bound in every clip, and the model is no silent one."""
    own, beside = _of(rows, label, claim.clips), _of(rows, label, claim.beside)
    checks = [
        Check(f"{_said(row, claim)} (needs at most {claim.bound:g})", claim.bound - value(row, claim.measure), False)
        for row in own
    ]
    return _unless_silent(_outcome(claim, own, checks), beside, "spikes")


def _ratio(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """The least of the clips is at least the bound times the greatest of the others."""
    own, others = _of(rows, label, claim.clips), _of(rows, label, claim.against)
    least, most = _end(own, claim, min), _end(others, claim, max)
    needed = claim.bound * value(most, claim.measure)
    said = f"{_said(least, claim)} (needs at least {claim.bound:g} times that of {_said(most, claim)})"
    return _outcome(claim, [*own, *others], [Check(said, value(least, claim.measure) - needed, False)])


def _share(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """The greatest of the clips is at most the bound times the least of the others."""
    own, others = _of(rows, label, claim.clips), _of(rows, label, claim.against)
    most, least = _end(own, claim, max), _end(others, claim, min)
    allowed = claim.bound * value(least, claim.measure)
    said = f"{_said(most, claim)} (needs at most {claim.bound:g} times that of {_said(least, claim)})"
    found = _outcome(claim, [*own, *others], [Check(said, allowed - value(most, claim.measure), False)])
    return _unless_silent(found, others, claim.measure)


def _more(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """Summed over the clips, another model answers at least the bound times as much."""
    own, others = _of(rows, label, claim.clips), _of(rows, than, claim.clips)
    mine, theirs = (sum(value(row, claim.measure) for row in each) for each in (own, others))
    said = f"{than} {theirs:.3g} in all, {label} {mine:.3g} (needs at least {claim.bound:g} times as much)"
    return _outcome(claim, [*own, *others], [Check(said, theirs - claim.bound * mine, not theirs)])


def _way(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """The strongest potential has the system and the sign of the motion in a share of the clips."""
    own = _of(rows, label, claim.clips)
    right = sum(answer(row) == row["motion"] for row in own)
    said = f"{right} of {len(own)} clips answered by the right system and sign (needs {claim.bound:.0%})"
    return _outcome(claim, own, [Check(said, right / len(own) - claim.bound, False)])


def _untested(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    return Outcome("untested", claim.why)


_JUDGES: Mapping[str, Callable[[ModelClaim, str, str, Rows, float], Outcome]] = {
    "each": _each, "none": _none, "ratio": _ratio, "share": _share, "more": _more, "way": _way, "untested": _untested,
}  # fmt: skip


def _unless_silent(found: Outcome, beside: list[Row], measure: str) -> Outcome:
    """The outcome, or ``vacuous`` where the claim is kept by a model that answers none of the clips beside it."""
    if found.verdict != "holds" or any(value(row, measure) > 0.0 for row in beside):
        return found
    why = f"silent in all {len(beside)} clips that it should answer"
    return replace(found, verdict="vacuous", measured=f"{why}; measured: {found.measured}", decided=why)


def _end(rows: list[Row], claim: ModelClaim, end: Callable[..., Row]) -> Row:
    return end(rows, key=lambda row: value(row, claim.measure))


def _said(row: Row, claim: ModelClaim) -> str:
    unit = {"spikes": "spikes", "peak": "above rest", "way": "of |HS|, |VS|"}[claim.measure]
    return f"{row['clip']}: {value(row, claim.measure):.3g} {unit}"


def _outcome(claim: ModelClaim, rows: list[Row], checks: list[Check]) -> Outcome:
    """Holds if every check passes; ``measured`` tells the numbers, ``effect`` in how many clips it is so."""
    holds, decided = decide(checks)
    numbers = sorted((value(row, claim.measure) for row in rows), reverse=True)
    told = ", ".join(f"{number:.3g}" for number in numbers[:TOP])
    measured = f"{claim.measure} of {len(rows)} clips from {numbers[-1]:.3g} to {numbers[0]:.3g} (the largest: {told})"
    good = f"{sum(check.passes for check in checks)} of {len(checks)} checks" if len(checks) > 1 else ""
    return Outcome("holds" if holds else "fails", measured, good, len(rows), decided, len(rows))
