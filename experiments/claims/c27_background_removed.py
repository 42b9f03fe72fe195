"""C27. DoG and FDSR remove background."""

from __future__ import annotations

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.equal_terms import MATCHED
from experiments.bench.clips.judging import BACKGROUNDS, DSNN, Rows, outcome_of, rows_of, strongest
from experiments.bench.stats.checks import Check
from experiments.bench.stats.verdict import Outcome

WITHOUT = ("dsnn:dog=false", "dsnn:fdsr=false")
"""The DSNN without the lamina's difference of Gaussians, and without the adaptation after it."""
LEAST_FACTOR = 2.0


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge each of |HS| and |VS|, without the one and without the other, in every clip of the background alone."""
    checks: list[Check] = []
    factors: dict[tuple[str, str], list[float]] = {(model, system): [] for model in WITHOUT for system in ("hs", "vs")}
    for whole in rows_of(rows):
        clip = whole["clip"]
        for (model, system), values in factors.items():
            kept, left = strongest(whole, system), strongest(rows_of(rows, model, clip=clip)[0], system)
            factor = left / kept if kept else float("nan")
            values.append(factor)
            text = f"{clip}: |{system.upper()}| {left:.4f} of {model}, {factor:.2f} times {kept:.4f}"
            checks.append(Check(text, factor, LEAST_FACTOR, "at least", asks=f"{LEAST_FACTOR:g} times or more"))
    measured = "; ".join(
        f"{model}: |{system.upper()}| {min(values):.3g} to {max(values):.3g} times"
        for (model, system), values in factors.items()
    )
    least = min(min(values) for values in factors.values())
    return outcome_of(checks, measured, f"at least {least:.3g} times", len(rows_of(rows)))


CLAIM = ClipClaim(
    id="C27",
    title="DoG and FDSR remove background",
    says=(
        "the DoG pre-filter and FDSR remove background: without either, the potentials to a shifting background"
        " alone are at least twice as large"
    ),
    source=(
        "simu-clean-dth and its text; motion-models; the text on ensembles and dynamic delays; simu-sys-grayscale (c)"
    ),
    models=frozenset({DSNN, *WITHOUT}),
    equal_terms={label: MATCHED[label] for label in WITHOUT},
    conditions={"object": ("absent",), "background_speed": BACKGROUNDS},
    of_every_clip=True,
    mechanism=(
        "background-alone",
        "the potentials without DoG and without FDSR",
    ),
    judge=judge,
)
