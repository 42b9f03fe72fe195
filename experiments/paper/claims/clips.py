"""The paper's claims about clips, C1 to C11, C22 to C24 and C26 to C28. Their words are in ``claims.toml``.

The docstring of a judge says how the words are read where they leave room.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise, product
from typing import Any

import numpy as np

from experiments.declare.claim import DSNN, Claim, shipped as claim
from experiments.declare.outcome import MARGIN, Check, Needs, Outcome, decide, exceeds, unreadable
from experiments.judge.judge import EVERY, SHADES, SIGNED, Row, Rows
from experiments.paper.claims.robot import CONNECTIONS, FEWER, PER_CORRELATOR
from experiments.store.tables import group

EARLIER, EMD = "dsn2017", "emd"
LEAST_GREYS = 5
"""Grey levels that the claims about contrast need."""
MOST_OF_DRIVEN, LEAST_OF_OTHER = 0.05, 0.95
"""Shares of the response to one edge that C22 lets a blocked pathway leave: the edge that it drives, and the other."""

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
}
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


def rows_of(clips: Rows, model: str = DSNN, **fixed: Any) -> list[Row]:
    """Return the rows of a model in which columns have the ``fixed`` values, in the table's order."""
    return [row for row in clips if row["model"] == model and all(row[name] == fixed[name] for name in fixed)]


def matched(clips: Rows, *models: str) -> Iterator[tuple[Row, list[Row]]]:
    """Yield the DSNN's row of each clip, with those of the ``models`` in the same clip."""
    rows = {(row["model"], row["clip"]): row for row in clips}
    for whole in rows_of(clips):
        yield whole, [rows[model, whole["clip"]] for model in models]


def levels(clips: Rows, name: str) -> list[float]:
    """Return the values of a column, each once, from the lowest up."""
    return sorted({row[name] for row in clips} - {None})


def strongest(row: Row, *systems: str) -> float:
    """Return the largest absolute potential of ``hs``, ``vs``, or both, in a clip."""
    return float(max(max(row[f"peak_{system}"], -row[f"trough_{system}"]) for system in systems))


def share_of(part: float, whole: float) -> float:
    """Return ``part`` over ``whole``; NaN of nothing, which no check passes."""
    return part / whole if whole else float("nan")


def passes(row: Row, name: str, sign: float, threshold: float) -> Check:
    """Return the check that a clip's potential goes past T to the side of ``sign``."""
    side: Needs = "above" if sign > 0 else "below"
    return Check(f"{row['clip']}: {name} {row[name]:+.3f}", row[name], sign * threshold, side, scale=threshold)


def stays(row: Row, threshold: float, *systems: str, needs: Needs = "at most") -> Check:
    """Return the check that the strongest potential of a clip stays inside +-T, or has what it ``needs`` otherwise."""
    value, names = strongest(row, *systems), " and ".join(f"|{system.upper()}|" for system in systems)
    return Check(f"{row['clip']}: {row['model']} {names} {value:.3f}", value, threshold, needs, scale=threshold)


def more_hs(text: str, value: float, less: float, than: str, threshold: float) -> Check:
    """Return the check that a peak of HS is more than another."""
    return exceeds(f"{text} {value:.3f}", value, less, than, "potential", scale=threshold)


def rises(clips: Rows, threshold: float, *apart: str) -> list[Check]:
    """Return the checks of more peak HS at each speed than at the next lower one, for clips ``apart`` in columns."""
    checks = []
    shown = [row for row in clips if all(row[name] is not None for name in apart)]
    shown.sort(key=lambda row: [row[name] for name in (*apart, "speed")])
    for values, rows in group(shown, *apart).items():
        where = ", ".join(f"{name} {value:g}" for name, value in zip(apart, values, strict=True))
        for slow, fast in pairwise(rows):
            text, than = f"{where}, {fast['speed']:g} px/s: peak HS", f"at {slow['speed']:g}"
            checks.append(more_hs(text, fast["peak_hs"], slow["peak_hs"], than, threshold))
    return checks


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
    (alone, decided), (rest, by) = decide(of_dsnn), decide(of_other)
    if not alone:
        return replace(whole, verdict="fails", decided=decided)
    why = (
        f"the DSNN's half holds: {decided}; the rest hangs on constants of {model} that are not known, and with those "
        f"assumed {'holds' if rest else 'fails'}: {by}"
    )
    return replace(whole, verdict="unknown constants", decided=why)


@claim("C1", conditions={"motion": tuple(SIGNED), "shade": SHADES}, of_each=True)
def c1(clips: Rows, threshold: float) -> list[Check]:
    """Judge that every translation passes the threshold of its own direction."""
    return [passes(row, *SIGNED[row["motion"]], threshold) for row in rows_of(clips)]


@claim("C2", conditions={"motion": tuple(SIGNED), "shade": SHADES}, of_each=True, silent_passes=True)
def c2(clips: Rows, threshold: float) -> list[Check]:
    """Judge HS of vertical translations, and VS of horizontal ones."""
    return [stays(row, threshold, "vs" if row["motion"] in WAYS else "hs") for row in rows_of(clips)]


@claim("C3", conditions={"motion": ("looming", "receding"), "shade": SHADES}, of_each=True, silent_passes=True)
def c3(clips: Rows, threshold: float) -> list[Check]:
    """Judge both systems, over the whole of each clip."""
    return [stays(row, threshold, "hs", "vs") for row in rows_of(clips)]


HALF = (0.4, 0.6)
"""Share of the intact peak that either pathway alone may leave."""
SUM_TOLERANCE = 1e-3


@claim("C4", models={DSNN, *BLOCKED}, conditions={"motion": tuple(SIGNED)}, of_each=True)
def c4(clips: Rows, threshold: float) -> list[Check]:
    """Judge that each pathway alone leaves its share of the intact peak, and that both add up to the whole."""
    checks = []
    for whole, parts in matched(clips, *BLOCKED):
        clip, name = whole["clip"], SIGNED[whole["motion"]][0]
        for part in parts:
            share = share_of(part[name], whole[name])
            text = f"{clip}: {part['model']} leaves {share:.1%}"
            asks = f"{HALF[0]:.0%} to {HALF[1]:.0%}"
            checks.append(Check(text, share, HALF, "within", scale=HALF[1] - HALF[0], asks=asks))
        rest = abs(sum(part[name] for part in parts) - whole[name])
        adds = f"{clip}: ON and OFF alone differ from the whole by {rest:.1e}"
        checks.append(Check(adds, rest, SUM_TOLERANCE, "below", scale=SUM_TOLERANCE))
    return checks


@claim("C5", **against(EARLIER), conditions={"motion": ("looming", "receding"), "background_speed": (8.0,)},
       of_each=True, silent_passes=True)  # fmt: skip
def c5(clips: Rows, threshold: float) -> Outcome:
    """Judge both systems of the DSNN in every clip; of the 2017 model one of both passes T in every clip."""
    checks = [stays(row, threshold, "hs", "vs") for row in rows_of(clips)]
    of_other = [stays(row, threshold, "hs", "vs", needs="above") for row in rows_of(clips, EARLIER)]
    return compared(checks, of_other, EARLIER)


@claim("C6", **against(EARLIER), conditions={**CROSSING, "background_speed": (-8.0,)}, of_each=True)
def c6(clips: Rows, threshold: float) -> Outcome:
    """Judge HS and VS of the DSNN in every clip; of the 2017 model VS passes T in every clip."""
    rows = rows_of(clips)
    checks = [passes(row, "peak_hs", 1.0, threshold) for row in rows]
    checks += [stays(row, threshold, "vs") for row in rows]
    of_other = [stays(row, threshold, "vs", needs="above") for row in rows_of(clips, EARLIER)]
    return compared(checks, of_other, EARLIER)


@claim(
    "C7", **against(EARLIER),
    conditions={**CROSSING, "speed": (40.0, 80.0, 120.0), "background_speed": BACKGROUNDS, "grey": EVERY},
)  # fmt: skip
def c7(clips: Rows, threshold: float) -> Outcome:
    """Judge every step of speed, and the spread over background speeds: largest peak less smallest, meaned."""
    spreads = {model: _spread(rows_of(clips, model)) for model in (DSNN, EARLIER)}
    text = f"over background speeds {EARLIER}'s peak HS varies by"
    more = more_hs(text, spreads[EARLIER], spreads[DSNN], "of the DSNN", threshold)
    return compared(rises(rows_of(clips), threshold, "grey", "background_speed"), [more], EARLIER)


def _spread(clips: Rows) -> float:
    """Return the spread of peak HS over what else differs than object and speed, meaned over these."""
    alike = group((row for row in clips if None not in (row["grey"], row["speed"])), "grey", "speed").values()
    return float(np.mean([np.ptp([row["peak_hs"] for row in rows]) for rows in alike]))


@claim(
    "C8", of_each=True, silent_passes=True,
    conditions={**CROSSING, "speed": (40.0, 80.0, 120.0), "background_speed": BACKGROUNDS, "shade": SHADES},
)  # fmt: skip
def c8(clips: Rows, threshold: float) -> list[Check]:
    """Judge VS to either side: its trough as well as its peak."""
    return [stays(row, threshold, "vs", needs="below") for row in rows_of(clips)]


@claim("C9", conditions=CONTRAST_GRID, least_greys=LEAST_GREYS)
def c9(clips: Rows, threshold: float) -> list[Check]:
    """Judge every step of speed."""
    return rises(rows_of(clips, object="present"), threshold, "grey")


@claim("C10", conditions=CONTRAST_GRID, least_greys=LEAST_GREYS)
def c10(clips: Rows, threshold: float) -> list[Check] | Outcome:
    """Judge at each speed by itself; the background's mean is that of the rows that the object passes."""
    shown = rows_of(clips, object="present")
    greys, ground = levels(shown, "grey"), float(np.mean(np.array([row["background_mean"] for row in shown], float)))
    nearest = min(greys, key=lambda grey: abs(grey - ground))
    if nearest in (greys[0], greys[-1]):
        return Outcome.unjudged(f"needs greys on both sides of the background's mean, {ground:.0f}")
    checks = []
    for speed in levels(shown, "speed"):
        peak = {row["grey"]: row["peak_hs"] for row in reversed(rows_of(shown, speed=speed))}  # of two the first
        for low, high in pairwise(greys):
            more, less = (low, high) if high <= nearest else (high, low)
            text = f"{speed:g} px/s, grey {more:g}: peak HS"
            checks.append(more_hs(text, peak[more], peak[less], f"at {less:g}", threshold))
    return checks


@claim("C11", **against(EMD), conditions=CONTRAST_GRID, alone="background_speed")
def c11(clips: Rows, threshold: float) -> Outcome:
    """Judge whether a model's weakest answer to a translation beats every answer to a background alone.

    Answers are the largest abs(HS) of a clip; of the background-only clips, of all there are. The EMD model is asked
    about 40 and 60 px/s, the DSNN about all speeds: the paper says "even at the lowest velocity".
    """
    checks = {}
    for model, slow in ((EMD, (40.0, 60.0)), (DSNN, None)):
        behind = max(strongest(row, "hs") for row in rows_of(clips, model, object="absent"))
        shown = [row for row in rows_of(clips, model, object="present") if slow is None or row["speed"] in slow]
        text, weakest = f"{model}: weakest |HS| to an object", min(strongest(row, "hs") for row in shown)
        checks[model] = replace(more_hs(text, weakest, behind, "without", threshold), scale=max(behind, threshold))
    not_more = replace(checks[EMD], needs="below", asks=f"below {MARGIN['potential']:+g}")
    return compared([checks[DSNN]], [not_more], EMD)


@claim("C22", models={DSNN, *BLOCKED}, of_each=True,
       conditions={"stimulus": ("edge",), "motion": WAYS, "polarity": ("on", "off")})  # fmt: skip
def c22(clips: Rows, threshold: float) -> list[Check]:
    """Judge one edge in view: what each blocked pathway leaves of the largest |HS|.

    An OFF edge is the leading one of a dark object and the trailing one of a light object, an ON edge the reverse.
    """
    checks = []
    for whole, (on_blocked, off_blocked) in matched(clips, *BLOCKED):
        driven, other = (on_blocked, off_blocked) if whole["polarity"] == "on" else (off_blocked, on_blocked)
        intact = strongest(whole, "hs")
        bounds: tuple[tuple[float, Needs], ...] = ((MOST_OF_DRIVEN, "below"), (LEAST_OF_OTHER, "above"))
        for row, (bound, side) in zip((driven, other), bounds, strict=True):
            left = share_of(strongest(row, "hs"), intact)
            text = f"{whole['clip']}: {row['model']} leaves {left:.1%} of |HS| {intact:.3f}"
            checks.append(Check(text, left, bound, side, asks=f"{side} {bound:.0%}"))
    return checks


SAME, OPPOSITE = ("on-on", "off-off"), ("on-off", "off-on")
"""Two steps of one sign, and of opposite signs."""
MOST_OF_OPPOSITE = 0.1


@claim("C23", conditions={"stimulus": ("apparent",), "motion": WAYS, "polarity": (*SAME, *OPPOSITE)})
def c23(clips: Rows, threshold: float) -> list[Check] | Outcome:
    """Judge the strongest HS: of one sign its direction, of opposite signs its share of that.

    The share is of the weaker of both answers to steps of one sign, in the same direction with the same delay.
    """
    clips = sorted(clips, key=lambda row: row["clip"])  # those of one delay have one place in every pair
    hs = {
        (motion, pair): [
            max((row["peak_hs"], row["trough_hs"]), key=abs) for row in rows_of(clips, motion=motion, polarity=pair)
        ]
        for motion in WAYS
        for pair in (*SAME, *OPPOSITE)
    }
    if len({len(answers) for answers in hs.values()}) > 1:
        return Outcome.unjudged("needs as many clips of every pair of steps in both directions")
    checks = []
    for (motion, pair), values in hs.items():
        for index, value in enumerate(values):
            if pair in SAME:
                side: Needs = "above" if motion == "rightward" else "below"
                checks.append(Check(f"{motion} {pair}: strongest HS {value:+.3f}", value, 0.0, side, scale=threshold))
            else:
                least = min(abs(hs[motion, same][index]) for same in SAME)
                share = share_of(abs(value), least)
                text = f"{motion} {pair}: |HS| {abs(value):.3f}, {share:.0%} of {least:.3f} for one sign"
                checks.append(Check(text, share, MOST_OF_OPPOSITE, "below", asks=f"below {MOST_OF_OPPOSITE:.0%}"))
    return checks


@claim("C24", models={DSNN, *FEWER}, equal_terms={CONNECTIONS[n]: PER_CORRELATOR[n] for n in (1, 2)},
       conditions=CONTRAST_GRID, least_greys=LEAST_GREYS)  # fmt: skip
def c24(clips: Rows, threshold: float) -> list[Check]:
    """Judge the off-line part: every clip of the contrast grid."""
    checks = []
    for model in FEWER:
        past = [0, 0]
        for whole, (fewer,) in matched([row for row in clips if row["object"] == "present"], model):
            peak, less = whole["peak_hs"], fewer["peak_hs"]
            checks.append(more_hs(f"{whole['clip']}: peak HS", peak, less, f"of {model}", threshold))
            past = [past[0] + (peak > threshold), past[1] + (less > threshold)]
        asks = f"more than {past[1]} of {model}"
        checks.append(Check(f"passes T in {past[0]} clips", past[0], past[1], unit="clips", asks=asks))
    return checks


@claim("C26", **against(EMD), conditions=CONTRAST_GRID, least_greys=LEAST_GREYS)
def c26(clips: Rows, threshold: float) -> Outcome:
    """Judge every step of speed, or that not every one rises.

    The DSNN's peaks are of HS, as in C9; the EMD's of |HS|, as in C11: the background drives its HS the other way.
    """
    of_emd = [{**row, "peak_hs": strongest(row, "hs")} for row in rows_of(clips, EMD, object="present")]
    of_dsnn = rows_of(clips, object="present")
    first, *middle, last = levels(of_dsnn, "grey")
    of_other = rises([row for row in of_emd if row["grey"] in (first, last)], threshold, "grey")
    for grey in middle:
        least = min(step.reading for step in rises(rows_of(of_emd, EMD, grey=grey), threshold, "grey"))
        text = f"{EMD}, grey {grey:g}: least step of the peak of |HS| with speed {least:+.4f}"
        of_other.append(Check(text, least, MARGIN["potential"], "below", scale=threshold))
    return compared(rises(of_dsnn, threshold, "grey"), of_other, EMD)


LEAST_FACTOR = 2.0


@claim("C27", **against(*WITHOUT), conditions={"object": ("absent",), "background_speed": BACKGROUNDS}, of_each=True)
def c27(clips: Rows, threshold: float) -> list[Check]:
    """Judge each of |HS| and |VS|, without the one and without the other, in every clip of the background alone."""
    checks = []
    for whole, others in matched(clips, *WITHOUT):
        for other, system in product(others, ("hs", "vs")):
            intact, left = strongest(whole, system), strongest(other, system)
            where = f"{whole['clip']}: |{system.upper()}| {left:.4f} of {other['model']}"
            factor = share_of(left, intact)
            checks.append(Check(f"{where}, {factor:.2f} times {intact:.4f}", factor, LEAST_FACTOR, "at least"))
    return checks


@claim(
    "C28", of_each=True, alone="foliage",
    conditions={"foliage": ("windblown",), "movers": ("one", "opposite", "group"), "motion": WAYS},
)  # fmt: skip
def c28(clips: Rows, threshold: float) -> list[Check] | Outcome:
    """Judge that every mover is answered with its sign, and that what has no mover stays inside +-T.

    A street of our own rendering stands in for the paper's real footage. "HS passes T with the sign of each" was read
    before any model was shown such a clip: while one is in view HS passes T with the sign of its direction, and does
    not pass it with the other.
    """
    checks = []
    for row in rows_of(clips):
        checks.append(stays(row, threshold, "vs"))
        if row["object"] == "absent":
            checks.append(stays(row, threshold, "hs"))
            continue
        ways = WAYS if row["movers"] == "opposite" else (row["motion"],)
        if lacking := unreadable([row], [*(f"hs_{way}" for way in ways), "hs_against"]):
            return Outcome.unjudged(f"{row['clip']}: {lacking}")
        text = f"{row['clip']}: HS against who moves {row['hs_against']:.3f}"
        checks.append(Check(text, row["hs_against"], threshold, "at most", scale=threshold))
        checks += [passes(row, f"hs_{way}", SIGNED[way][1], threshold) for way in ways]
    return checks


def with_model(claim: Claim, other: str, label: str) -> Claim:
    """Return a claim in which the model called ``label`` takes the place of the ``other`` that it names."""

    def judge(clips: Rows, threshold: float) -> Any:
        return claim.judge([{**row, "model": other} if row["model"] == label else row for row in clips], threshold)

    return replace(claim, models=claim.models - {other} | {label}, judge=judge)
