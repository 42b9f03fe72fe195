"""Measures of a sweep: each is one short function from the rows of a point to a number.

A new measure is an entry of `MEASURES`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from dsnn.stimuli import ClipParams
from experiments.base.errors import UsageError, check_known
from experiments.declare.claim import POTENTIALS
from experiments.declare.conditions import CONDITION_COLUMNS, Condition
from experiments.declare.outcome import unreadable
from experiments.judge.judge import flaws
from experiments.judge.tests import summarise
from experiments.settings.models import ConfiguredModel
from experiments.store.tables import finite, group

Rows = Sequence[Mapping[str, Any]]

LEAST_SPEEDS = 3
"""Fewer have no speed between the first and the last, where a peak would be one."""


Number = Mapping[str, Any]
"""A number at a point: its ``value``, ``None`` where there is none; of a mean ``n``, ``ci_low`` and ``ci_high`` too."""
Measure = tuple[str, str, Mapping[str, Any]]
"""A measure's name, the experiment that gives it, and the columns of the one condition that it is about, if it is."""


def _crossings(conditions: Sequence[Any]) -> bool:
    """Return whether the rightward crossings among conditions differ in speed alone, and have enough speeds."""
    crossings = [
        condition for condition in conditions
        if isinstance(condition, Condition) and (condition.motion, condition.direction) == ("translation", "rightward")
    ]  # fmt: skip
    others = [name for name in CONDITION_COLUMNS if name != "speed_cm_s"]
    alike = {tuple(getattr(condition, name) for name in others) for condition in crossings}
    return len(alike) == 1 and len({condition.speed_cm_s for condition in crossings}) >= LEAST_SPEEDS


def peak_speed(rows: Rows, *, column: str) -> Number:
    """Find the speed among those shown at which the mean of a column over trials is largest.

    Parameters
    ----------
    rows
        Of ``trials.parquet``, of one model; rightward crossings count.
    column
        What is averaged over the trials of a speed.

    Returns
    -------
    Number
        In cm/s; of equal means the lowest speed. None where no mean is above 0, and where trials are not what their
        conditions have. At an end of the speeds shown the true peak may lie beyond.
    """
    crossings = [row for row in rows if (row["motion"], row["direction"]) == ("translation", "rightward")]
    if not crossings or unreadable(crossings, [column]) or flaws(crossings):
        return {"value": None}
    by_speed = sorted(group(crossings, "speed_cm_s").items())
    means = {speed: float(np.mean([row[column] for row in of_speed])) for (speed,), of_speed in by_speed}
    highest = max(means, key=means.__getitem__)
    return {"value": highest if means[highest] > 0.0 else None}


def _rightward(clips: Sequence[Any]) -> bool:
    """Return whether a clip shows an object that moves rightward."""
    return any(
        isinstance(params, ClipParams) and getattr(params, "motion", "") == "rightward"
        and getattr(params, "object", "") != "absent"
        for params in clips
    )  # fmt: skip


def least_peak(rows: Rows) -> Number:
    """Find the largest HS of a rightward crossing: of several crossings the lowest of their peaks.

    Parameters
    ----------
    rows
        Of ``trials.parquet`` of clips, of one model; rightward crossings of an object count.

    Returns
    -------
    Number
        The potential. None where there is no crossing, or a potential is not a number.
    """
    crossings = [row for row in rows if row["motion"] == "rightward" and row["object"] != "absent"]
    if not crossings or unreadable(crossings, POTENTIALS):
        return {"value": None}
    return {"value": min(float(row["peak_hs"]) for row in crossings)}


def mean_of(rows: Rows, *, column: str, within: Sequence[float] = ()) -> Number:
    """Compute the mean of a column over trials, and its 95 % interval.

    Parameters
    ----------
    rows
        Of ``trials.parquet``, of one model; of spikes also of one condition.
    column
        What is averaged.
    within
        Its least possible value, and its largest.

    Returns
    -------
    Number
        None where no trial has a value, as spikes of a model that does not spike.
    """
    values = [row[column] for row in rows if row[column] is not None]
    if not values:
        return {"value": None, "n": len(rows)}
    score = summarise(values, *within)
    ends = {"ci_low": finite(score.low), "ci_high": finite(score.high)}
    return {"value": score.value, "n": len(rows), **ends}


def gain_slope(rows: Rows) -> Number:
    """Compute how the gain against the true flow changes with the stimulus's speed: a line by least squares.

    Parameters
    ----------
    rows
        Of ``trials.parquet``, of one model.

    Returns
    -------
    Number
        In 1/px per cm/s. None with fewer than two speeds.
    """
    pairs = [(row["speed_cm_s"], row["true_gain"]) for row in rows if row["true_gain"] is not None]
    if len({speed for speed, _ in pairs}) < 2:
        return {"value": None}
    table = np.array(pairs, np.float64)
    return {"value": float(np.polyfit(table[:, 0], table[:, 1], 1)[0])}


def _with_robot(shown: Sequence[Any]) -> bool:
    """Return whether what is shown are trials with the robot."""
    return isinstance(shown[0], Condition)


TRUE = "true-"
"""Beginning of the measures whose trials need truth."""
SPIKES = "spikes"
"""The measure that is one of each condition: the mean number of spikes in a trial."""


class Quantity(NamedTuple):
    """What a measure is: its function of the rows of a point, the experiments that give it, and its unit."""

    of: Callable[[Rows], Number]
    given_by: Callable[[Sequence[Any]], bool]
    """Whether an experiment's conditions, or its clips, give it."""
    unit: str = ""


MEASURES: Mapping[str, Quantity] = {
    "peak-speed-potential": Quantity(partial(peak_speed, column="mean_hs_near_axis"), _crossings, "cm/s"),
    "peak-speed-count": Quantity(partial(peak_speed, column="spikes"), _crossings, "cm/s"),
    "peak-hs": Quantity(least_peak, _rightward),
    SPIKES: Quantity(partial(mean_of, column="spikes", within=(0.0,)), _with_robot),
    "true-r": Quantity(partial(mean_of, column="true_hs_flow_r", within=(-1.0, 1.0)), _with_robot),
    "true-view-r": Quantity(partial(mean_of, column="true_hs_view_r", within=(-1.0, 1.0)), _with_robot),
    "true-vs-r": Quantity(partial(mean_of, column="true_vs_flow_r", within=(-1.0, 1.0)), _with_robot),
    "true-vs-view-r": Quantity(partial(mean_of, column="true_vs_view_r", within=(-1.0, 1.0)), _with_robot),
    "true-sign": Quantity(partial(mean_of, column="true_sign", within=(0.0, 1.0)), _with_robot),
    "true-gain": Quantity(partial(mean_of, column="true_gain"), _with_robot, "1/px"),
    "true-gain-slope": Quantity(gain_slope, _with_robot, "1/px per cm/s"),
}
"""Name after ``--measure`` -> what it is."""


def quantity(name: str) -> Quantity:
    """Return the quantity of a measure, which may be one of a condition: ``spikes: speed_cm_s=2``."""
    return MEASURES[name.partition(":")[0]]


def measured(name: str, condition: Mapping[str, Any], rows: Rows) -> Number:
    """Return a measure at a point from its rows: those with the columns of ``condition`` count."""
    own = [row for row in rows if all(row[column] == value for column, value in condition.items())]
    return quantity(name).of(own)


def by_condition(conditions: Sequence[Condition]) -> dict[str, dict[str, Any]]:
    """Return a measure for each condition, the mean number of spikes in its trials, with the condition's columns.

    Each is called by the columns in which conditions differ.
    """
    every = [{name: getattr(condition, name) for name in CONDITION_COLUMNS} for condition in dict.fromkeys(conditions)]
    varied = [name for name in CONDITION_COLUMNS if len({columns[name] for columns in every}) > 1]
    measures = {}
    for columns in every:
        values = {name: columns[name] for name in varied}
        texts = [f"{name}={value:g}" if isinstance(value, float | int) else f"{name}={value}"
                 for name, value in values.items()]  # fmt: skip
        measures[f"{SPIKES}: {', '.join(texts)}" if texts else SPIKES] = columns
    return measures


def chosen(
    wanted: Sequence[str], conditions: Mapping[str, Sequence[Sequence[Any]]], models: Sequence[ConfiguredModel]
) -> list[Measure]:
    """Return measures by their names, each with the first experiment that gives it.

    Parameters
    ----------
    wanted
        Names of `MEASURES`.
    conditions
        Name of an experiment -> its conditions, or its clips' parameters, wherever a point changes them.
    models
        The models judged.

    Raises
    ------
    UsageError
        A measure is not known, none of the experiments gives it at all points, or no model responds by ``hs``.
    """
    found: list[Measure] = []
    giving: Sequence[Measure]
    for name in dict.fromkeys(wanted):
        check_known("--measure", name, MEASURES)
        places = [place for place, shown in conditions.items() if all(map(MEASURES[name].given_by, shown))]
        if name == SPIKES:
            every = {place: [one for some in conditions[place] for one in some] for place in places}
            giving = [(measure, place, columns) for place, of_it in every.items()
                      for measure, columns in by_condition(of_it).items()]  # fmt: skip
        else:
            if not any("hs" in model.channels for model in models):
                raise UsageError(f"--measure {name}: it is about models that respond by direction")
            giving = [(name, place, {}) for place in places[:1]]
        if not giving:
            raise UsageError(f"--measure {name}: none of {', '.join(conditions)} shows what it is of at every point")
        found += giving
    return found
