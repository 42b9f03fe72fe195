"""C14. Rightward past +T, leftward past -T."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import ACROSS, Row, Rows, mean_text, outcome_of, paper_trials
from experiments.bench.stats.checks import Check
from experiments.bench.stats.verdict import Outcome

WAYS = {1.0: "rightward", -1.0: "leftward"}
"""Sign of HS -> direction of the motion."""


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge every crossing of the trials given, at whatever speed and distance.

    A trial passes if HS goes past the threshold of its own direction and not past that of the other: a potential
    that passes both tells no direction.
    """
    crossings = paper_trials(rows, motion="translation")
    ways = {sign: [row for row in crossings if row["direction"] == way] for sign, way in WAYS.items()}
    tested = {sign: trials for sign, trials in ways.items() if trials}
    if not tested:
        return Outcome.unjudged("needs translations")
    parts, checks = [], []
    conditions: dict[str, list[float]] = {}
    for sign, trials in tested.items():
        right, wrong = ([_reached(row, end * sign) for row in trials] for end in (1.0, -1.0))
        weak, stray = trials[int(np.argmin(right))], trials[int(np.argmax(wrong))]
        reaches = f"HS reaches {sign * min(right):+.3f} at {_where(weak)}"
        strays = f"the other way it reaches {-sign * max(wrong):+.3f} at {_where(stray)}"
        way, mean = WAYS[sign], mean_text([sign * value for value in right], 2)
        parts.append(f"{way}, worst of {len(trials)}: {reaches}, mean {mean}; {strays}")
        passes, strays_not = f"to pass {sign * threshold:+g}", f"not to pass {-sign * threshold:+g}"
        checks += [
            Check(f"{way}: {reaches}", min(right), threshold, asks=passes),
            Check(f"{way}: {strays}", max(wrong), threshold, "at most", asks=strays_not),
        ]
        for row, value in zip(trials, right, strict=True):
            conditions.setdefault(f"{way}, {_where(row)}", []).append(value)
    good = sum(
        _reached(row, sign) > threshold and _reached(row, -sign) <= threshold for sign in tested for row in tested[sign]
    )
    effect = f"{good} of {sum(map(len, tested.values()))} trials pass"
    outcome = outcome_of(checks, conditions, f"{'; '.join(parts)} (T = {threshold:g})", effect)
    outcome = replace(outcome, broken=outcome.n - good)
    if outcome.verdict == "holds" and len(tested) < len(ways):
        return outcome.withheld("the other direction was not run")
    return outcome


def _reached(row: Row, sign: float) -> float:
    """Return how far HS goes from 0 to the side of ``sign``."""
    return float(row["peak_hs"] if sign > 0 else -row["trough_hs"])


def _where(row: Row) -> str:
    return f"{row['speed_cm_s']:g} cm/s, {row['distance_cm']:g} cm"


CLAIM = RobotClaim(
    id="C14",
    title="Rightward past +T, leftward past -T",
    eye=(
        "Automatic exposure takes the arena to a middle grey: "
        "the steps in grey are less than half, HS is about a quarter, below T."
    ),
    says="right translation: HS > +T; left translation: HS < -T",
    source="robot-general-tests",
    motions=ACROSS,
    reads=("peak_hs", "trough_hs"),
    of_every_trial=True,
    judge=judge,
)
