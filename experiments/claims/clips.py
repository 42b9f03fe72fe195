"""The paper's claims about clips, C1 to C11, C22 to C24 and C26 to C28. Their words are in ``claims.toml``.

The docstring of a judge says how the words are read where they leave room.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain, pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from experiments.bench.sources.judge import EVERY, SHADES, SIGNED, Row
from experiments.bench.stats.checks import MARGIN, Check, Needs, decide, exceeds, unreadable
from experiments.bench.stats.claim import DSNN
from experiments.bench.stats.claim import shipped as claim
from experiments.bench.stats.verdict import Outcome
from experiments.claims.robot import CONNECTIONS, FEWER, PER_CORRELATOR

if TYPE_CHECKING:
    import polars as pl

EARLIER, EMD = "dsn2017", "emd"
LEAST_GREYS = 5
"""Grey levels that the claims about contrast need."""
MOST_OF_DRIVEN, LEAST_OF_OTHER = 0.05, 0.95
"""Of the answer to one edge, what C22 lets either blocked pathway leave: that which it drives, and the other."""

_UNREAD = "are neither in the paper nor in any public text or code that could be searched"
ASSUMED: Mapping[str, str] = {
    "dsn2017": f"the constants of the model of 2017 (Fu and Yue 2017, IJCNN) {_UNREAD}; it is taken to be the DSNN "
    "without FDSR, with the DSNN's constants",
    "emd": f"the constants of Iida's EMD (Iida and Lambrinos 2000; Iida 2003) {_UNREAD}; a high-pass of 250 ms, a "
    "delay of 50 ms and neighbouring pixels are assumed",
}
"""Model -> what is not known of it, and what is assumed.

The paper compares the DSNN with its forerunner of 2017 and with the elementary motion detectors of Iida. It gives the
constants of neither. What is assumed of them decides how such a claim comes out, so that it can neither be refuted nor
borne out by them.
"""
MATCHED: Mapping[str, str] = {
    "dsn2017": "dsn2017:k_sig=33.22",
    "dsnn:fdsr=false": "dsnn:fdsr=false,k_sig=33.22",
    "dsnn:dog=false": "dsnn:dog=false,k_sig=0.3056",
    "emd": "emd:gain=0.7732",
}  # fmt: skip
"""Label of a model that the DSNN is compared with -> the same on equal terms.

At 30 frames a second FDSR leaves about 1/34 of a rise, so that the DSNN without it has products some 1,180 times as
large for any stimulus whatever, and a comparison of potentials compares gains. So each rival is judged a second time
with one gain, set by one rule, to four digits: its peak HS in the clip ``dark rightward`` of the experiment ``clean``
equals the DSNN's. There nothing is random and no background shifts, and no claim that compares with a rival is about
it. The gain of a model with a sigmoid is that ahead of the sigmoid, its scale K_sig, as what is behind it cannot pass
1; that of the EMD is the gain of its output. Nothing else of a rival is changed.
"""


BLOCKED = ("dsnn-on-blocked", "dsnn-off-blocked")
WITHOUT = ("dsnn:dog=false", "dsnn:fdsr=false")
"""The DSNN without the lamina's difference of Gaussians, and without the adaptation after it."""
BACKGROUNDS = (-2.0, -4.0, -6.0, -8.0, -10.0)
"""Speeds of the paper's backgrounds, px/s."""
WAYS = ("rightward", "leftward")
CROSSING: Mapping[str, tuple[Any, ...]] = {"motion": ("rightward",)}
CONTRAST_GRID: Mapping[str, tuple[Any, ...]] = {
    **CROSSING, "background_speed": (-8.0,), "speed": (40.0, 60.0, 80.0, 100.0, 120.0), "grey": EVERY,
}  # fmt: skip
"""Conditions of the claims about the paper's grid of greys and speeds."""


def against(*models: str) -> dict[str, Any]:
    """Return what a claim declares that compares the DSNN with other models, on equal terms too."""
    return {"models": {DSNN, *models}, "equal_terms": {label: MATCHED[label] for label in models}}


def answer(row: Row) -> str | None:
    """Return the direction of the strongest potential of either system; ``None`` if two are equal, or all silent."""
    strengths = {direction: sign * row[column] for direction, (column, sign) in SIGNED.items()}
    strongest = max(strengths.values())
    named = [direction for direction, strength in strengths.items() if strength == strongest]
    return named[0] if len(named) == 1 else None


def rows_of(clips: pl.DataFrame, model: str = DSNN, **fixed: Any) -> list[dict[str, Any]]:
    """Return the rows of a model in which columns have the ``fixed`` values, in the table's order."""
    return clips.filter(model=model, **fixed).rows(named=True)


def levels(clips: pl.DataFrame, name: str) -> list[float]:
    """Return the values of a column, each once, from the lowest up."""
    return clips[name].drop_nulls().unique().sort().to_list()


def strongest(row: Row, system: str) -> float:
    """Return the largest absolute potential of ``hs`` or ``vs`` in a clip."""
    return float(max(row[f"peak_{system}"], -row[f"trough_{system}"]))


def passes(row: Row, name: str, sign: float, threshold: float) -> Check:
    """Return the check that a clip's potential goes past T to the side of ``sign``."""
    side: Needs = "above" if sign > 0 else "below"
    return Check(f"{row['clip']}: {name} {row[name]:+.3f}", row[name], sign * threshold, side, scale=threshold)


def inside(row: Row, what: str, value: float, threshold: float, needs: Needs = "at most") -> Check:
    """Return the check that a potential of a clip stays inside +-T, or has what it ``needs`` otherwise."""
    return Check(f"{row['clip']}: {row['model']} {what} {value:.3f}", value, threshold, needs, scale=threshold)


def rises(clips: pl.DataFrame, threshold: float, what: str) -> list[Check]:
    """Return the checks of more peak HS at each speed than at the next lower one."""
    return [
        exceeds(f"{what}: peak HS {more:.3f} at {fast:g} px/s", more, less, f"at {slow:g}", "potential",
                scale=threshold)
        for (slow, less), (fast, more) in pairwise(clips.sort("speed").select("speed", "peak_hs").rows())
    ]  # fmt: skip


def compared(of_dsnn: Sequence[Check], of_other: Sequence[Check], model: str) -> Outcome:
    """Return the outcome of a claim that says one thing of the DSNN and another of a model of unknown constants.

    Parameters
    ----------
    of_dsnn
        What the claim asks of the DSNN, one check or more.
    of_other
        What it asks of the other model, or of the two held against each other, one check or more.
    model
        The label of the other model, one of `ASSUMED`.

    Returns
    -------
    Outcome
        ``fails`` where the DSNN's half does, whatever the other model does. Otherwise it cannot be judged, whichever
        way the other half comes out with the constants assumed; `Outcome.settled` is the outcome with them.
    """
    whole = Outcome.of([*of_dsnn, *of_other])
    alone, decided = decide(of_dsnn)
    if not alone:
        return Outcome("fails", whole.measured, decided=decided, checks=whole.checks)
    rest, by = decide(of_other)
    why = (
        f"the DSNN's half holds: {decided}; the rest hangs on constants of {model} that are not known, and with those "
        f"assumed {'holds' if rest else 'fails'}: {by}"
    )
    return Outcome("unknown constants", whole.measured, decided=why, checks=whole.checks)


def both(row: Row) -> float:
    """Return the largest absolute potential of both systems in a clip."""
    return max(strongest(row, "hs"), strongest(row, "vs"))


@claim("C1", conditions={"motion": tuple(SIGNED), "shade": SHADES}, of_each=True)
def c1(clips: pl.DataFrame, threshold: float) -> list[Check]:
    """Judge that every translation passes the threshold of its own direction."""
    return [passes(row, *SIGNED[row["motion"]], threshold) for row in rows_of(clips)]


@claim("C2", conditions={"motion": tuple(SIGNED), "shade": SHADES}, of_each=True, silent_passes=True)
def c2(clips: pl.DataFrame, threshold: float) -> list[Check]:
    """Judge HS of vertical translations, and VS of horizontal ones."""
    others = {motion: "vs" if motion in WAYS else "hs" for motion in SIGNED}
    return [
        inside(row, others[row["motion"]], strongest(row, others[row["motion"]]), threshold) for row in rows_of(clips)
    ]


@claim("C3", conditions={"motion": ("looming", "receding"), "shade": SHADES}, of_each=True, silent_passes=True)
def c3(clips: pl.DataFrame, threshold: float) -> list[Check]:
    """Judge both systems, over the whole of each clip."""
    return [inside(row, "HS and VS", both(row), threshold) for row in rows_of(clips)]


HALF = (0.4, 0.6)
"""Of the intact peak, what either pathway alone may leave."""
SUM_TOLERANCE = 1e-3


@claim("C4", models={DSNN, *BLOCKED}, conditions={"motion": tuple(SIGNED)}, of_each=True)
def c4(clips: pl.DataFrame, threshold: float) -> list[Check]:
    """Judge that each pathway alone leaves its share of the intact peak, and that both add up to the whole."""
    checks = []
    for whole in rows_of(clips):
        clip, name = whole["clip"], SIGNED[whole["motion"]][0]
        intact = whole[name]
        peaks = [rows_of(clips, model, clip=clip)[0][name] for model in BLOCKED]
        for model, peak in zip(BLOCKED, peaks, strict=True):
            share = peak / intact if intact else float("nan")
            checks.append(Check(f"{clip}: {model} leaves {share:.1%}", share, HALF, "within", scale=HALF[1] - HALF[0]))
        rest = abs(sum(peaks) - intact)
        adds = f"{clip}: ON and OFF alone differ from the whole by {rest:.1e}"
        checks.append(Check(adds, rest, SUM_TOLERANCE, "below", scale=SUM_TOLERANCE))
    return checks


@claim("C5", **against(EARLIER), conditions={"motion": ("looming", "receding"), "background_speed": (8.0,)},
       of_each=True, silent_passes=True)  # fmt: skip
def c5(clips: pl.DataFrame, threshold: float) -> Outcome:
    """Judge both systems of the DSNN in every clip; of the 2017 model one of both passes T in every clip."""
    checks = [inside(row, "HS and VS", both(row), threshold) for row in rows_of(clips)]
    of_other = [inside(row, "HS or VS", both(row), threshold, "above") for row in rows_of(clips, EARLIER)]
    return compared(checks, of_other, EARLIER)


@claim("C6", **against(EARLIER), conditions={**CROSSING, "background_speed": (-8.0,)}, of_each=True)
def c6(clips: pl.DataFrame, threshold: float) -> Outcome:
    """Judge HS and VS of the DSNN in every clip; of the 2017 model VS passes T in every clip."""
    rows = rows_of(clips)
    checks = [passes(row, "peak_hs", 1.0, threshold) for row in rows]
    checks += [inside(row, "|VS|", strongest(row, "vs"), threshold) for row in rows]
    of_other = [inside(row, "|VS|", strongest(row, "vs"), threshold, "above") for row in rows_of(clips, EARLIER)]
    return compared(checks, of_other, EARLIER)


@claim(
    "C7", **against(EARLIER),
    conditions={**CROSSING, "speed": (40.0, 80.0, 120.0), "background_speed": BACKGROUNDS, "grey": EVERY},
)  # fmt: skip
def c7(clips: pl.DataFrame, threshold: float) -> Outcome:
    """Judge every step of speed, and the spread over background speeds: largest peak less smallest, meaned."""
    of_dsnn = clips.filter(model=DSNN)
    checks = [
        check
        for grey in levels(of_dsnn, "grey")
        for behind in levels(of_dsnn, "background_speed")
        for check in rises(
            of_dsnn.filter(grey=grey, background_speed=behind), threshold, f"grey {grey:g} before {behind:g}"
        )
    ]
    spreads = {model: _spread(clips.filter(model=model)) for model in (DSNN, EARLIER)}
    text = f"over background speeds {EARLIER}'s peak HS varies by {spreads[EARLIER]:.4f}"
    more = exceeds(text, spreads[EARLIER], spreads[DSNN], "of the DSNN", "potential", scale=threshold)
    return compared(checks, [more], EARLIER)


def _spread(clips: pl.DataFrame) -> float:
    """Return the spread of peak HS over what else differs than object and speed, meaned over these."""
    peaks = [
        clips.filter(grey=grey, speed=speed)["peak_hs"].to_numpy()
        for grey in levels(clips, "grey")
        for speed in levels(clips, "speed")
    ]
    return float(np.mean([np.ptp(group) for group in peaks]))


@claim(
    "C8", of_each=True, silent_passes=True,
    conditions={**CROSSING, "speed": (40.0, 80.0, 120.0), "background_speed": BACKGROUNDS, "shade": SHADES},
)  # fmt: skip
def c8(clips: pl.DataFrame, threshold: float) -> list[Check]:
    """Judge VS to either side: its trough as well as its peak."""
    return [inside(row, "|VS|", strongest(row, "vs"), threshold, "below") for row in rows_of(clips)]


@claim("C9", conditions=CONTRAST_GRID, least_greys=LEAST_GREYS)
def c9(clips: pl.DataFrame, threshold: float) -> list[Check]:
    """Judge every step of speed."""
    shown = clips.filter(model=DSNN, object="present")
    greys = levels(shown, "grey")
    return [check for grey in greys for check in rises(shown.filter(grey=grey), threshold, f"grey {grey:g}")]


@claim("C10", conditions=CONTRAST_GRID, least_greys=LEAST_GREYS)
def c10(clips: pl.DataFrame, threshold: float) -> list[Check] | Outcome:
    """Judge at each speed by itself; the background's mean is that of the rows that the object passes."""
    shown = clips.filter(model=DSNN, object="present")
    greys = levels(shown, "grey")
    ground = float(np.mean(shown["background_mean"].to_numpy()))
    nearest = min(greys, key=lambda grey: abs(grey - ground))
    if nearest in (greys[0], greys[-1]):
        return Outcome.unjudged(f"needs greys on both sides of the background's mean, {ground:.0f}")
    checks = []
    for speed in levels(shown, "speed"):
        peak = {row["grey"]: row["peak_hs"] for row in reversed(rows_of(shown, speed=speed))}  # of two the first
        for low, high in pairwise(greys):
            more, less = (low, high) if high <= nearest else (high, low)
            text = f"{speed:g} px/s: peak HS {peak[more]:.3f} at grey {more:g}"
            checks.append(exceeds(text, peak[more], peak[less], f"at {less:g}", "potential", scale=threshold))
    return checks


@claim("C11", **against(EMD), conditions=CONTRAST_GRID, alone="background_speed")
def c11(clips: pl.DataFrame, threshold: float) -> Outcome:
    """Judge whether a model's weakest answer to a translation beats every answer to a background alone.

    Answers are the largest abs(HS) of a clip; of the background-only clips, of all there are. The EMD model is asked
    about 40 and 60 px/s, the DSNN about all speeds: the paper says "even at the lowest velocity".
    """
    checks = {}
    for model, slow in ((EMD, (40.0, 60.0)), (DSNN, None)):
        behind = max(strongest(row, "hs") for row in rows_of(clips, model, object="absent"))
        shown = [row for row in rows_of(clips, model, object="present") if slow is None or row["speed"] in slow]
        weakest = min(strongest(row, "hs") for row in shown)
        text = f"{model}: weakest |HS| to an object {weakest:.3f}"
        checks[model] = exceeds(text, weakest, behind, "without", "potential", scale=max(behind, threshold))
    not_more = replace(checks[EMD], needs="below", asks=f"below {MARGIN['potential']:+g}")
    return compared([checks[DSNN]], [not_more], EMD)


@claim("C22", models={DSNN, *BLOCKED}, of_each=True,
       conditions={"stimulus": ("edge",), "motion": WAYS, "polarity": ("on", "off")})  # fmt: skip
def c22(clips: pl.DataFrame, threshold: float) -> list[Check]:
    """Judge one edge in view: what each blocked pathway leaves of the largest |HS|.

    An OFF edge is the leading one of a dark object and the trailing one of a light object, an ON edge the reverse.
    """
    checks = []
    bounds: tuple[tuple[float, Needs], ...] = ((MOST_OF_DRIVEN, "below"), (LEAST_OF_OTHER, "above"))
    for whole in rows_of(clips):
        clip, intact = whole["clip"], strongest(whole, "hs")
        driven_first = BLOCKED if whole["polarity"] == "on" else BLOCKED[::-1]
        for model, (bound, side) in zip(driven_first, bounds, strict=True):
            left = strongest(rows_of(clips, model, clip=clip)[0], "hs") / intact if intact else float("nan")
            checks.append(Check(f"{clip}: {model} leaves {left:.1%} of |HS| {intact:.3f}", left, bound, side))
    return checks


SAME, OPPOSITE = ("on-on", "off-off"), ("on-off", "off-on")
"""Two steps of one sign, and of opposite signs."""
MOST_OF_OPPOSITE = 0.1


@claim("C23", conditions={"stimulus": ("apparent",), "motion": WAYS, "polarity": (*SAME, *OPPOSITE)})
def c23(clips: pl.DataFrame, threshold: float) -> list[Check] | Outcome:
    """Judge the strongest HS: of one sign its direction, of opposite signs its share of that.

    The share is of the weaker of both answers to steps of one sign, in the same direction with the same delay.
    """
    clips = clips.sort("clip")  # those of one delay have one place in every pair
    hs = {
        (motion, pair): [_signed(row) for row in rows_of(clips, motion=motion, polarity=pair)]
        for motion in WAYS
        for pair in (*SAME, *OPPOSITE)
    }
    if len({len(answers) for answers in hs.values()}) > 1:
        return Outcome.unjudged("needs as many clips of every pair of steps in both directions")
    checks = []
    sides: tuple[tuple[str, Needs], ...] = (("rightward", "above"), ("leftward", "below"))
    for motion, side in sides:
        for pair in SAME:
            for value in hs[motion, pair]:
                checks.append(Check(f"{motion} {pair}: strongest HS {value:+.3f}", value, 0.0, side, scale=threshold))
        for pair in OPPOSITE:
            for index, value in enumerate(hs[motion, pair]):
                least = min(abs(hs[motion, same][index]) for same in SAME)
                share = abs(value) / least if least else float("nan")
                text = f"{motion} {pair}: |HS| {abs(value):.3f}, {share:.0%} of {least:.3f} for one sign"
                checks.append(Check(text, share, MOST_OF_OPPOSITE, "below"))
    return checks


def _signed(row: Row) -> float:
    """Return the HS of largest size, with its sign."""
    return float(row["peak_hs"] if row["peak_hs"] >= -row["trough_hs"] else row["trough_hs"])


@claim("C24", models={DSNN, *FEWER}, equal_terms={CONNECTIONS[n]: PER_CORRELATOR[n] for n in (1, 2)},
       conditions=CONTRAST_GRID, least_greys=LEAST_GREYS)  # fmt: skip
def c24(clips: pl.DataFrame, threshold: float) -> list[Check]:
    """Judge the off-line part: every clip of the contrast grid."""
    shown = clips.filter(object="present")
    peaks = {model: {row["clip"]: row["peak_hs"] for row in rows_of(shown, model)} for model in (DSNN, *FEWER)}
    checks = [
        exceeds(f"{clip}: peak HS {peak:.3f}", peak, peaks[model][clip], f"of {model}", "potential", scale=threshold)
        for model in FEWER
        for clip, peak in peaks[DSNN].items()
    ]
    past = {model: float(sum(peak > threshold for peak in of_model.values())) for model, of_model in peaks.items()}
    for model in FEWER:
        text, asks = f"passes T in {past[DSNN]:g} clips", f"more than {past[model]:g} of {model}"
        checks.append(Check(text, past[DSNN], past[model], unit="clips", asks=asks))
    return checks


@claim("C26", **against(EMD), conditions=CONTRAST_GRID, least_greys=LEAST_GREYS)
def c26(clips: pl.DataFrame, threshold: float) -> Outcome:
    """Judge every step of speed, or that not every one rises.

    The DSNN's peaks are of HS, as in C9; the EMD's of |HS|, as in C11: the background drives its HS the other way.
    """
    import polars as pl  # not before: it takes its time to load

    shown = clips.filter(object="present")
    of_emd = shown.filter(model=EMD).with_columns(peak_hs=pl.max_horizontal("peak_hs", -pl.col("trough_hs")))
    greys = levels(shown.filter(model=DSNN), "grey")
    of_dsnn, of_other = (
        {grey: rises(peaks.filter(grey=grey), threshold, f"{model}, grey {grey:g}") for grey in greys}
        for model, peaks in ((DSNN, shown.filter(model=DSNN)), (f"{EMD}, of |HS|", of_emd))
    )
    for grey in greys[1:-1]:
        least, bound = min(step.reading for step in of_other[grey]), MARGIN["potential"]
        text = f"{EMD}, grey {grey:g}: least step of the peak with speed {least:+.4f}"
        of_other[grey] = [Check(text, least, bound, "below", scale=threshold)]
    return compared([*chain(*of_dsnn.values())], [*chain(*of_other.values())], EMD)


LEAST_FACTOR = 2.0


@claim("C27", **against(*WITHOUT), conditions={"object": ("absent",), "background_speed": BACKGROUNDS},
       of_each=True)  # fmt: skip
def c27(clips: pl.DataFrame, threshold: float) -> list[Check]:
    """Judge each of |HS| and |VS|, without the one and without the other, in every clip of the background alone."""
    checks = []
    for whole in rows_of(clips):
        for model in WITHOUT:
            for system in ("hs", "vs"):
                intact = strongest(whole, system)
                left = strongest(rows_of(clips, model, clip=whole["clip"])[0], system)
                factor = left / intact if intact else float("nan")
                text = f"{whole['clip']}: |{system.upper()}| {left:.4f} of {model}, {factor:.2f} times {intact:.4f}"
                checks.append(Check(text, factor, LEAST_FACTOR, "at least"))
    return checks


@claim(
    "C28", of_each=True, alone="foliage",
    conditions={"foliage": ("windblown",), "movers": ("one", "opposite", "group"), "motion": WAYS},
)  # fmt: skip
def c28(clips: pl.DataFrame, threshold: float) -> list[Check] | Outcome:
    """Judge that every mover is answered with its sign, and that what has no mover stays inside +-T.

    A street of our own rendering stands in for the paper's real footage. "HS passes T with the sign of each" was read
    before any model was shown such a clip: while one is in view HS passes T with the sign of its direction, and does
    not pass it with the other.
    """
    checks = []
    for row in rows_of(clips):
        if row["object"] == "absent":
            checks += [inside(row, f"|{system.upper()}|", strongest(row, system), threshold) for system in ("hs", "vs")]
            continue
        ways = WAYS if row["movers"] == "opposite" else (row["motion"],)
        if lacking := unreadable([row], [*(f"hs_{way}" for way in ways), "hs_against"]):
            return Outcome.unjudged(f"{row['clip']}: {lacking}")
        checks += [
            inside(row, "HS against who moves", row["hs_against"], threshold),
            inside(row, "|VS|", strongest(row, "vs"), threshold),
            *(passes(row, f"hs_{way}", SIGNED[way][1], threshold) for way in ways),
        ]
    return checks
