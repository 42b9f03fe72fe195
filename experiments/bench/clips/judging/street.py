"""The judge of C28: a street of our own rendering, in place of the paper's real footage.

"HS passes T with the sign of each" is read so, before any model was shown such a clip: while one is in view HS passes T
with the sign of its direction, and does not pass it with the other.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from experiments.bench.clips.judging.paper import DSNN, SIGNED, Rows, strongest
from experiments.bench.judging.numbers import unreadable
from experiments.bench.judging.verdict import Check, Outcome, decide

OPPOSITE = "opposite"
"""Of the column ``movers``: two in opposite directions, one after the other."""


def c28(rows: Rows, threshold: float) -> Outcome:
    """Every mover is answered with its sign, VS stays inside +-T throughout, and so do both where nobody moves."""
    said, checks, good = [], [], 0
    own = [row for row in rows if row["model"] == DSNN]
    for row in own:
        words, made = _alone(row, threshold) if row["object"] == "absent" else _crossed(row, threshold)
        if not made:
            return Outcome("untested", words, n=len(own))
        good += all(check.passes for check in made)
        said.append(words)
        checks += made
    holds, decided = decide(checks)
    measured = f"{'; '.join(said)} (T = {threshold:g})"
    return Outcome(
        "holds" if holds else "fails", measured, f"{good} of {len(own)} clips", len(own), decided, len(own)
    )  # fmt: skip


def ways(row: Mapping[str, Any]) -> tuple[str, ...]:
    """The directions in which somebody moves in a clip."""
    return ("rightward", "leftward") if row["movers"] == OPPOSITE else (row["motion"],)


def _crossed(row: Mapping[str, Any], threshold: float) -> tuple[str, list[Check]]:
    """What was measured of a clip with movers, and its checks: none where it has no number."""
    clip, names = row["clip"], [f"hs_{way}" for way in ways(row)]
    lacking = unreadable([row], [*names, "hs_against"])
    if lacking:
        return f"{clip}: {lacking}", []
    vs = strongest(row, "vs")
    checks = [_inside(f"{clip}: HS up to {row['hs_against']:.3f} against who moves", row["hs_against"], threshold),
              _inside(f"{clip}: |VS| up to {vs:.3f}", vs, threshold)]  # fmt: skip
    for way, name in zip(ways(row), names, strict=True):
        sign = SIGNED[way][1]
        needs = f"{clip}: HS {row[name]:+.3f} while one moves {way} (needs to pass {sign * threshold:+g})"
        checks.append(Check(needs, (sign * row[name] - threshold) / threshold))
    reached = " and ".join(f"{row[name]:+.3f}" for name in names)
    return f"{clip}: HS {reached}, against {row['hs_against']:.3f}, |VS| {vs:.3f}", checks


def _alone(row: Mapping[str, Any], threshold: float) -> tuple[str, list[Check]]:
    """The same of a clip in which nobody moves."""
    found = {system: strongest(row, system) for system in ("hs", "vs")}
    checks = [
        _inside(f"{row['clip']}: |{system.upper()}| up to {value:.3f}", value, threshold)
        for system, value in found.items()
    ]
    return f"{row['clip']}: |HS| {found['hs']:.3f}, |VS| {found['vs']:.3f}", checks


def _inside(said: str, value: float, threshold: float) -> Check:
    needs = f"{said} (needs to stay inside T = {threshold:g})"
    return Check(needs, (threshold - value) / threshold, strict=False)
