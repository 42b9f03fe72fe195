"""C4. ON and OFF carry about half each."""

from __future__ import annotations

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import BLOCKED, DSNN, SIGNED, Rows, outcome_of, rows_of
from experiments.bench.stats.checks import Check
from experiments.bench.stats.verdict import Outcome

HALF = (0.4, 0.6)
"""Of the intact peak, what either pathway alone may leave."""
SUM_TOLERANCE = 1e-3


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge that each pathway alone leaves its share of the intact peak, and that both add up to the whole."""
    texts, checks = [], []
    for whole in rows_of(rows):
        clip, name = whole["clip"], SIGNED[whole["motion"]][0]
        intact = float(whole[name])
        peaks = [float(rows_of(rows, model, clip=clip)[0][name]) for model in BLOCKED]
        shares = [peak / intact if intact else float("nan") for peak in peaks]
        rest = abs(sum(peaks) - intact)
        for which, share in zip(("ON", "OFF"), shares, strict=True):
            text, asks = f"{clip}: {which} blocked leaves {share:.1%}", f"{HALF[0]:.0%} to {HALF[1]:.0%}"
            checks.append(Check(text, share, HALF, "within", scale=HALF[1] - HALF[0], asks=asks))
        adds = f"{clip}: ON and OFF alone differ from the whole by {rest:.1e}"
        checks.append(Check(adds, rest, SUM_TOLERANCE, "below", scale=SUM_TOLERANCE))
        texts.append(f"{clip}: ON blocked {shares[0]:.0%}, OFF blocked {shares[1]:.0%}, sum off by {rest:.1e}")
    good = sum(all(check.passes for check in checks[i : i + 3]) for i in range(0, len(checks), 3))
    return outcome_of(checks, "; ".join(texts), f"{good} of {len(texts)} clips", len(texts))


CLAIM = ClipClaim(
    id="C4",
    title="ON and OFF carry about half each",
    says="blocking ON or OFF leaves 40..60 % of the intact peak; a blocked pathway adds nothing",
    source="simu-clean, simu-clean-dth, simu-clean-dtv",
    models=frozenset({DSNN, *BLOCKED}),
    conditions={"motion": tuple(SIGNED)},
    of_every_clip=True,
    implied=(
        "HS is the sum of f(ON) and f(OFF), so both pathways alone add up to the whole, whatever is shown. That each "
        "leaves about half is not implied."
    ),
    mechanism=(
        "edges",
        "which pathway one edge in view drives",
    ),
    judge=judge,
)
