"""C1. HS and VS follow the direction."""

from __future__ import annotations

from typing import Literal

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import SHADES, SIGNED, Rows, outcome_of, rows_of
from experiments.bench.stats.checks import Check
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge that every translation passes the threshold of its own direction."""
    texts, checks = [], []
    for row in rows_of(rows):
        name, sign = SIGNED[row["motion"]]
        text, bound = f"{row['clip']} {row[name]:+.3f}", sign * threshold
        needs: Literal["above", "below"] = "above" if sign > 0 else "below"
        checks.append(Check(text, row[name], bound, needs, scale=threshold, asks=f"to pass {bound:+g}"))
        texts.append(text)
    passing = sum(check.passes for check in checks)
    measured = f"{', '.join(texts)} (T = {threshold:g})"
    return outcome_of(checks, measured, f"{passing} of {len(checks)} clips", len(checks))


CLAIM = ClipClaim(
    id="C1",
    title="HS and VS follow the direction",
    says="right/down give positive HS/VS past +T, left/up negative past -T, dark and light alike",
    source="simu-clean, simu-clean-dth, simu-clean-dtv",
    conditions={"motion": tuple(SIGNED), "shade": SHADES},
    of_every_clip=True,
    judge=judge,
)
