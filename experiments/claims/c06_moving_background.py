"""C6. Object over a moving background."""

from __future__ import annotations

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.equal_terms import MATCHED
from experiments.bench.clips.judging import (
    CROSSING,
    DSNN,
    EARLIER,
    Rows,
    all_inside,
    all_pass,
    compared,
    rows_of,
    strongest,
)
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge HS and VS of the DSNN in every clip; of the 2017 model VS passes T in every clip."""
    hs = {row["clip"]: float(row["peak_hs"]) for row in rows_of(rows)}
    vs = {row["clip"]: strongest(row, "vs") for row in rows_of(rows)}
    earlier = {row["clip"]: strongest(row, "vs") for row in rows_of(rows, EARLIER)}
    checks = [*all_pass(hs, threshold, "HS"), *all_inside(vs, threshold, "VS")]
    of_other = all_pass(earlier, threshold, f"{EARLIER} VS")
    good = sum(hs[clip] > threshold >= vs[clip] for clip in hs)
    texts = ", ".join(f"{clip}: HS {hs[clip]:.3f}, VS up to {vs[clip]:.3f}" for clip in hs)
    measured = f"{texts}; {EARLIER} VS {min(earlier.values()):.2f} or more (T = {threshold:g})"
    return compared(checks, of_other, EARLIER, measured, f"{good} of {len(hs)} clips", len(hs))


CLAIM = ClipClaim(
    id="C6",
    title="Object over a moving background",
    says=(
        "right translation over a background shifting at -8: HS > T, VS inside +-T; in the 2017 DSN model VS "
        "passes T too"
    ),
    source="simu-nature-depth, simu-nature-trans, simu-sys-speed",
    models=frozenset({DSNN, EARLIER}),
    equal_terms={EARLIER: MATCHED[EARLIER]},
    of_dsnn="right translation over a background shifting at -8: HS > T, VS inside +-T",
    conditions={**CROSSING, "background_speed": (-8.0,)},
    of_every_clip=True,
    cause="The black object's contrast depends on how dark the scene is that it passes, which the seed decides.",
    tried=(
        "The black object's peak depends on how dark the scene is that it passes, which the seed decides: before "
        "dark leaves or a dark house its contrast halves. No object size, grey or image was looked for to make it "
        "pass everywhere."
    ),
    mechanism=(
        "background",
        "potentials at background speeds from 0.07 to 10 px a frame, and where the claim breaks",
    ),
    judge=judge,
)
