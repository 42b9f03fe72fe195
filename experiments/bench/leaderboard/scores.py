"""Scores of each direction model from the rows of trials and clips. Pure functions; nothing is run or drawn here."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.stats.clips import SIGNED
from experiments.bench.stats.scores import Score, Standing
from experiments.bench.stats.tests import (
    area_under_roc,
    effective_number,
    median_interval,
    proportion_interval,
)

Row = Mapping[str, Any]
DEPTH, BACKGROUND = "depth", "background"
"""Kinds of what a row was shown, beside the four directions."""

MEASURES = {
    "direction_robot": "direction, robot",
    "direction_clips": "direction, clips",
    "auc_robot": "AUC, robot",
    "auc_clips": "AUC, clips",
    "false_alarms": "false alarms",
    "us_99x72": "us, 99x72",
    "us_320x180": "us, 320x180",
}
"""Every measure, with a heading for people: the columns of ``leaderboard.csv``, in their order."""
SORTED_BY = "the mean of both direction accuracies, then of both AUCs"
Scores = Mapping[str, Score | None]
"""Measure -> score; ``None`` where a model has no such thing."""


def shown(row: Row) -> str:
    """Return what was shown: one of the four directions, `DEPTH`, or `BACKGROUND` alone."""
    if "direction" in row:  # a robot's trial
        return str(row["direction"]) if row["motion"] == "translation" else DEPTH
    if row["object"] == "absent" or row["motion"] is None:
        return BACKGROUND
    return str(row["motion"]) if row["motion"] in SIGNED else DEPTH


def condition(row: Row) -> tuple[object, ...]:
    """Return what all repeats of one condition share: the clip, or the columns of a robot's condition."""
    names = ("clip",) if "clip" in row else CONDITION_COLUMNS
    return (row["experiment"], *(row[name] for name in names))


def answer(row: Row) -> str | None:
    """Return the direction of the strongest potential of either system; ``None`` if two are equal, or all silent."""
    strengths = {direction: sign * row[column] for direction, (column, sign) in SIGNED.items()}
    strongest = max(strengths.values())
    named = [direction for direction, strength in strengths.items() if strength == strongest]
    return named[0] if len(named) == 1 else None


def strength(row: Row) -> float:
    """Return the largest |HS| or |VS| of a trial."""
    return float(max(sign * row[column] for column, sign in SIGNED.values()))


def direction_accuracy(rows: Iterable[Row]) -> Score | None:
    """Return the share of translations answered by the right system with the right sign; guessing gets 1/4."""
    translations = [row for row in rows if shown(row) in SIGNED]
    return share([answer(row) == shown(row) for row in translations], translations)


def separation(rows: Iterable[Row]) -> Score | None:
    """Area under the ROC curve for translation against motion in depth by `strength`; under 0.5 it prefers depth."""
    known = [(shown(row), row) for row in rows]
    across = [row for what, row in known if what in SIGNED]
    depth = [row for what, row in known if what == DEPTH]
    return area(across, depth, strength)


def area(positives: Sequence[Row], negatives: Sequence[Row], value: Callable[[Row], float]) -> Score | None:
    """Return the area under the ROC curve of rows by their ``value``; ``None`` where either are none.

    Its interval is Newcombe's, with the repeats of a condition as a cluster.
    """
    if not positives or not negatives:
        return None
    above, below = ([value(row) for row in side] for side in (positives, negatives))
    clusters = [condition(row) for row in positives], [condition(row) for row in negatives]
    return Score(*area_under_roc(above, below, clusters), len(positives) + len(negatives))


def false_alarms(rows: Iterable[Row]) -> Score | None:
    """Return the share of clips of background alone in which the model spiked, in any channel that it declares."""
    backgrounds = [row for row in rows if shown(row) == BACKGROUND]
    return share([_fired(row) for row in backgrounds], backgrounds)


def _fired(row: Row) -> bool:
    """Tell whether any declared channel spiked; the others' counts are null."""
    return any(row[name] for name in ("hs_spikes", "vs_spikes", "looming_spikes"))


def frame_time(us: Sequence[float] | None) -> Score | None:
    """Return the median of the times (us per frame) of rounds, its interval by order statistics."""
    if not us:
        return None
    return Score(float(np.median(us)), *median_interval(us), len(us))


def share(hits: Sequence[bool], rows: Sequence[Row]) -> Score | None:
    """Return the share of ``rows`` that are ``hits``; ``None`` of no rows.

    Its interval is Clopper and Pearson's of their effective number: the repeats of a condition are a cluster.
    """
    if not hits:
        return None
    number, value = effective_number(hits, [condition(row) for row in rows]), sum(hits) / len(hits)
    return Score(value, *proportion_interval(value * number, number), len(hits))


def scores(
    robot: Sequence[Row], clips: Sequence[Row], us: Mapping[str, Sequence[float]], spikes: bool
) -> dict[str, Score | None]:
    """Return every measure of one direction model, of whose ``robot`` trials and ``clips`` these are all rows.

    ``us`` has its times by the measure's name, ``spikes`` is true of a model with a threshold.
    """
    return {
        "direction_robot": direction_accuracy(robot),
        "direction_clips": direction_accuracy(clips),
        "auc_robot": separation(robot),
        "auc_clips": separation(clips),
        "false_alarms": false_alarms(clips) if spikes else None,
        **{name: frame_time(us.get(name)) for name in MEASURES if name.startswith("us_")},
    }


def ranked(standings: Iterable[Standing]) -> list[Standing]:
    """Return the scores in the order that `SORTED_BY` tells; equals by name."""
    return sorted(standings, key=lambda s: (-_mean(s, "direction"), -_mean(s, "auc"), s.name))


def _mean(standing: Standing, kind: str) -> float:
    """Average the robot's and the clips' score, as far as there are any; otherwise below all."""
    values = [score.value for s in ("robot", "clips") if (score := standing.scores[f"{kind}_{s}"]) is not None]
    return sum(values) / len(values) if values else -math.inf
