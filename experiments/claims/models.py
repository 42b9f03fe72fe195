"""The claims of other models' own papers, on clips. Their words are in ``claims.toml``, below the models' names.

Words and bounds were written, and committed, before the code of these models. A bound that a model misses is reported
as a failure; it is never edited to fit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Any, Literal

from dsnn import MODELS
from experiments.bench.sources.judge import SIGNED, Row
from experiments.bench.stats.checks import Check, Needs
from experiments.bench.stats.claim import Claim, texts
from experiments.bench.stats.verdict import Outcome
from experiments.claims.clips import answer, rows_of
from experiments.claims.model_clips import names

if TYPE_CHECKING:
    import polars as pl

Test = Literal["each", "none", "ratio", "share", "more", "way", "reversed", "not shown"]
"""What is asked of the model's responses to the clips.

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
"""Potential of a looming detector at rest."""
OPPOSITE = {"rightward": "leftward", "leftward": "rightward", "downward": "upward", "upward": "downward"}


@dataclass(frozen=True, slots=True)
class ModelClaim:
    """A statement of a model's own paper that clips can test.

    Parameters
    ----------
    id
        Its name.
    model
        The model that it is about: a registered name, with settings where the claim names them.
    check, measure, bound
        What is asked of which number: see `Test` and `Measure`.
    clips, against, beside
        Groups of clips: those judged, those they are compared with, and those that a silent model does not answer.
    than
        For the check ``more``: the model that it is compared with.
    why
        For the check ``not shown``: why.
    """

    id: str
    model: str
    check: Test
    measure: Measure = "spikes"
    bound: float = 0.0
    clips: tuple[str, ...] = ()
    against: tuple[str, ...] = ()
    beside: tuple[str, ...] = ()
    than: str = ""
    why: str = ""

    @property
    def groups(self) -> tuple[str, ...]:
        """All groups of clips that it needs."""
        return tuple(dict.fromkeys((*self.clips, *self.against, *self.beside)))


LOOMING, LIGHT, RECEDING = ("dark-looming",), ("light-looming",), ("dark-receding", "light-receding")
ACROSS, GRATINGS = ("translating",), ("gratings",)

CLAIMS = (
    ModelClaim("LPLC2-1", "lplc2", "each", "spikes", 1.0, LOOMING),
    ModelClaim("LPLC2-2", "lplc2", "none", "spikes", 0.0, (*ACROSS, *GRATINGS), beside=LOOMING),
    ModelClaim("LPLC2-3", "lplc2", "none", "spikes", 0.0, RECEDING, beside=LOOMING),
    ModelClaim("LPLC2-4", "lplc2", "share", "peak", 0.5, ("off-centre",), LOOMING),
    ModelClaim("GF-1", "lplc2-gf", "each", "spikes", 1.0, LOOMING),
    ModelClaim("GF-2", "lplc2-gf", "none", "spikes", 0.0, (*ACROSS, *GRATINGS, *RECEDING), beside=LOOMING),
    ModelClaim("GF-3", "lplc2-gf:fps=100", "each", "spikes", 1.0, ("looming-100",)),
    ModelClaim("GF-4", "lplc2-gf", "not shown", why="the paper's virtual robot and its corridor are not built here"),
    ModelClaim("MLPLC2-1", "mlplc2", "each", "spikes", 1.0, (*LOOMING, *LIGHT)),
    ModelClaim("MLPLC2-2", "mlplc2", "each", "spikes", 1.0, ("off-centre",)),
    ModelClaim("MLPLC2-3", "mlplc2", "none", "spikes", 0.0, (*ACROSS, *GRATINGS), beside=LOOMING),
    ModelClaim("MLPLC2-4", "mlplc2", "none", "spikes", 0.0, RECEDING, beside=LOOMING),
    ModelClaim("SI1-1", "si-lgmd1", "each", "spikes", 4.0, (*LOOMING, *LIGHT)),
    ModelClaim("SI1-2", "si-lgmd1", "none", "spikes", 3.0, ACROSS, beside=LOOMING),
    ModelClaim("SI1-3", "si-lgmd1", "more", "peak", 2.0, ACROSS, than="si-lgmd1:beta_3=0"),
    ModelClaim(
        "SI1-4", "si-lgmd1", "not shown", why="needs over a thousand encounters a model to tell 96.1 from 93.7 %"
    ),
    ModelClaim("SI2-1", "si-lgmd2", "each", "spikes", 4.0, LOOMING),
    ModelClaim("SI2-2", "si-lgmd2", "share", "spikes", 0.5, (*LIGHT, "dark-receding"), LOOMING),
    ModelClaim("SI2-3", "si-lgmd2", "none", "spikes", 3.0, ACROSS, beside=LOOMING),
    ModelClaim("PON-1", "pon-lgmd", "ratio", "peak", 0.5, ("low-contrast",), LOOMING),
    ModelClaim("PON-2", "pon-lgmd", "ratio", "peak", 1.0, (*LOOMING, *LIGHT), (*ACROSS, *RECEDING)),
    ModelClaim("PON-3", "pon-lgmd", "ratio", "peak", 2.0, ("before-grating",), ("grating-alone",)),
    ModelClaim("EMDN-1", "emd-normalised", "way", "way", 1.0, ACROSS),
    ModelClaim("EMDN-2", "emd-normalised", "ratio", "way", 0.5, ("faint-gratings",), GRATINGS),
    ModelClaim("EMDN-3", "emd-normalised", "ratio", "way", 0.5, ("panning-scenes",), ("panning-scenes",)),
    ModelClaim(
        "EMDN-4", "emd-normalised", "not shown",
        why="the paper's panoramas and the weights of its trained network are not here",
    ),
    ModelClaim("T4T5-1", "t4t5", "way", "way", 1.0, ACROSS),
    ModelClaim("T4T5-2", "t4t5", "share", "way", 0.1, (*LOOMING, *LIGHT), ACROSS),
    ModelClaim("ARM3-1", "three-arm", "way", "way", 1.0, ACROSS),
    ModelClaim("ARM3-2", "three-arm", "share", "way", 0.1, (*LOOMING, *LIGHT), ACROSS),
    ModelClaim("ARM3-3", "three-arm", "not shown", why="a cell's answer to pairs of flashes is not in HS and VS"),
    ModelClaim("ARM3-4", "three-arm-4q", "way", "way", 1.0, ACROSS),
    ModelClaim("ARM3-5", "three-arm-4q", "reversed", "way", 1.0, ("reverse-phi",)),
)  # fmt: skip


@cache
def model_claims() -> Mapping[str, tuple[ModelClaim, ...]]:
    """Return registered model -> the claims of its own paper, in the models' order."""
    of = {name: tuple(claim for claim in CLAIMS if claim.model.partition(":")[0] == name) for name in MODELS}
    return {name: claims for name, claims in of.items() if claims}


def clip_claim(claim: ModelClaim, label: str, than: str = "") -> Claim:
    """Return the claim with its judge, about the model shown as ``label`` and, where it compares two, ``than``."""
    paper = texts()["papers"][claim.model.partition(":")[0]]
    return Claim(
        on="clips", id=claim.id, says=paper[claim.id], source=paper["source"], models=frozenset({label, than} - {""}),
        conditions={"clip": names(claim.groups)}, of_potentials=claim.measure != "spikes",
        judge=partial(judge, claim, label, than),
    )  # fmt: skip


def judge(claim: ModelClaim, label: str, than: str, clips: pl.DataFrame, threshold: float) -> Outcome:
    """Judge a claim about the model ``label`` on its clips: see `Test`."""
    value = partial(_value, measure=claim.measure)
    mine, against, beside = (_of(clips, label, groups) for groups in (claim.clips, claim.against, claim.beside))
    if claim.check in ("way", "reversed"):
        expected = OPPOSITE if claim.check == "reversed" else {way: way for way in OPPOSITE}
        hits = sum(answer(row) == expected[row["motion"]] for row in mine)
        sign = "the other sign" if expected is OPPOSITE else "sign"
        text = f"{hits} of {len(mine)} clips answered by the right system and {sign}"
        return Outcome.of([Check(text, hits / len(mine), claim.bound, "at least")])
    if claim.check in ("each", "none"):
        side: Needs = "at least" if claim.check == "each" else "at most"
        outcome = Outcome.of([Check(_text(row, claim), value(row), claim.bound, side) for row in mine])
        return _unless_silent(outcome, [row["spikes"] for row in beside]) if claim.check == "none" else outcome
    if claim.check == "more":
        theirs, ours = (sum(map(value, rows)) for rows in (_of(clips, than, claim.clips), mine))
        needs: Needs = "at least" if theirs else "above"  # of two silent models neither answers more
        return Outcome.of([Check(f"{than} {theirs:.3g} in all, {label} {ours:.3g}", theirs, claim.bound * ours, needs)])
    if claim.check == "ratio":
        row, other, needs = min(mine, key=value), max(against, key=value), "at least"
    else:
        row, other, needs = max(mine, key=value), min(against, key=value), "at most"
    asks = f"{needs} {claim.bound:g} times that of {_text(other, claim)}"
    outcome = Outcome.of([Check(_text(row, claim), value(row), claim.bound * value(other), needs, asks=asks)])
    return _unless_silent(outcome, map(value, against)) if claim.check == "share" else outcome


def _value(row: Row, measure: Measure) -> float:
    """Return the number of a clip that a claim is about: see `Measure`."""
    if measure == "spikes":
        return float(row["spikes"])
    if measure == "peak":
        return float(row["peak_looming"]) - REST
    return max(sign * float(row[column]) for column, sign in SIGNED.values())


def _of(clips: pl.DataFrame, label: str, groups: Iterable[str]) -> list[dict[str, Any]]:
    """Return a model's rows of the clips of some groups."""
    wanted = set(names(groups))
    return [row for row in rows_of(clips, label) if row["clip"] in wanted]


def _unless_silent(outcome: Outcome, responses: Iterable[float]) -> Outcome:
    """Return the outcome; where a model satisfies the claim that has none of the ``responses``, it is not judged."""
    if outcome.verdict != "holds" or any(response > 0.0 for response in responses):
        return outcome
    return outcome.silent("silent in all clips that it should answer")


def _text(row: Row, claim: ModelClaim) -> str:
    unit = {"spikes": "spikes", "peak": "above rest", "way": "of |HS|, |VS|"}[claim.measure]
    return f"{row['clip']}: {_value(row, claim.measure):.3g} {unit}"
