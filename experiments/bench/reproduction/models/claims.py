"""Claims of models' own papers, on clips: what they ask, their judges, and where they are declared.

Words and bounds were written, and committed, before the code of these models. A bound that a model misses is reported
as a failure; it is never edited to fit.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Literal, get_args

from dsnn import MODELS
from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import SIGNED, Row, Rows
from experiments.bench.leaderboard.scores import answer
from experiments.bench.reproduction.models.clips import names
from experiments.bench.stats.checks import Check, Needs
from experiments.bench.stats.verdict import Outcome

PACKAGE = "experiments.claims.of_models"
Test = Literal["each", "none", "ratio", "share", "more", "way", "reversed", "not shown"]
"""What is asked of the model's answers to the clips.

- ``each``: the measure is at least the bound in every clip.
- ``none``: it is at most the bound in every clip, and some clip ``beside`` is answered by a spike.
- ``ratio``: the least measure is at least the bound times the greatest in ``against``.
- ``share``: the greatest is at most the bound times the least in ``against``.
- ``more``: summed over the clips, the measure of the model ``than`` is at least the bound times that of this model.
- ``way``: the strongest potential has the system and the sign of the motion, in at least that share of the clips.
- ``reversed``: it has the system of the motion and the other sign, in at least that share of the clips.
- ``not shown``: it is not judged; ``why`` says why.
"""
Measure = Literal["spikes", "peak", "way"]
"""A clip's number of spikes; how far the looming potential rises above rest; the largest |HS| or |VS|."""
REST = 0.5
"""Of a looming detector's potential."""
OPPOSITE = {"rightward": "leftward", "leftward": "rightward", "downward": "upward", "upward": "downward"}
TOP = 5
"""Numbers that are told of a group of clips."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelClaim:
    """A statement of a model's own paper that clips can test.

    Parameters
    ----------
    id, says, source
        Its name, its words, and the paper.
    model
        The model that it is about: a registered name, with settings where the claim names them.
    check, measure, bound
        What is asked of which number: see `Test` and `Measure`.
    clips, against, beside
        Groups of clips: those judged, those they are compared with, and those that a silent model does not answer.
    than
        Of the check ``more``: the model that it is compared with.
    why
        Of the check ``not shown``: why.

    Raises
    ------
    ValueError
        What it needs for its check is missing.
    """

    id: str
    says: str
    source: str
    model: str
    check: Test
    bound: float = 0.0
    clips: tuple[str, ...] = ()
    measure: Measure = "spikes"
    against: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()
    than: str = ""
    why: str = ""

    def __post_init__(self) -> None:
        for name, legal in (("check", get_args(Test)), ("measure", get_args(Measure))):
            if getattr(self, name) not in legal:
                raise ValueError(f"claim {self.id}: {name}={getattr(self, name)!r}: legal is {', '.join(legal)}")
        needed = {"ratio": "against", "share": "against", "more": "than", "not shown": "why", "none": "beside"}
        missing = needed.get(self.check, "clips")
        if not getattr(self, missing):
            raise ValueError(f"claim {self.id}: {missing} is missing: the check '{self.check}' needs it")

    @property
    def groups(self) -> tuple[str, ...]:
        """All groups of clips that it needs."""
        return tuple(dict.fromkeys((*self.clips, *self.against, *self.beside)))


def value(row: Row, measure: str) -> float:
    """Return the number of a clip that a claim is about: see `Measure`."""
    if measure == "spikes":
        return float(row["spikes"])
    if measure == "peak":
        return float(row["peak_looming"]) - REST
    return max(sign * float(row[column]) for column, sign in SIGNED.values())


def clip_claim(claim: ModelClaim, label: str, than: str = "") -> ClipClaim:
    """Return the claim with its judge, about the model shown as ``label`` and, where it compares two, ``than``."""
    compared = {than} if than else set()
    return ClipClaim(
        id=claim.id, says=claim.says, source=claim.source, models=frozenset({label, *compared}),
        conditions={"clip": names(claim.groups)}, of_potentials=claim.measure != "spikes",
        judge=partial(_JUDGES[claim.check], claim, label, than),
    )  # fmt: skip


def _of(rows: Rows, label: str, groups: Iterable[str]) -> list[Row]:
    """Return a model's rows of the clips of some groups."""
    wanted = names(groups)
    return [row for row in rows if row["model"] == label and row["clip"] in wanted]


def _each(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """Judge that the measure is at least the bound in every clip."""
    clips = _of(rows, label, claim.clips)
    checks = [Check(_text(row, claim), value(row, claim.measure), claim.bound, "at least") for row in clips]
    return _outcome(claim, clips, checks)


def _none(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """Judge that the measure is at most the bound in every clip, and that the model is no silent one."""
    clips, beside = _of(rows, label, claim.clips), _of(rows, label, claim.beside)
    checks = [Check(_text(row, claim), value(row, claim.measure), claim.bound, "at most") for row in clips]
    return _unless_silent(_outcome(claim, clips, checks), beside, "spikes")


def _ratio(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """Judge that the least of the clips is at least the bound times the greatest of the others."""
    clips, others = _of(rows, label, claim.clips), _of(rows, label, claim.against)
    least, most = _end(clips, claim, min), _end(others, claim, max)
    needed = claim.bound * value(most, claim.measure)
    asks = f"at least {claim.bound:g} times that of {_text(most, claim)}"
    check = Check(_text(least, claim), value(least, claim.measure), needed, "at least", asks=asks)
    return _outcome(claim, [*clips, *others], [check])


def _share(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """Judge that the greatest of the clips is at most the bound times the least of the others."""
    clips, others = _of(rows, label, claim.clips), _of(rows, label, claim.against)
    most, least = _end(clips, claim, max), _end(others, claim, min)
    allowed = claim.bound * value(least, claim.measure)
    asks = f"at most {claim.bound:g} times that of {_text(least, claim)}"
    check = Check(_text(most, claim), value(most, claim.measure), allowed, "at most", asks=asks)
    return _unless_silent(_outcome(claim, [*clips, *others], [check]), others, claim.measure)


def _more(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """Judge that, summed over the clips, another model answers at least the bound times as much."""
    clips, others = _of(rows, label, claim.clips), _of(rows, than, claim.clips)
    mine, theirs = (sum(value(row, claim.measure) for row in of_model) for of_model in (clips, others))
    needs: Needs = "at least" if theirs else "above"  # of two silent models neither answers more
    text, asks = f"{than} {theirs:.3g} in all, {label} {mine:.3g}", f"at least {claim.bound:g} times as much"
    return _outcome(claim, [*clips, *others], [Check(text, theirs, claim.bound * mine, needs, asks=asks)])


def _way(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """Judge that the strongest potential has the system and the sign of the motion in a share of the clips."""
    right = {way: way for way in SIGNED}
    return _answered(claim, _of(rows, label, claim.clips), right, "the right system and sign")


def _reversed(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    """Judge that the strongest potential has the system of the motion and the other sign in a share of the clips."""
    return _answered(claim, _of(rows, label, claim.clips), OPPOSITE, "the right system and the other sign")


def _answered(claim: ModelClaim, clips: list[Row], expected: Mapping[str, str], words: str) -> Outcome:
    """Judge the share of clips in which the direction answered is that ``expected`` of the motion shown."""
    hits = sum(answer(row) == expected[row["motion"]] for row in clips)
    text = f"{hits} of {len(clips)} clips answered by {words}"
    return _outcome(claim, clips, [Check(text, hits / len(clips), claim.bound, "at least", asks=f"{claim.bound:.0%}")])


def _not_shown(claim: ModelClaim, label: str, than: str, rows: Rows, threshold: float) -> Outcome:
    return Outcome.unjudged(claim.why)


_JUDGES: Mapping[str, Callable[[ModelClaim, str, str, Rows, float], Outcome]] = {
    "each": _each, "none": _none, "ratio": _ratio, "share": _share, "more": _more, "way": _way, "reversed": _reversed,
    "not shown": _not_shown,
}  # fmt: skip


def _unless_silent(outcome: Outcome, beside: list[Row], measure: str) -> Outcome:
    """Return the outcome; where a model keeps the claim that answers none of the clips beside it, it is not judged."""
    if outcome.verdict != "holds" or any(value(row, measure) > 0.0 for row in beside):
        return outcome
    return outcome.silent(f"silent in all {len(beside)} clips that it should answer")


def _end(rows: list[Row], claim: ModelClaim, end: Callable[..., Row]) -> Row:
    return end(rows, key=lambda row: value(row, claim.measure))


def _text(row: Row, claim: ModelClaim) -> str:
    unit = {"spikes": "spikes", "peak": "above rest", "way": "of |HS|, |VS|"}[claim.measure]
    return f"{row['clip']}: {value(row, claim.measure):.3g} {unit}"


def _outcome(claim: ModelClaim, rows: list[Row], checks: list[Check]) -> Outcome:
    """Return the outcome; ``measured`` tells the numbers, ``effect`` in how many clips it is so."""
    numbers = sorted((value(row, claim.measure) for row in rows), reverse=True)
    listed = ", ".join(f"{number:.3g}" for number in numbers[:TOP])
    measured = (
        f"{claim.measure} of {len(rows)} clips from {numbers[-1]:.3g} to {numbers[0]:.3g} (the largest: {listed})"
    )
    good = f"{sum(check.passes for check in checks)} of {len(checks)} checks" if len(checks) > 1 else ""
    return Outcome.of(checks, measured, good, len(rows), len(rows))


def model_claims() -> Mapping[str, tuple[ModelClaim, ...]]:
    """Return registered model -> the claims of its own paper, each in the file of its name, in the models' order."""
    folders = importlib.import_module(PACKAGE).__path__
    files = {module.name.replace("_", "-"): f"{PACKAGE}.{module.name}" for module in pkgutil.iter_modules(folders)}
    return {name: importlib.import_module(files[name]).CLAIMS for name in MODELS if name in files}
