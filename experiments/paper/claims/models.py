"""The claims of other models' own papers, on clips. Their words are in ``claims.toml``, below the models' names.

Words and bounds were written, and committed, before the code of these models. A bound that a model misses is reported
as a failure; it is never edited to fit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any, Literal

from dsnn import MODELS
from experiments.declare.checks import Check, Needs
from experiments.declare.claim import Claim, texts
from experiments.declare.outcome import Outcome
from experiments.judge.judge import SIGNED, Row, Rows
from experiments.paper.claims.clips import answer, rows_of
from experiments.paper.claims.model_clips import names

Test = Literal["each", "none", "ratio", "share", "more", "way", "reversed"]
"""What is asked of the model's responses to the clips.

- ``each``: the measure is at least the bound in every clip.
- ``none``: it is at most the bound in every clip, and some clip ``control`` is answered by a spike.
- ``ratio``: the least measure is at least the bound times the greatest in ``against``.
- ``share``: the greatest is at most the bound times the least in ``against``.
- ``more``: summed over the clips, the measure of the model ``than`` is at least the bound times that of this model.
- ``way``: the strongest potential has the system and the sign of the motion, in at least that share of the clips.
- ``reversed``: it has the system of the motion and the other sign, in at least that share of the clips.
"""
Measure = Literal["spikes", "peak", "way", "peak_target", "on_target"]
"""A clip's number of spikes; how far the looming potential rises above rest; the largest |HS| or |VS|; the strongest
response to a small target; the share of the frames with a target in which that response is within 5 px of it."""
REST = 0.5
"""Potential of a looming detector at rest."""
UNITS: Mapping[Measure, str] = {"spikes": "spikes", "peak": "above rest", "way": "of |HS|, |VS|",
                                 "peak_target": "at most", "on_target": "of its frames on the target"}  # fmt: skip
OPPOSITE = {"rightward": "leftward", "leftward": "rightward", "downward": "upward", "upward": "downward"}
Groups = tuple[str, ...]
"""Names of `model_clips.GROUPS`."""


def claim_on_clips(
    name: str, model: str, test: Test, measure: Measure, bound: float, clips: Groups, against: Groups = (), *,
    control: Groups = (), than: str = "",
) -> Claim:  # fmt: skip
    """Return a statement of a model's own paper that clips can test.

    Parameters
    ----------
    name
        Its id.
    model
        The model that it is about: a registered name, with settings where the claim names them.
    test, measure, bound
        What is asked of which number: see `Test` and `Measure`.
    clips, against, control
        Groups of clips: those judged, those they are compared with, and those to which a model responds that is not
        silent.
    than
        For ``more``: the model that it is compared with.
    """

    def value(row: Row) -> float:
        if measure == "spikes":
            return float(row["spikes"])
        if measure == "peak":
            return float(row["peak_looming"]) - REST
        if measure in ("peak_target", "on_target"):
            return float(row[measure])
        return max(sign * float(row[column]) for column, sign in SIGNED.values())

    def text(row: Row) -> str:
        return f"{row['clip']}: {value(row):.3g} {UNITS[measure]}"

    def judge(table: Rows, threshold: float) -> Outcome:
        mine, others, woken = (_of(table, model, groups) for groups in (clips, against, control))
        if test in ("way", "reversed"):
            expected = OPPOSITE if test == "reversed" else {way: way for way in OPPOSITE}
            hits = sum(answer(row) == expected[row["motion"]] for row in mine)
            sign = "the other sign" if expected is OPPOSITE else "sign"
            answered = f"{hits} of {len(mine)} clips answered by the right system and {sign}"
            return Outcome.of([Check(answered, hits / len(mine), bound, "at least")])
        if test in ("each", "none"):
            side: Needs = "at least" if test == "each" else "at most"
            outcome = Outcome.of([Check(text(row), value(row), bound, side) for row in mine])
            return _unless_silent(outcome, [row["spikes"] for row in woken]) if test == "none" else outcome
        if test == "more":
            theirs, ours = (sum(map(value, rows)) for rows in (_of(table, than, clips), mine))
            needs: Needs = "at least" if theirs else "above"  # of two silent models neither answers more
            return Outcome.of([Check(f"{than} {theirs:.3g} in all, {model} {ours:.3g}", theirs, bound * ours, needs)])
        if test == "ratio":
            row, other, needs = min(mine, key=value), max(others, key=value), "at least"
        else:
            row, other, needs = max(mine, key=value), min(others, key=value), "at most"
        asks = f"{needs} {bound:g} times that of {text(other)}"
        outcome = Outcome.of([Check(text(row), value(row), bound * value(other), needs, asks=asks)])
        return _unless_silent(outcome, map(value, others)) if test == "share" else outcome

    shown = names(dict.fromkeys((*clips, *against, *control)))
    return _of_paper(name, model, judge, models=frozenset({model, than} - {""}), conditions={"clip": shown},
                     of_potentials=measure != "spikes")  # fmt: skip


def _untested(name: str, model: str, why: str) -> Claim:
    """Return a statement that no clip tests: a claim without conditions, whose judge says why."""
    return _of_paper(name, model, lambda *_: Outcome.unjudged(why), models=frozenset({model}))


def _of_paper(name: str, model: str, judged: Callable[..., Outcome], **fields: Any) -> Claim:
    paper = texts()["papers"][model.partition(":")[0]]
    return Claim(id=name, judge=judged, says=paper[name], source=paper["source"], on="clips", **fields)


def _of(clips: Rows, label: str, groups: Iterable[str]) -> list[Row]:
    """Return a model's rows of the clips of some groups."""
    wanted = set(names(groups))
    return [row for row in rows_of(clips, label) if row["clip"] in wanted]


def _unless_silent(outcome: Outcome, responses: Iterable[float]) -> Outcome:
    """Return the outcome; where a model satisfies the claim that has none of the ``responses``, it is not judged."""
    if outcome.verdict != "holds" or any(response > 0.0 for response in responses):
        return outcome
    return outcome.silent("silent in all clips that it should answer")


LOOMING, LIGHT, RECEDING = ("dark-looming",), ("light-looming",), ("dark-receding", "light-receding")
ACROSS, GRATINGS, TIMELY = ("translating",), ("gratings",), ("timely-targets",)

CLAIMS = (
    claim_on_clips("LPLC2-1", "lplc2", "each", "spikes", 1.0, LOOMING),
    claim_on_clips("LPLC2-2", "lplc2", "none", "spikes", 0.0, (*ACROSS, *GRATINGS), control=LOOMING),
    claim_on_clips("LPLC2-3", "lplc2", "none", "spikes", 0.0, RECEDING, control=LOOMING),
    claim_on_clips("LPLC2-4", "lplc2", "share", "peak", 0.5, ("off-centre",), LOOMING),
    claim_on_clips("GF-1", "lplc2-gf", "each", "spikes", 1.0, LOOMING),
    claim_on_clips("GF-2", "lplc2-gf", "none", "spikes", 0.0, (*ACROSS, *GRATINGS, *RECEDING), control=LOOMING),
    claim_on_clips("GF-3", "lplc2-gf:fps=100", "each", "spikes", 1.0, ("looming-100",)),
    _untested("GF-4", "lplc2-gf", "the paper's virtual robot and its corridor are not built here"),
    claim_on_clips("MLPLC2-1", "mlplc2", "each", "spikes", 1.0, (*LOOMING, *LIGHT)),
    claim_on_clips("MLPLC2-2", "mlplc2", "each", "spikes", 1.0, ("off-centre",)),
    claim_on_clips("MLPLC2-3", "mlplc2", "none", "spikes", 0.0, (*ACROSS, *GRATINGS), control=LOOMING),
    claim_on_clips("MLPLC2-4", "mlplc2", "none", "spikes", 0.0, RECEDING, control=LOOMING),
    claim_on_clips("SI1-1", "si-lgmd1", "each", "spikes", 4.0, (*LOOMING, *LIGHT)),
    claim_on_clips("SI1-2", "si-lgmd1", "none", "spikes", 3.0, ACROSS, control=LOOMING),
    claim_on_clips("SI1-3", "si-lgmd1", "more", "peak", 2.0, ACROSS, than="si-lgmd1:beta_3=0"),
    _untested("SI1-4", "si-lgmd1", "needs over a thousand encounters a model to tell 96.1 from 93.7 %"),
    claim_on_clips("SI2-1", "si-lgmd2", "each", "spikes", 4.0, LOOMING),
    claim_on_clips("SI2-2", "si-lgmd2", "share", "spikes", 0.5, (*LIGHT, "dark-receding"), LOOMING),
    claim_on_clips("SI2-3", "si-lgmd2", "none", "spikes", 3.0, ACROSS, control=LOOMING),
    claim_on_clips("PON-1", "pon-lgmd", "ratio", "peak", 0.5, ("low-contrast",), LOOMING),
    claim_on_clips("PON-2", "pon-lgmd", "ratio", "peak", 1.0, (*LOOMING, *LIGHT), (*ACROSS, *RECEDING)),
    claim_on_clips("PON-3", "pon-lgmd", "ratio", "peak", 2.0, ("before-grating",), ("grating-alone",)),
    claim_on_clips("EMDN-1", "emd-normalised", "way", "way", 1.0, ACROSS),
    claim_on_clips("EMDN-2", "emd-normalised", "ratio", "way", 0.5, ("faint-gratings",), GRATINGS),
    claim_on_clips("EMDN-3", "emd-normalised", "ratio", "way", 0.5, ("panning-scenes",), ("panning-scenes",)),
    _untested("EMDN-4", "emd-normalised", "the paper's panoramas and the weights of its trained network are not here"),
    claim_on_clips("T4T5-1", "t4t5", "way", "way", 1.0, ACROSS),
    claim_on_clips("T4T5-2", "t4t5", "share", "way", 0.1, (*LOOMING, *LIGHT), ACROSS),
    claim_on_clips("ARM3-1", "three-arm", "way", "way", 1.0, ACROSS),
    claim_on_clips("ARM3-2", "three-arm", "share", "way", 0.1, (*LOOMING, *LIGHT), ACROSS),
    _untested("ARM3-3", "three-arm", "a cell's answer to pairs of flashes is not in HS and VS"),
    claim_on_clips("ARM3-4", "three-arm-4q", "way", "way", 1.0, ACROSS),
    claim_on_clips("ARM3-5", "three-arm-4q", "reversed", "way", 1.0, ("reverse-phi",)),
    claim_on_clips("ESTMD-1", "estmd:fps=1000", "share", "peak_target", 0.5, ("tall-targets",), ("small-targets",)),
    claim_on_clips("ESTMD-2", "estmd:fps=1000", "share", "peak_target", 0.8, ("low-targets",), ("small-targets",)),
    claim_on_clips("ESTMD-3", "estmd:fps=1000", "share", "peak_target", 0.5, ("untimely-targets",), TIMELY),
    claim_on_clips("ESTMD-4", "estmd:fps=1000", "share", "peak_target", 0.5, ("light-targets",), ("dark-targets",)),
    claim_on_clips("ESTMD-5", "estmd:fps=1000", "each", "on_target", 0.5, ("targets-in-clutter",)),
    claim_on_clips("ESTMD-6", "estmd", "share", "peak_target", 0.5, ("tall-targets-30",), ("small-targets-30",)),
    claim_on_clips("DSTMD-1", "dstmd:fps=1000", "share", "peak_target", 0.5, ("tall-targets",), ("small-targets",)),
    claim_on_clips("DSTMD-2", "dstmd:fps=1000", "share", "peak_target", 0.5, ("untimely-targets",), TIMELY),
    claim_on_clips("DSTMD-3", "dstmd:fps=1000", "each", "on_target", 0.5, ("targets-in-clutter",)),
)  # fmt: skip


@cache
def model_claims() -> Mapping[str, tuple[Claim, ...]]:
    """Return registered model -> the claims of its own paper, in the models' order."""
    of = {name: tuple(claim for claim in CLAIMS if min(claim.models).partition(":")[0] == name) for name in MODELS}
    return {name: claims for name, claims in of.items() if claims}
