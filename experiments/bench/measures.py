"""Measures of a sweep: each is one short function from the rows of a point to a number.

A new measure is its function and an entry of `MEASURES`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from dsnn.stimuli import ClipParams
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.rows import group, known
from experiments.bench.sources.conditions import CONDITION_COLUMNS, Condition
from experiments.bench.sources.judge import flaws
from experiments.bench.stats.checks import unreadable
from experiments.bench.stats.claim import POTENTIALS
from experiments.bench.stats.tests import summarise

Rows = Sequence[Mapping[str, Any]]

LEAST_SPEEDS = 3
"""Fewer have no speed between the first and the last, where a peak would be one."""


Number = Mapping[str, Any]
"""A number at a point: its ``value``, ``None`` where there is none; of a mean ``n``, ``ci_low`` and ``ci_high`` too."""


@dataclass(frozen=True, slots=True)
class SweepMeasure:
    """A number that a sweep can show.

    Parameters
    ----------
    name
        Its name after ``--measure``.
    says
        What it is.
    unit
        Its unit; empty where it has none.
    of
        From the rows of a point that it is about to the number.
    given_by
        Whether these conditions, or clips' parameters, give it.
    conditions
        Columns of the one condition that it is about, with their values; empty where it is about several.
    """

    name: str
    says: str
    unit: str
    of: Callable[[Rows], Number]
    given_by: Callable[[Sequence[Any]], bool] = bool
    conditions: tuple[tuple[str, Any], ...] = ()

    def described(self) -> dict[str, str]:
        """Return the entry of ``run.json``."""
        return {"name": self.name, "says": self.says, "unit": self.unit}


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


_ENTRIES = (
    SweepMeasure("peak-speed-potential", "speed at which mean HS near the axis is largest", "cm/s",
            partial(peak_speed, column="mean_hs_near_axis"), _crossings),
    SweepMeasure("peak-speed-count", "speed at which there are most spikes", "cm/s",
            partial(peak_speed, column="spikes"), _crossings),
    SweepMeasure("peak-hs", "largest HS of a crossing, of several the lowest", "", least_peak, _rightward),
)  # fmt: skip
MEASURES: Mapping[str, SweepMeasure] = {measure.name: measure for measure in _ENTRIES}
"""The measures by name."""

SPIKES = "spikes"
"""The measure that is one of each condition: the mean number of spikes in a trial."""


def spikes_in(conditions: Sequence[Condition]) -> list[SweepMeasure]:
    """Return a measure for each condition: the mean number of spikes in its trials, with its 95 % interval.

    Each is called by the columns in which conditions differ.
    """
    every = [{name: getattr(condition, name) for name in CONDITION_COLUMNS} for condition in dict.fromkeys(conditions)]
    varied = [name for name in CONDITION_COLUMNS if len({columns[name] for columns in every}) > 1]
    measures = []
    for columns in every:
        values = {name: columns[name] for name in varied}
        texts = [f"{name}={value:g}" if isinstance(value, float | int) else f"{name}={value}"
                 for name, value in values.items()]  # fmt: skip
        name = f"{SPIKES}: {', '.join(texts)}" if texts else SPIKES
        of = partial(mean_spikes, condition=columns)
        words = "mean number of spikes in a trial"
        measures.append(SweepMeasure(name, words, "", of, conditions=tuple(columns.items())))
    return measures


def mean_spikes(rows: Rows, *, condition: Mapping[str, Any]) -> Number:
    """Compute the mean number of spikes over the trials of one condition, and its 95 % interval.

    Parameters
    ----------
    rows
        Of ``trials.parquet``, of one model.
    condition
        Columns of the condition with their values.

    Returns
    -------
    Number
        None of a model that does not spike, and where no trial has that condition.
    """
    trials = [row for row in rows if all(row[name] == value for name, value in condition.items())]
    spikes = [row["spikes"] for row in trials if row["spikes"] is not None]
    if not spikes:
        return {"value": None, "n": len(trials)}
    summary = summarise(spikes, 0.0)
    ends = {"ci_low": known(summary.ci_low), "ci_high": known(summary.ci_high)}
    return {"value": summary.mean, "n": len(trials), **ends}


def chosen(
    wanted: Sequence[str], conditions: Mapping[str, Sequence[Sequence[Any]]], models: Sequence[ConfiguredModel]
) -> list[tuple[SweepMeasure, str]]:
    """Return measures by their names, each with the first experiment that gives it.

    Parameters
    ----------
    wanted
        Names of `MEASURES`, or ``spikes``.
    conditions
        Name of an experiment -> its conditions, or its clips' parameters, wherever a point changes them.
    models
        The models judged.

    Raises
    ------
    UsageError
        A measure is not known, none of the experiments gives it at all points, or no model responds by ``hs``.
    """
    found: list[tuple[SweepMeasure, str]] = []
    for name in dict.fromkeys(wanted):
        if name == SPIKES:
            every = {place: [one for some in shown for one in some] for place, shown in conditions.items()}
            giving = [(measure, place) for place, of_it in every.items() if isinstance(of_it[0], Condition)
                      for measure in spikes_in(of_it)]  # fmt: skip
        elif name in MEASURES:
            if not any("hs" in model.channels for model in models):
                raise UsageError(f"--measure {name}: it is about models that respond by direction")
            measure = MEASURES[name]
            giving = [(measure, place) for place, shown in conditions.items() if all(map(measure.given_by, shown))][:1]
        else:
            raise UsageError(f"--measure {name}: unknown measure; known are {', '.join((*MEASURES, SPIKES))}")
        if not giving:
            raise UsageError(f"--measure {name}: none of {', '.join(conditions)} shows what it is of at every point")
        found += giving
    return found
