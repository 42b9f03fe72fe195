"""C8. VS below T over backgrounds."""

from __future__ import annotations

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import BACKGROUNDS, CROSSING, SHADES, Rows, largest, outcome_of, rows_of, strongest
from experiments.bench.stats.checks import Check
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge VS to either side: its trough as well as its peak."""
    worst = {row["clip"]: strongest(row, "vs") for row in rows_of(rows)}
    checks = [
        Check(f"{clip}: |VS| up to {value:.3f}", value, threshold, "below", scale=threshold,
              asks=f"below T = {threshold:g}")
        for clip, value in worst.items()
    ]  # fmt: skip
    clip = max(worst, key=lambda name: worst[name])
    measured = f"|VS| up to {worst[clip]:.3f} ({clip}) in {len(worst)} clips (T = {threshold:g})"
    return outcome_of(checks, measured, largest(worst, threshold), len(worst))


CLAIM = ClipClaim(
    id="C8",
    title="VS below T over backgrounds",
    says="peak VS stays below T at all 15 combinations, dark and light",
    source="simu-nature-depth, simu-nature-trans, simu-sys-speed",
    conditions={**CROSSING, "speed": (40.0, 80.0, 120.0), "background_speed": BACKGROUNDS, "shade": SHADES},
    of_every_clip=True,
    silent_passes=True,
    mechanism=(
        "background",
        "potentials at background speeds from 0.07 to 10 px a frame, and where the claim breaks",
    ),
    judge=judge,
)
