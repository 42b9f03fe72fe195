"""Measures of a study, beside its claims: each is one short function from the rows of a point to a number.

A new measure is its function and an entry of `MEASURES`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from dsnn.stimuli import ClipParams
from experiments.bench.sources import judging
from experiments.bench.sources.clip_claims import POTENTIALS
from experiments.bench.sources.conditions import CONDITION_COLUMNS, Condition
from experiments.bench.sources.robot_claims import flaws
from experiments.bench.stats.checks import unreadable
from experiments.bench.stats.tests import summarise
from experiments.bench.store.rows import group, known

Rows = Sequence[Mapping[str, Any]]

BELOW_THRESHOLD = "below T"
"""The note of a potential that does not pass the threshold."""
LEAST_SPEEDS = 3
"""Fewer have no speed between the first and the last, where a peak would be one."""


@dataclass(frozen=True, slots=True)
class Measured:
    """A number at a point of a map.

    Parameters
    ----------
    value
        The number; ``None`` where there is none.
    mark
        What is to be known of it, in a few words; empty if nothing is.
    words
        What it was found from, or why there is none.
    n, low, high
        Of a mean: the number of trials, and its 95 % interval.
    """

    value: float | None
    mark: str = ""
    words: str = ""
    n: int | None = None
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True, slots=True)
class Measure:
    """A number that a study can show.

    Parameters
    ----------
    name
        Its name after ``--measure``.
    says
        What it is.
    unit
        Its unit; empty where it has none.
    kind
        What it is measured on: trials with the robot, or clips.
    needs
        What an experiment needs for it, in words.
    given_by
        Whether these conditions, or clips' parameters, give it.
    of
        From the rows of a point that it is about, and the model's spiking threshold, to the number.
    motions
        The motions that it reads, with the robot.
    conditions
        Columns of the one condition that it is about, with their values; empty where it is about several.
    """

    name: str
    says: str
    unit: str
    kind: Literal["robot", "clips"]
    needs: str
    given_by: Callable[[Sequence[Any]], bool]
    of: Callable[[Rows, float | None], Measured]
    motions: tuple[str, ...] = ("translation",)
    conditions: tuple[tuple[str, Any], ...] = ()

    def described(self) -> dict[str, str]:
        """Return what ``run.json`` says of it."""
        return {"name": self.name, "says": self.says, "unit": self.unit}


def _crossings(conditions: Sequence[Condition]) -> bool:
    """Return whether the rightward crossings among conditions differ in speed alone, and have enough speeds."""
    crossings = [
        condition for condition in conditions if (condition.motion, condition.direction) == ("translation", "rightward")
    ]
    others = [name for name in CONDITION_COLUMNS if name != "speed_cm_s"]
    alike = {tuple(getattr(condition, name) for name in others) for condition in crossings}
    return len(alike) == 1 and len({condition.speed_cm_s for condition in crossings}) >= LEAST_SPEEDS


def peak_speed(rows: Rows, _threshold: float | None, *, column: str) -> Measured:
    """Find the speed among those shown at which the mean of a column over trials is largest.

    Parameters
    ----------
    rows
        Of ``trials.parquet``, of one model; rightward crossings count.
    column
        What is averaged over the trials of a speed.

    Returns
    -------
    Measured
        In cm/s; of equal means the lowest speed. None where no mean is above 0, and where trials are not what their
        conditions say. ``mark`` says where it is at an end of the speeds shown: the true peak may lie beyond.
    """
    crossings = [row for row in rows if (row["motion"], row["direction"]) == ("translation", "rightward")]
    wrong = unreadable(crossings, [column]) or flaws(crossings)
    if wrong or not crossings:
        return Measured(None, words=f"of the trials {wrong}" if wrong else "no rightward crossings")
    means = {speed: judging.mean(values) for speed, values in sorted(judging.curve(crossings, column).items())}
    listed = ", ".join(f"{mean:.3g} at {speed:g}" for speed, mean in means.items())
    words = f"mean over trials of {column}: {listed} cm/s"
    highest = judging.peak(means)
    if highest.mean <= 0.0:
        return Measured(None, words=f"none is above 0; {words}")
    return Measured(highest.speed, "at the end of the range" if highest.end else "", words)


def _crossing_clips(params: Sequence[ClipParams]) -> bool:
    return any(map(_rightward, params))


def _rightward(params: ClipParams) -> bool:
    """Return whether a clip shows an object that moves rightward."""
    return getattr(params, "motion", "") == "rightward" and getattr(params, "object", "") != "absent"


def least_peak(rows: Rows, threshold: float | None) -> Measured:
    """Find the largest HS of a rightward crossing: of several crossings the lowest of their peaks.

    Parameters
    ----------
    rows
        Of ``trials.parquet`` of clips, of one model; rightward crossings of an object count.
    threshold
        The model's spiking threshold T.

    Returns
    -------
    Measured
        The potential. ``mark`` says where it does not pass T, as C6 asks of every crossing.
    """
    crossings = [row for row in rows if row["motion"] == "rightward" and row["object"] != "absent"]
    wrong = unreadable(crossings, POTENTIALS)
    if wrong or not crossings:
        return Measured(None, words=f"of the clips {wrong}" if wrong else "no rightward crossings")
    peak = {
        clip: min(row["peak_hs"] for row in clip_rows) for clip, clip_rows in group(crossings, "clip", "seed").items()
    }
    listed = ", ".join(f"{clip} at seed {seed}: {value:.3f}" for (clip, seed), value in peak.items())
    least = float(min(peak.values()))
    below = threshold is not None and least <= threshold
    return Measured(least, BELOW_THRESHOLD if below else "", f"peak HS of {listed}")


_SPEEDS = f"rightward crossings at {LEAST_SPEEDS} speeds or more, all else equal"
_ENTRIES = (
    Measure("peak-speed-potential", "speed at which mean HS near the axis is largest", "cm/s", "robot", _SPEEDS,
            _crossings, partial(peak_speed, column=judging.POTENTIAL)),
    Measure("peak-speed-count", "speed at which there are most spikes", "cm/s", "robot", _SPEEDS, _crossings,
            partial(peak_speed, column=judging.COUNT)),
    Measure("peak-hs", "largest HS of a crossing, of several the lowest", "", "clips",
            "clips of an object that moves rightward", _crossing_clips, least_peak),
)  # fmt: skip
MEASURES: Mapping[str, Measure] = {measure.name: measure for measure in _ENTRIES}
"""The measures by name."""

SPIKES = "spikes"
"""The measure that is one of each condition: the mean number of spikes in a trial."""


def spikes_in(conditions: Sequence[Condition]) -> list[Measure]:
    """Return a measure for each condition: the mean number of spikes in its trials, with its 95 % interval.

    Each is called by the columns in which conditions differ.
    """
    whole = list(dict.fromkeys(conditions))
    names = [name for name in CONDITION_COLUMNS if len({getattr(condition, name) for condition in whole}) > 1]
    return [
        Measure(
            f"{SPIKES}: {', '.join(f'{name}={_text(getattr(condition, name))}' for name in names)}"
            if names else SPIKES, "mean number of spikes in a trial", "", "robot", "that condition", lambda _: True,
            partial(mean_spikes, condition=tuple((name, getattr(condition, name)) for name in CONDITION_COLUMNS)),
            (condition.motion,), tuple((name, getattr(condition, name)) for name in CONDITION_COLUMNS),
        )
        for condition in whole
    ]  # fmt: skip


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float | int) else str(value)


def mean_spikes(rows: Rows, _threshold: float | None, *, condition: tuple[tuple[str, Any], ...]) -> Measured:
    """Find the mean number of spikes over the trials of one condition, and its 95 % interval.

    Parameters
    ----------
    rows
        Of ``trials.parquet``, of one model.
    condition
        Columns of the condition with their values.

    Returns
    -------
    Measured
        None of a model that does not spike, and where no trial has that condition.
    """
    trials = [row for row in rows if all(row[name] == value for name, value in condition)]
    spikes = [row["spikes"] for row in trials if row["spikes"] is not None]
    if not spikes:
        return Measured(None, words="no trial there" if not trials else "it does not spike", n=len(trials))
    summary = summarise(spikes, 0.0)
    return Measured(summary.mean, n=len(trials), low=known(summary.ci_low), high=known(summary.ci_high))
