"""C9. Peak rises with speed, each grey."""

from __future__ import annotations

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import (
    CONTRAST_GRID,
    LEAST_GREYS,
    Rows,
    levels,
    outcome_of,
    peaks_by_speed,
    rises,
    rows_of,
    rows_with_object,
)
from experiments.bench.stats.checks import Check
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge every step of speed."""
    of_dsnn = rows_with_object(rows)
    texts, good = [], 0
    checks: list[Check] = []
    greys = levels(of_dsnn, "grey")
    for grey in greys:
        series = rows_of(of_dsnn, grey=grey)
        steps = rises(series, threshold, f"grey {grey:g}")
        good += all(check.passes for check in steps)
        checks += steps
        texts.append(f"{grey:g}: {', '.join(f'{peak:.3f}' for peak in peaks_by_speed(series).values())}")
    measured = f"peak HS by speed, of grey {'; '.join(texts)}"
    return outcome_of(checks, measured, f"{good} of {len(greys)} greys rise throughout", len(of_dsnn))


CLAIM = ClipClaim(
    id="C9",
    title="Peak rises with speed, each grey",
    says="peak HS rises with speed for every grey level",
    source="simu-sys-grayscale-mp, simu-sys-grayscale",
    conditions=CONTRAST_GRID,
    least_greys=LEAST_GREYS,
    cause="A faster object peaks over other leaves, whose grey sets its contrast; the seed decides.",
    tried=(
        "It fails at steps of the speed between 60 and 120 px/s, in most of these replicates for several greys "
        "at the same step, and not at the same step in all of them. So the ground decides: a faster object "
        "reaches its peak over other leaves, whose grey sets its contrast, as in C6. From 40 to 60 px/s the "
        "peak rises in every replicate."
    ),
    mechanism=(
        "background",
        "potentials at background speeds from 0.07 to 10 px a frame, and where the claim breaks",
    ),
    judge=judge,
)
