"""C5. Depth, moving background: below T."""

from __future__ import annotations

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.equal_terms import MATCHED
from experiments.bench.clips.judging import (
    DSNN,
    EARLIER,
    Rows,
    all_inside,
    all_pass,
    compared,
    largest,
    rows_of,
    strongest_of_both,
    up_to,
)
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge both systems of the DSNN in every clip; of the 2017 model one of both passes T in every clip."""
    worst, earlier = strongest_of_both(rows_of(rows)), strongest_of_both(rows_of(rows, EARLIER))
    checks = all_inside(worst, threshold, "HS and VS")
    of_other = all_pass(earlier, threshold, f"{EARLIER} HS or VS")
    measured = f"{up_to(worst, threshold, 'HS and VS')}; {EARLIER} {min(earlier.values()):.2f} or more"
    return compared(checks, of_other, EARLIER, measured, largest(worst, threshold), len(worst))


CLAIM = ClipClaim(
    id="C5",
    title="Depth, moving background: below T",
    says="looming and receding over a background shifting at +8: HS and VS inside +-T; the 2017 DSN model passes T",
    source="simu-nature-depth, simu-nature-trans, simu-sys-speed",
    models=frozenset({DSNN, EARLIER}),
    equal_terms={EARLIER: MATCHED[EARLIER]},
    of_dsnn="looming and receding over a background shifting at +8: HS and VS inside +-T",
    conditions={"motion": ("looming", "receding"), "background_speed": (8.0,)},
    of_every_clip=True,
    silent_passes=True,
    mechanism=(
        "background",
        "potentials at background speeds from 0.07 to 10 px a frame, and where the claim breaks",
    ),
    judge=judge,
)
