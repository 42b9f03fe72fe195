"""Claims C5 to C11 along the speed of the background: up to which speed each holds, and what breaks it.

The paper's -8 px/s is 0.27 px a frame at 30 frames per second: a background that hardly moves. Each claim is judged
here by its own judge at every speed, one at a time, in the direction that its words name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

from experiments.bench.clips.claims import ClipClaim, find
from experiments.bench.clips.judging import Rows, levels, outcome_of, rises, rows_of
from experiments.bench.judging.count import Reason
from experiments.bench.judging.verdict import Outcome

GREYS = (0.0, 255.0)
"""Of the objects of C6 and C7: a dark and a light one."""
SIGN: Mapping[str, float] = {"C5": 1.0}
"""Which way the background shifts in a claim's words, where it is rightward; otherwise it is leftward."""
NOTES: Mapping[str, str] = {"C7": ", without its comparison with the 2017 model"}
ASKED = ("C5", "C6", "C7", "C8", "C9", "C10", "C11")


def along_background(claim: str, speeds: Sequence[float]) -> ClipClaim:
    """Return one of the paper's claims before clutter, asked at other speeds of the background.

    Parameters
    ----------
    claim
        Its id, ``C5`` to ``C11``.
    speeds
        Of the background, px/s, without sign: C5 is about backgrounds that shift rightward, the others leftward.

    Returns
    -------
    ClipClaim
        A claim of our own, not the paper's: ``C5-background``. It holds if the paper's does at every speed. What was
        measured says at which it holds, and what decided at the lowest at which it fails.

    Raises
    ------
    ValueError
        The claim names no speed of the background, or there are no speeds, or one that is not above 0.

    Examples
    --------
    >>> from experiments import along_background
    >>> along_background("C6", (8.0, 300.0)).id
    'C6-background'
    """
    if claim not in ASKED:
        raise ValueError(f"along_background: claim={claim!r}: legal is {', '.join(ASKED)}")
    if not speeds or not all(speed > 0.0 for speed in speeds):
        raise ValueError(f"along_background: speeds={tuple(speeds)}: legal are numbers above 0, one or more")
    paper = find(claim)
    sign = SIGN.get(claim, -1.0)
    conditions = {**paper.conditions, "background_speed": tuple(sign * speed for speed in speeds)}
    if claim == "C6":
        conditions["speed"] = (120.0,)
    if claim in ("C6", "C7"):
        conditions["grey"] = GREYS
    if claim != "C11":
        conditions["object"] = ("present",)
    told = ", ".join(f"{speed:g}" for speed in speeds)
    return ClipClaim(
        id=f"{claim}-background",
        says=f"{claim} before a background that shifts at each of {told} px/s{NOTES.get(claim, '')}",
        source=paper.source,
        judge=partial(_at_every_speed, c7_rises if claim == "C7" else paper.judge),
        models=paper.models,
        conditions=conditions,
    )


def c7_rises(rows: Rows, threshold: float) -> Outcome:
    """The first half of C7, which one speed of the background can answer: peak HS rises with the object's speed."""
    own = rows_of(rows)
    checks = [
        check for grey in levels(own, "grey") for check in rises(rows_of(own, grey=grey), threshold, f"grey {grey:g}")
    ]
    return outcome_of(checks, "", "", len(own))


def _at_every_speed(judge: Callable[[Rows, float], Outcome], rows: Rows, threshold: float) -> Outcome:
    found = {
        speed / rows[0]["fps"]: judge([row for row in rows if abs(row["background_speed"]) == speed], threshold)
        for speed in sorted({abs(row["background_speed"]) for row in rows})
    }
    at = {
        verdict: [f"{speed:.2g}" for speed, each in found.items() if each.verdict == verdict]
        for verdict in ("holds", "fails", "unknown constants", "not shown")
    }
    told = "; ".join(f"{verdict} at {', '.join(speeds)}" for verdict, speeds in at.items() if speeds)
    judged = {
        f"{speed:.2g} px a frame: {each.decided}": each
        for speed, each in found.items()
        if each.verdict in ("holds", "fails")
    }
    if not judged:
        reason: Reason = "unknown constants" if at["unknown constants"] else "not shown"
        return Outcome.unjudged(told, reason=reason, n=len(rows))
    breaks = next((text for text, each in judged.items() if each.verdict == "fails"), "")
    concluded = Outcome(
        "fails" if breaks else "holds",
        f"px a frame: {told}" + (f"; breaks first at {breaks}" if breaks else ""),
        f"{len(at['holds'])} of {len(found)} speeds",
        len(rows),
        breaks or next(iter(judged)),
        len(rows),
        checks=tuple(check for each in judged.values() for check in each.checks),
    )
    if breaks:
        return concluded
    if at["unknown constants"]:
        return replace(concluded, verdict="unknown constants", decided="")
    return concluded.withheld(f"not judged at {', '.join(at['not shown'])}") if at["not shown"] else concluded
