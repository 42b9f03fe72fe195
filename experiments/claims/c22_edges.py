"""C22. Each edge drives its own pathway."""

from __future__ import annotations

from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import (
    BLOCKED,
    DSNN,
    LEAST_OF_OTHER,
    MOST_OF_DRIVEN,
    Rows,
    outcome_of,
    rows_of,
    strongest,
)
from experiments.bench.stats.checks import Check
from experiments.bench.stats.verdict import Outcome

DRIVEN = {"on": "dsnn-on-blocked", "off": "dsnn-off-blocked"}
"""An edge's polarity -> the model in which the pathway that it drives is blocked."""


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge one edge in view: what each blocked pathway leaves of the largest |HS|.

    An OFF edge is the leading one of a dark object and the trailing one of a light object, an ON edge the reverse.
    """
    texts, checks = [], []
    for whole in rows_of(rows):
        clip, intact = whole["clip"], strongest(whole, "hs")
        driven = DRIVEN[whole["polarity"]]
        (other,) = (model for model in BLOCKED if model != driven)
        first, second = (
            strongest(rows_of(rows, model, clip=clip)[0], "hs") / intact if intact else float("nan")
            for model in (driven, other)
        )
        left = f"of |HS| {intact:.3f}"
        checks += [
            Check(f"{clip}: {driven} leaves {first:.1%} {left}", first, MOST_OF_DRIVEN, "below",
                  asks=f"under {MOST_OF_DRIVEN:.0%}"),
            Check(f"{clip}: {other} leaves {second:.1%} {left}", second, LEAST_OF_OTHER,
                  asks=f"over {LEAST_OF_OTHER:.0%}"),
        ]  # fmt: skip
        texts.append(f"{clip}: |HS| {intact:.3f}, {driven} {first:.1%}, {other} {second:.1%}")
    good = sum(all(check.passes for check in checks[i : i + 2]) for i in range(0, len(checks), 2))
    return outcome_of(checks, "; ".join(texts), f"{good} of {len(texts)} edges", len(texts))


CLAIM = ClipClaim(
    id="C22",
    title="Each edge drives its own pathway",
    says=(
        "a dark object's leading edge drives the OFF pathway and its trailing edge the ON pathway; the reverse "
        "for a light object (with one edge in view, blocking the driven pathway leaves under 5 % of the intact "
        "|HS|, blocking the other over 95 %)"
    ),
    source=(
        "simu-clean-dth and its text; motion-models; the text on ensembles and dynamic delays; simu-sys-grayscale (c)"
    ),
    models=frozenset({DSNN, *BLOCKED}),
    conditions={"stimulus": ("edge",), "motion": ("rightward", "leftward"), "polarity": ("on", "off")},
    of_every_clip=True,
    implied=(
        "The half-wave split hands a change of one sign to one pathway alone, and one edge makes changes of one sign."
    ),
    mechanism=(
        "edges",
        "which edge drives which pathway",
    ),
    judge=judge,
)
