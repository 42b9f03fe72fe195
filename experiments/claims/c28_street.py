"""C28. Street: HS follows movers.

A street of our own rendering stands in for the paper's real footage. "HS passes T with the sign of each" is read so,
before any model was shown such a clip: while one is in view HS passes T with the sign of its direction, and does not
pass it with the other.
"""

from __future__ import annotations

from typing import Literal

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import SIGNED, Row, Rows, outcome_of, rows_of, stays_inside, strongest
from experiments.bench.stats.checks import Check
from experiments.bench.stats.numbers import unreadable
from experiments.bench.stats.verdict import Outcome

OPPOSITE = "opposite"
"""Of the column ``movers``: two in opposite directions, one after the other."""


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge that every mover is answered with its sign, and that what has no mover stays inside +-T."""
    texts, good = [], 0
    checks: list[Check] = []
    of_dsnn = rows_of(rows)
    for row in of_dsnn:
        text, of_clip = _alone(row, threshold) if row["object"] == "absent" else _crossed(row, threshold)
        if not of_clip:
            return Outcome.unjudged(text, n=len(of_dsnn))
        good += all(check.passes for check in of_clip)
        texts.append(text)
        checks += of_clip
    measured = f"{'; '.join(texts)} (T = {threshold:g})"
    return outcome_of(checks, measured, f"{good} of {len(of_dsnn)} clips", len(of_dsnn))


def _crossed(row: Row, threshold: float) -> tuple[str, list[Check]]:
    """Return what was measured of a clip with movers, and its checks: none where it has no number."""
    ways = ("rightward", "leftward") if row["movers"] == OPPOSITE else (row["motion"],)
    clip, names = row["clip"], [f"hs_{way}" for way in ways]
    lacking = unreadable([row], [*names, "hs_against"])
    if lacking:
        return f"{clip}: {lacking}", []
    vs, against = strongest(row, "vs"), row["hs_against"]
    checks = [
        stays_inside(f"{clip}: HS up to {against:.3f} against who moves", against, threshold),
        stays_inside(f"{clip}: |VS| up to {vs:.3f}", vs, threshold),
    ]
    for way, name in zip(ways, names, strict=True):
        sign = SIGNED[way][1]
        side: Literal["above", "below"] = "above" if sign > 0 else "below"
        text, bound = f"{clip}: HS {row[name]:+.3f} while one moves {way}", sign * threshold
        checks.append(Check(text, row[name], bound, side, scale=threshold, asks=f"to pass {bound:+g}"))
    reached = " and ".join(f"{row[name]:+.3f}" for name in names)
    return f"{clip}: HS {reached}, against {against:.3f}, |VS| {vs:.3f}", checks


def _alone(row: Row, threshold: float) -> tuple[str, list[Check]]:
    """Return the same of a clip in which nobody moves."""
    values = {system: strongest(row, system) for system in ("hs", "vs")}
    checks = [
        stays_inside(f"{row['clip']}: |{system.upper()}| up to {value:.3f}", value, threshold)
        for system, value in values.items()
    ]
    return f"{row['clip']}: |HS| {values['hs']:.3f}, |VS| {values['vs']:.3f}", checks


CLAIM = ClipClaim(
    id="C28",
    title="Street: HS follows movers",
    says=(
        "an object among windblown foliage, two objects in opposite directions one after the other, a group in "
        "one direction: HS passes T with the sign of each, VS stays inside +-T; foliage alone: both stay inside"
    ),
    source="real-world and its text",
    conditions={"foliage": ("windblown",), "movers": ("one", OPPOSITE, "group"), "motion": ("rightward", "leftward")},
    of_every_clip=True,
    alone="foliage",
    cause=(
        "HS has the right sign but is too weak: walkers and cars are smaller and of less contrast than the "
        "paper's objects."
    ),
    tried=(
        "The street is of our own rendering, and sizes, speeds and greys were fixed before any model saw it: "
        "the paper names none. HS has the sign of everyone who crosses, VS and foliage alone stay inside, and "
        "without foliage a walker is answered alike. What lacks is strength: HS adds up products of changes "
        "along moving edges, so it grows with their length, their speed and the square of their contrast. The "
        "object of the paper's synthetic clips is 50 px wide and 160 grey levels from its ground, a walker's "
        "trunk 22 px and 110 levels, at 70 in place of 120 px/s. Leftward answers are weaker still: w_i = 0.9 "
        "leaves a tenth of the excitation, always rightward. Before a house front of grey 200 in place of 150, "
        "walkers 140 px high at the pace of 1.4 m/s pass rightward at every seed of five, groups both ways, and"
        " leftward walkers at all seeds but one; cars 80 px high still do not pass leftward. The defaults stay "
        "as they were fixed."
    ),
    judge=judge,
)
