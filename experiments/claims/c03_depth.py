"""C3. Looming, receding: below T."""

from __future__ import annotations

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import SHADES, Rows, outcome_inside, rows_of, strongest_of_both
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge both systems, over the whole of each clip."""
    return outcome_inside(strongest_of_both(rows_of(rows)), threshold, "HS and VS")


CLAIM = ClipClaim(
    id="C3",
    title="Looming, receding: below T",
    says="HS and VS stay inside +-T for the whole of looming and receding, dark and light",
    source="simu-clean, simu-clean-dth, simu-clean-dtv",
    conditions={"motion": ("looming", "receding"), "shade": SHADES},
    of_every_clip=True,
    silent_passes=True,
    judge=judge,
)
