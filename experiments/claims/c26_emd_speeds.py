"""C26. EMD ranks speeds at extremes only."""

from __future__ import annotations

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.equal_terms import MATCHED
from experiments.bench.clips.judging import (
    CONTRAST_GRID,
    DSNN,
    EMD,
    LEAST_GREYS,
    Rows,
    compared,
    levels,
    rises,
    rows_of,
    rows_with_object,
    strongest,
)
from experiments.bench.stats.checks import MARGIN, Check
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge every step of speed, or that not every one rises.

    The DSNN's peaks are of HS, as in C9; the EMD's of |HS|, as in C11: the background drives its HS the other way.
    """
    greys = levels(rows_with_object(rows), "grey")
    peaks: dict[str, Rows] = {
        DSNN: rows_with_object(rows),
        EMD: [{**row, "peak_hs": strongest(row, "hs")} for row in rows_with_object(rows, EMD)],
    }
    checks: dict[str, list[Check]] = {DSNN: [], EMD: []}
    rising, texts = {}, []
    for model, of_model in peaks.items():
        of = ", of |HS|" if model == EMD else ""
        series = {
            grey: rises(rows_of(of_model, model, grey=grey), threshold, f"{model}, grey {grey:g}{of}") for grey in greys
        }
        rising[model] = [grey for grey, steps in series.items() if all(step.passes for step in steps)]
        for grey, steps in series.items():
            if model == DSNN or grey in (greys[0], greys[-1]):
                checks[model] += steps
            else:
                least = min(step.reading for step in steps)
                text = f"{model}, grey {grey:g}: least step of the peak with speed {least:+.4f}"
                bound = MARGIN["potential"]
                checks[model].append(Check(text, least, bound, "below", scale=threshold, asks=f"below {bound:+g}"))
        ranges = ", ".join(f"{grey:g}: {_span(rows_of(of_model, model, grey=grey))}" for grey in greys)
        throughout = ", ".join(f"{grey:g}" for grey in rising[model]) or "none"
        texts.append(
            f"{model}'s peak rises at every step of speed for greys {throughout} (from slowest to fastest {ranges})"
        )
    effect = f"{len(rising[DSNN])} and {len(rising[EMD])} of {len(greys)} greys"
    return compared(checks[DSNN], checks[EMD], EMD, "; ".join(texts), effect, len(rows_with_object(rows)))


def _span(rows: Rows) -> str:
    """Return the peaks at the lowest speed and at the highest, in words."""
    slow, *_, fast = sorted(rows, key=lambda row: row["speed"])
    return f"{slow['peak_hs']:.3f} to {fast['peak_hs']:.3f}"


CLAIM = ClipClaim(
    id="C26",
    title="EMD ranks speeds at extremes only",
    says="the EMD's peak rises with speed for the darkest and lightest object only; the DSNN's for all five greys",
    source=(
        "simu-clean-dth and its text; motion-models; the text on ensembles and dynamic delays; simu-sys-grayscale (c)"
    ),
    models=frozenset({DSNN, EMD}),
    equal_terms={EMD: MATCHED[EMD]},
    of_dsnn="the DSNN's peak rises with speed for all five greys",
    conditions=CONTRAST_GRID,
    least_greys=LEAST_GREYS,
    cause=(
        "The EMD's constants are not published, and the comparison hangs on them; the DSNN's part fails where C9 does."
    ),
    tried=(
        "Its part about the DSNN is C9, and fails where that does. The part about the EMD needs Iida's "
        "constants, which could not be read. With those assumed the shifting background, which fills the field,"
        " drives its HS to the left in every clip, and an object adds little to it. With detectors spaced 4 or "
        "8 px apart the object stands out, and then the peak mostly rises for more greys than the darkest and "
        "the lightest; the experiment constants-emd shows it with others."
    ),
    mechanism=(
        "constants-emd",
        "what the EMD answers with other constants",
    ),
    judge=judge,
)
