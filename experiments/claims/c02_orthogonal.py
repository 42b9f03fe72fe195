"""C2. Orthogonal system below T."""

from __future__ import annotations

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import SHADES, SIGNED, Rows, outcome_inside, rows_of, strongest
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge HS of vertical translations, and VS of horizontal ones."""
    worst = {row["clip"]: strongest(row, "vs" if "hs" in SIGNED[row["motion"]][0] else "hs") for row in rows_of(rows)}
    return outcome_inside(worst, threshold, "the orthogonal system")


CLAIM = ClipClaim(
    id="C2",
    title="Orthogonal system below T",
    says="the orthogonal system stays inside +-T during translation",
    source="simu-clean, simu-clean-dth, simu-clean-dtv",
    conditions={"motion": tuple(SIGNED), "shade": SHADES},
    of_every_clip=True,
    silent_passes=True,
    judge=judge,
)
