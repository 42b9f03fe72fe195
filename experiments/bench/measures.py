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

BELOW_THRESHOLD = "below T"
"""The note on a potential that does not pass the threshold."""
LEAST_SPEEDS = 3
"""Fewer have no speed between the first and the last, where a peak would be one."""


Number = Mapping[str, Any]
"""A number at a point: its ``value``, ``None`` where there is none; a ``mark``, a note in a few words; what it was
``measured`` from, or why there is none; of a mean ``n`` and its 95 % interval, ``ci_low`` and ``ci_high``."""


@dataclass(frozen=True, slots=True)
class Measure:
    """A number that a sweep can show.

    Parameters
    ----------
    name
        Its name after ``--measure``.
    says
        What it is.
    unit
        Its unit; empty where it has none.
    needs
        What an experiment needs for it, in words.
    given_by
        Whether these conditions, or clips' parameters, give it.
    of
        From the rows of a point that it is about, and the model's spiking threshold, to the number.
    conditions
        Columns of the one condition that it is about, with their values; empty where it is about several.
    """

    name: str
    says: str
    unit: str
    needs: str
    given_by: Callable[[Sequence[Any]], bool]
    of: Callable[[Rows, float | None], Number]
    conditions: tuple[tuple[str, Any], ...] = ()

    def described(self) -> dict[str, str]:
        """Return the entry of ``run.json``."""
        return {"name": self.name, "says": self.says, "unit": self.unit}


def _none(why: str) -> Number:
    return {"value": None, "mark": "", "measured": why}


def _crossings(conditions: Sequence[Any]) -> bool:
    """Return whether the rightward crossings among conditions differ in speed alone, and have enough speeds."""
    crossings = [
        condition for condition in conditions
        if isinstance(condition, Condition) and (condition.motion, condition.direction) == ("translation", "rightward")
    ]  # fmt: skip
    others = [name for name in CONDITION_COLUMNS if name != "speed_cm_s"]
    alike = {tuple(getattr(condition, name) for name in others) for condition in crossings}
    return len(alike) == 1 and len({condition.speed_cm_s for condition in crossings}) >= LEAST_SPEEDS


def peak_speed(rows: Rows, _threshold: float | None, *, column: str) -> Number:
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
        conditions say. ``mark`` says where it is at an end of the speeds shown: the true peak may lie beyond.
    """
    crossings = [row for row in rows if (row["motion"], row["direction"]) == ("translation", "rightward")]
    wrong = unreadable(crossings, [column]) or flaws(crossings)
    if wrong or not crossings:
        return _none(f"of the trials {wrong}" if wrong else "no rightward crossings")
    by_speed = sorted(group(crossings, "speed_cm_s").items())
    means = {speed: float(np.mean([row[column] for row in of_speed])) for (speed,), of_speed in by_speed}
    listed = ", ".join(f"{mean:.3g} at {speed:g}" for speed, mean in means.items())
    words = f"mean over trials of {column}: {listed} cm/s"
    highest = max(means, key=lambda speed: means[speed])
    if means[highest] <= 0.0:
        return _none(f"none is above 0; {words}")
    end = highest in (min(means), max(means))
    return {"value": highest, "mark": "at the end of the range" if end else "", "measured": words}


def _rightward(clips: Sequence[Any]) -> bool:
    """Return whether a clip shows an object that moves rightward."""
    return any(
        isinstance(params, ClipParams) and getattr(params, "motion", "") == "rightward"
        and getattr(params, "object", "") != "absent"
        for params in clips
    )  # fmt: skip


def least_peak(rows: Rows, threshold: float | None) -> Number:
    """Find the largest HS of a rightward crossing: of several crossings the lowest of their peaks.

    Parameters
    ----------
    rows
        Of ``trials.parquet`` of clips, of one model; rightward crossings of an object count.
    threshold
        The model's spiking threshold T.

    Returns
    -------
    Number
        The potential. ``mark`` says where it does not pass T, as C6 asks of every crossing.
    """
    crossings = [row for row in rows if row["motion"] == "rightward" and row["object"] != "absent"]
    wrong = unreadable(crossings, POTENTIALS)
    if wrong or not crossings:
        return _none(f"of the clips {wrong}" if wrong else "no rightward crossings")
    peak = {
        clip: min(row["peak_hs"] for row in clip_rows) for clip, clip_rows in group(crossings, "clip", "seed").items()
    }
    listed = ", ".join(f"{clip} at seed {seed}: {value:.3f}" for (clip, seed), value in peak.items())
    least = float(min(peak.values()))
    below = threshold is not None and least <= threshold
    return {"value": least, "mark": BELOW_THRESHOLD if below else "", "measured": f"peak HS of {listed}"}


_SPEEDS = f"rightward crossings at {LEAST_SPEEDS} speeds or more, all else equal"
_ENTRIES = (
    Measure("peak-speed-potential", "speed at which mean HS near the axis is largest", "cm/s", _SPEEDS,
            _crossings, partial(peak_speed, column="mean_hs_near_axis")),
    Measure("peak-speed-count", "speed at which there are most spikes", "cm/s", _SPEEDS, _crossings,
            partial(peak_speed, column="spikes")),
    Measure("peak-hs", "largest HS of a crossing, of several the lowest", "",
            "clips of an object that moves rightward", _rightward, least_peak),
)  # fmt: skip
MEASURES: Mapping[str, Measure] = {measure.name: measure for measure in _ENTRIES}
"""The measures by name."""

SPIKES = "spikes"
"""The measure that is one of each condition: the mean number of spikes in a trial."""


def spikes_in(conditions: Sequence[Condition]) -> list[Measure]:
    """Return a measure for each condition: the mean number of spikes in its trials, with its 95 % interval.

    Each is called by the columns in which conditions differ.
    """
    every = list(dict.fromkeys(conditions))
    varied = [name for name in CONDITION_COLUMNS if len({getattr(condition, name) for condition in every}) > 1]
    measures = []
    for condition in every:
        columns = {name: getattr(condition, name) for name in CONDITION_COLUMNS}
        texts = [f"{name}={columns[name]:g}" if isinstance(columns[name], float | int) else f"{name}={columns[name]}"
                 for name in varied]  # fmt: skip
        name = f"{SPIKES}: {', '.join(texts)}" if texts else SPIKES
        of = partial(mean_spikes, condition=columns)
        measures.append(Measure(name, "mean number of spikes in a trial", "", "", bool, of, tuple(columns.items())))
    return measures


def mean_spikes(rows: Rows, _threshold: float | None, *, condition: Mapping[str, Any]) -> Number:
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
        return {**_none("no trial there" if not trials else "it does not spike"), "n": len(trials)}
    summary = summarise(spikes, 0.0)
    return {"value": summary.mean, "mark": "", "measured": "", "n": len(trials), "ci_low": known(summary.ci_low),
            "ci_high": known(summary.ci_high)}  # fmt: skip


def chosen(
    wanted: Sequence[str], conditions: Mapping[str, Sequence[Sequence[Any]]], models: Sequence[ConfiguredModel]
) -> list[tuple[Measure, str]]:
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
    found: list[tuple[Measure, str]] = []
    experiments = ", ".join(conditions)
    for name in dict.fromkeys(wanted):
        if name == SPIKES:
            for place, shown in conditions.items():
                every = [condition for some in shown for condition in some]
                if not isinstance(every[0], Condition):
                    raise UsageError(f"--measure {name}: it needs trials with the robot; {experiments} has clips")
                found += [(measure, place) for measure in spikes_in(every)]
            continue
        if name not in MEASURES:
            raise UsageError(f"--measure {name}: unknown measure; known are {', '.join((*MEASURES, SPIKES))}")
        measure = MEASURES[name]
        if not any("hs" in model.channels for model in models):
            raise UsageError(f"--measure {name}: it is about models that respond by direction")
        giving = [place for place, shown in conditions.items() if all(map(measure.given_by, shown))]
        if not giving:
            raise UsageError(f"--measure {name}: it needs {measure.needs}; {experiments} has none at some point")
        found.append((measure, giving[0]))
    return found
