"""Scores of a setting: the slack of each claim in each replicate, in smallest differences; or measures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from experiments.bench.stats.checks import MARGIN, Check
from experiments.bench.stats.count import Count, count
from experiments.bench.stats.verdict import Outcome, together
from experiments.bench.studies.fitting.box import Setting
from experiments.bench.studies.fitting.fit import KEPT, Goal
from experiments.bench.sweep import Sweep

MOST = 100.0
"""Slack at which each claim is clipped, in smallest differences. A claim that cannot be judged has it below 0."""


def slack(outcome: Outcome) -> float:
    """Return how far inside its bounds a claim lies in one replicate, in smallest differences.

    Parameters
    ----------
    outcome
        What its judge found.

    Returns
    -------
    float
        The least over its checks, from -`MOST` to `MOST`; -`MOST` where it could not be judged, so that a silent
        network gains nothing by silence.
    """
    if not outcome.judged or not outcome.checks:
        return -MOST
    return float(np.clip(min(_relative(check) for check in outcome.checks), -MOST, MOST))


def _relative(check: Check) -> float:
    """Return slack over smallest difference: that of potentials where the reading has no unit, else 1 of the unit."""
    smallest = MARGIN["spikes"] if check.unit else MARGIN["potential"]
    return -MOST if np.isnan(check.slack) else check.slack / smallest


@dataclass(frozen=True)
class Score:
    """The outcomes of one setting's claims, and their slacks.

    Parameters
    ----------
    setting
        The setting.
    outcomes
        Id of a claim -> its outcome in each replicate.
    """

    setting: Setting
    outcomes: Mapping[str, tuple[Outcome, ...]]

    @cached_property
    def slacks(self) -> dict[str, tuple[float, ...]]:
        """Id of a claim -> its slack in each replicate."""
        return {claim: tuple(map(slack, outcomes)) for claim, outcomes in self.outcomes.items()}

    @cached_property
    def least(self) -> tuple[float, ...]:
        """The least slack over the claims, in each replicate."""
        return tuple(min(column) for column in zip(*self.slacks.values(), strict=True))

    @property
    def value(self) -> float:
        """The least slack over claims and replicates: what is searched for."""
        return min(self.least)

    @property
    def kept(self) -> int:
        """The number of claims that hold in every replicate."""
        return sum(map(self.holds_claim, self.outcomes))

    def rank(self, goal: Goal) -> tuple[float, float, float]:
        """Return the key that settings are sorted by: whether all holds, the goal, and the mean slack of the claims.

        Parameters
        ----------
        goal
            The least slack, or the number of claims kept.
        """
        mean = float(np.mean([slack for slacks in self.slacks.values() for slack in slacks]))
        return float(self.holds), self.searched((goal,))[0], mean

    def searched(self, goals: Sequence[Goal]) -> tuple[float, ...]:
        """Return what the search makes large, for each goal."""
        return tuple(float(self.kept) if goal.name == KEPT else self.value for goal in goals)

    @property
    def numbers(self) -> dict[str, float]:
        """Id of a claim -> its least slack over the replicates."""
        return {claim: min(slacks) for claim, slacks in self.slacks.items()}

    def holds_claim(self, claim: str) -> bool:
        """Tell whether a claim holds in every replicate."""
        return all(outcome.verdict == "holds" for outcome in self.outcomes[claim])

    @property
    def holds(self) -> bool:
        """True if every claim holds in every replicate."""
        return all(map(self.holds_claim, self.outcomes))

    def count(self, claim: str = "") -> Count:
        """Return in how many replicates a claim holds; without one, all claims together."""
        columns = [self.outcomes[claim]] if claim else list(self.outcomes.values())
        return count(together([outcome.verdict for outcome in column]) for column in zip(*columns, strict=True))


@dataclass(frozen=True)
class Reading:
    """The measures of one setting.

    Parameters
    ----------
    setting
        The setting.
    measured
        Name of a measure -> its value in each replicate, NaN where it has none.
    """

    setting: Setting
    measured: Mapping[str, tuple[float, ...]]

    def known(self, name: str) -> list[float]:
        """Return the values of a measure in the replicates that have one."""
        return [value for value in self.measured[name] if np.isfinite(value)]

    @property
    def numbers(self) -> dict[str, float]:
        """Name of a measure -> its mean over the replicates; NaN where one of them has no value."""
        return {name: float(np.mean(values)) for name, values in self.measured.items()}

    def searched(self, goals: Sequence[Goal]) -> tuple[float, ...]:
        """Return what the search makes large, for each goal; NaN where there is no value."""
        return tuple(goal.signed(self.numbers[goal.name]) for goal in goals)


def scores(result: Sweep, settings: Mapping[str, Setting]) -> list[Score]:
    """Return the score of each setting, from a sweep.

    Parameters
    ----------
    result
        Of a study with one axis.
    settings
        Label of a level of that axis -> the setting; the scores are in this order.
    """
    outcomes: dict[str, dict[str, tuple[Outcome, ...]]] = {label: {} for label in settings}
    for (point, _, claim), found in result.outcomes.items():
        outcomes[point[0][1]][claim] = found
    return [Score(setting, outcomes[label]) for label, setting in settings.items()]


def readings(result: Sweep, goals: Sequence[Goal], settings: Mapping[str, Setting]) -> list[Reading]:
    """Return the measures of each setting, from a sweep.

    Parameters
    ----------
    result
        Of a study with one axis.
    goals
        Names of its measures.
    settings
        Label of a level of that axis -> the setting; the readings are in this order.
    """
    by_name = {measure.name: (measure, experiment) for measure, experiment in result.plan.measures}
    values: dict[str, dict[str, tuple[float, ...]]] = {label: {} for label in settings}
    for point, model in result.plan.judged:
        for goal in goals:
            replicates = result.values(*by_name[goal.name], point, model)
            values[point[0][1]][goal.name] = tuple(np.nan if value is None else value for value in replicates)
    return [Reading(setting, values[label]) for label, setting in settings.items()]


def word(counted: Count) -> str:
    """Return the word of a count, where a claim that holds is ``fitted``: its parameters were chosen to keep it."""
    return "fitted" if counted.word == "holds" else counted.label
