"""C11. Slow objects told from background."""

from __future__ import annotations

import numpy as np

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.equal_terms import MATCHED
from experiments.bench.clips.judging import (
    CONTRAST_GRID,
    DSNN,
    EMD,
    Rows,
    compared,
    rows_of,
    rows_with_object,
    strongest,
)
from experiments.bench.stats.checks import MARGIN, does_not_exceed, exceeds
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge whether a model's weakest answer to a translation beats every answer to a background alone.

    Answers are the largest abs(HS) of a clip; of the background-only clips, of all there are. The EMD model is asked
    about 40 and 60 px/s, the DSNN about all speeds: the paper says "even at the lowest velocity".
    """
    texts, checks = [], {}
    for model, speeds, should in ((EMD, (40.0, 60.0), False), (DSNN, None, True)):
        behind = max(strongest(row, "hs") for row in rows_of(rows, model, object="absent"))
        moved = [
            strongest(row, "hs") for row in rows_with_object(rows, model) if speeds is None or row["speed"] in speeds
        ]
        above = float(np.mean([value - behind >= MARGIN["potential"] for value in moved]))
        reach = f"{min(moved):.3f} to {max(moved):.3f} with an object"
        texts.append(f"{model}: {reach}, up to {behind:.3f} without ({above:.0%} above)")
        weakest = f"{model}: weakest |HS| to an object {min(moved):.3f}"
        check = exceeds if should else does_not_exceed
        checks[model] = [check(weakest, min(moved), behind, "without", "potential", scale=max(behind, threshold))]
    measured = f"|HS| of {texts[0]} at 40 and 60 px/s; of {texts[1]} at all speeds"
    return compared(checks[DSNN], checks[EMD], EMD, measured, "", len(rows_with_object(rows)))


CLAIM = ClipClaim(
    id="C11",
    title="Slow objects told from background",
    says=(
        "the EMD model (Iida), log output, does not separate low-speed (40, 60) translations from background; "
        "the DSNN ranks all of them above background-only"
    ),
    source="simu-sys-grayscale-mp, simu-sys-grayscale",
    models=frozenset({DSNN, EMD}),
    equal_terms={EMD: MATCHED[EMD]},
    of_dsnn="the DSNN ranks all translations above background-only",
    conditions=CONTRAST_GRID,
    alone="background_speed",
    mechanism=(
        "background",
        "potentials at background speeds from 0.07 to 10 px a frame, and where the claim breaks",
    ),
    judge=judge,
)
