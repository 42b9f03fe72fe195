"""C10. Peak rises with contrast."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import (
    CONTRAST_GRID,
    LEAST_GREYS,
    Rows,
    levels,
    outcome_of,
    rows_of,
    rows_with_object,
)
from experiments.bench.stats.checks import Check, exceeds
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge at each speed by itself; the background's mean is that of the rows that the object passes."""
    of_dsnn = rows_with_object(rows)
    greys = levels(of_dsnn, "grey")
    ground = float(np.mean([row["background_mean"] for row in of_dsnn]))
    nearest = min(greys, key=lambda grey: abs(grey - ground))
    if nearest in (greys[0], greys[-1]):
        return Outcome.unjudged(f"needs greys on both sides of the background's mean, {ground:.0f}")
    checks: list[Check] = []
    texts, good = [], 0
    for speed in levels(of_dsnn, "speed"):
        peak = {grey: float(rows_of(of_dsnn, grey=grey, speed=speed)[0]["peak_hs"]) for grey in greys}
        steps = [
            exceeds(f"{speed:g} px/s: peak HS {peak[more]:.3f} at grey {more:g}", peak[more], peak[less],
                    f"at {less:g}", "potential", scale=threshold)
            for low, high in pairwise(greys)
            for more, less in [(low, high) if high <= nearest else (high, low)]
        ]  # fmt: skip
        good += all(check.passes for check in steps)
        checks += steps
        texts.append(f"{speed:g} px/s: {', '.join(f'{peak[grey]:.3f}' for grey in greys)}")
    measured = (
        f"peak HS at greys {', '.join(f'{grey:g}' for grey in greys)}, {'; '.join(texts)}; the background's mean is "
        f"{ground:.0f}, nearest {nearest:g}"
    )
    return outcome_of(checks, measured, f"{good} of {len(texts)} speeds", len(of_dsnn))


CLAIM = ClipClaim(
    id="C10",
    title="Peak rises with contrast",
    says="peak HS is lowest at the grey level nearest the background's mean, and rises with contrast on both sides",
    source="simu-sys-grayscale-mp, simu-sys-grayscale",
    conditions=CONTRAST_GRID,
    least_greys=LEAST_GREYS,
    mechanism=(
        "background",
        "potentials at background speeds from 0.07 to 10 px a frame, and where the claim breaks",
    ),
    judge=judge,
)
