"""C10. Peak rises with contrast."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import CONTRAST_GRID, LEAST_GREYS, Rows, levels, outcome_of, rows_of, shown
from experiments.bench.judging.checks import Check
from experiments.bench.judging.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge means over speeds; the background's mean is that of the rows that the object passes."""
    of_dsnn = shown(rows)
    greys = levels(of_dsnn, "grey")
    mean = {grey: float(np.mean([row["peak_hs"] for row in rows_of(of_dsnn, grey=grey)])) for grey in greys}
    ground = float(np.mean([row["background_mean"] for row in of_dsnn]))
    nearest = min(greys, key=lambda grey: abs(grey - ground))
    if nearest in (greys[0], greys[-1]):
        return Outcome.unjudged(f"needs greys on both sides of the background's mean, {ground:.0f}")
    checks = []
    for low, high in pairwise(greys):
        more, less = (low, high) if high <= nearest else (high, low)
        text, asks = f"mean peak HS {mean[more]:.3f} at grey {more:g}", f"more than at {less:g}: {mean[less]:.3f}"
        checks.append(Check(text, mean[more], mean[less], scale=threshold, asks=asks))
    measured = (
        f"mean peak HS {', '.join(f'{mean[grey]:.3f} at grey {grey:g}' for grey in greys)}; "
        f"the background's mean is {ground:.0f}, nearest {nearest:g}"
    )
    return outcome_of(checks, measured, f"lowest at grey {min(mean, key=lambda grey: mean[grey]):g}", len(of_dsnn))


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
