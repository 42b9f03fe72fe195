"""The claims of other models' own papers, on clips. Their words are in ``claims.toml``, below the models' names.

Words and bounds were written, and committed, before the code of these models. A bound that a model misses is reported
as a failure; it is never edited to fit.
"""

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from itertools import product
from typing import Any, Literal

from dsnn import MODELS
from experiments.declare.claim import Claim, texts
from experiments.declare.clip import Clip
from experiments.declare.outcome import Check, Needs, Outcome
from experiments.judge.judge import SIGNED, Row, Rows
from experiments.paper.claims.clips import answer, rows_of

L_OVER_V_S = (0.08, 0.16, 0.32)
FRAME = {"rows": 72, "columns": 99}
DARK_ON_LIGHT, LIGHT_ON_DARK = {"grey": 40.0, "background_grey": 200.0}, {"grey": 200.0, "background_grey": 40.0}
OPPOSITE = {"rightward": "leftward", "leftward": "rightward", "downward": "upward", "upward": "downward"}
SPEEDS_PX_S, CONTRAST = (60.0, 120.0), 0.8
BEHIND = {"grey": 40.0, "background_grey": 127.5, "background": "grating", "period_px": 16.0, "contrast": 0.4,
          "temporal_hz": 2.0}  # fmt: skip
FAINT = 4.0
"""What the contrast of a faint grating is divided by."""
PANNING = ("dead-leaves", "pink", "foliage", "street")


def _looming(group: str, changes: Mapping[str, Any]) -> tuple[Clip, ...]:
    """A clip for each l / v."""
    return tuple(Clip(f"{group} {s:g} s", "looming", {"l_over_v_s": s, **changes}) for s in L_OVER_V_S)


def _gratings(group: str, contrast: float) -> tuple[Clip, ...]:
    shared = {**FRAME, "period_px": 16.0, "contrast": contrast}
    return tuple(
        Clip(f"{group} {hz:g} Hz {deg:g} deg", "grating", {**shared, "temporal_hz": hz, "direction_deg": deg})
        for hz, deg in product((2.0, 4.0), (0.0, 90.0, 180.0, 270.0))
    )


def _targets(group: str, name: str, values: Iterable[Any], **changes: Any) -> tuple[Clip, ...]:
    """Small targets on an even ground, or before a scene: a clip for each value of one parameter."""
    shared = {"fps": 1000.0, "duration_s": 0.4, "background": "even", "background_speed": 0.0, "speed": 200.0}
    return tuple(Clip(f"{group} {value}", "target", {**shared, **changes, name: value}) for value in values)


SMALL_PX, TALL_PX = (3.0, 5.0), (12.0, 15.0)
"""Heights of targets."""
SLOW = {"fps": 30.0, "speed": 150.0}
"""At 30 frames/s targets go on by their width in a frame."""
RECEDES = {"motion": "receding"}
SHADES = {"dark": DARK_ON_LIGHT, "light": LIGHT_ON_DARK}
SQUARE = {**FRAME, "width": 25.0, "height": 25.0}
ALONE = {**FRAME, "object": "absent", "background_speed": -SPEEDS_PX_S[0]}
GROUPS: Mapping[str, tuple[Clip, ...]] = {
    "dark-looming": _looming("dark-looming", DARK_ON_LIGHT),
    "light-looming": _looming("light-looming", LIGHT_ON_DARK),
    "dark-receding": _looming("dark-receding", {**DARK_ON_LIGHT, **RECEDES}),
    "light-receding": _looming("light-receding", {**LIGHT_ON_DARK, **RECEDES}),
    "off-centre": tuple(
        Clip(f"off-centre {angle:+g} deg", "looming", {"l_over_v_s": 0.16, "azimuth_deg": angle, **DARK_ON_LIGHT})
        for angle in (-20.0, 20.0)
    ),
    "low-contrast": _looming("low-contrast", {"grey": 160.0, "background_grey": 200.0}),
    "translating": tuple(
        Clip(f"translating {shade} {way} {v:g} px/s", "plain", {**SQUARE, "motion": way, "speed": v, **greys})
        for (shade, greys), way, v in product(SHADES.items(), OPPOSITE, SPEEDS_PX_S)
    ),
    "gratings": _gratings("gratings", CONTRAST),
    "faint-gratings": _gratings("faint-gratings", CONTRAST / FAINT),
    "before-grating": _looming("before-grating", BEHIND),
    "grating-alone": _looming("grating-alone", {**BEHIND, "object": "absent"}),
    "panning-scenes": tuple(Clip(f"panning {name}", "cluttered", {**ALONE, "background": name}) for name in PANNING),
    "reverse-phi": tuple(Clip(f"reverse-phi {way}", "reverse-phi", {**FRAME, "motion": way}) for way in OPPOSITE),
    "small-targets": _targets("small target", "height", SMALL_PX),
    "tall-targets": _targets("tall target", "height", TALL_PX),
    "low-targets": _targets("low target", "height", (1.0,)),
    "timely-targets": _targets("timely target", "speed", (100.0, 200.0, 300.0)),
    "untimely-targets": _targets("untimely target", "speed", (20.0, 1500.0)),
    "dark-targets": _targets("dark target", "grey", (0.0,), background_grey=200.0),
    "light-targets": _targets("light target", "grey", (255.0,), background_grey=55.0),
    "targets-in-clutter": _targets("target before", "background", PANNING, background_speed=100.0, speed=150.0),
    "small-targets-30": _targets("small target at 30 Hz", "height", SMALL_PX, **SLOW),
    "tall-targets-30": _targets("tall target at 30 Hz", "height", TALL_PX, **SLOW),
    "looming-100": _looming("looming-100", {**DARK_ON_LIGHT, "fps": 100.0}),
}
"""Group -> its clips. All are 99x72 px, as seen by the robot's camera."""


def names(groups: Iterable[str]) -> tuple[str, ...]:
    """The names of the clips of some groups."""
    return tuple(clip.name for group in groups for clip in GROUPS[group])


CLIPS: Mapping[str, Clip] = {clip.name: clip for clips in GROUPS.values() for clip in clips}
"""Every clip, by its name."""


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
Groups = tuple[str, ...]
"""Names of `GROUPS`."""


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
